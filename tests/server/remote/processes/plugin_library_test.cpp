#include "server/remote/processes/plugin_library.h"

#include <gtest/gtest.h>

#include "environment/plugin_process.h"
#include "tests/support/places.h"

namespace espalier::server::plugin_library_test {
namespace {

using Process = std::unique_ptr<turtle::EnvironmentProcess>;

const std::string kCeiling = buildFolder() + "/lib/ceiling.so";

Process load(const std::string& configuration) {
  auto loaded = loadPluginProcess(kCeiling, configuration);
  if (!loaded) {
    ADD_FAILURE() << loaded.error();
    return nullptr;
  }
  return std::move(loaded.value());
}

std::string problemOf(const std::string& library, const std::string& configuration = "") {
  auto loaded = loadPluginProcess(library, configuration);
  return loaded ? std::string("loaded") : loaded.error();
}

// two queries with one parameter each, at the heights 1 and 2.5, and one without parameters
turtle::QueryBatch queriesAt(std::uint64_t step) {
  turtle::QueryBatch queries;
  queries.step = step;
  queries.plant = {0, 0, 0};
  queries.module = {1, 4, 7};
  queries.symbol = {0, 0, 0};
  queries.position = {{9.0, 1.0, 9.0}, {9.0, 2.5, 9.0}, {9.0, 0.0, 9.0}};
  queries.parameterOffset = {0, 1, 2, 2};
  queries.parameters = {0.5, 0.5};
  return queries;
}

std::vector<double> answersOf(turtle::EnvironmentProcess& process, std::uint64_t step) {
  const turtle::QueryBatch queries = queriesAt(step);
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  const auto error = process.step(queries, replies);
  EXPECT_FALSE(error.has_value()) << error->message;
  EXPECT_EQ(replies.answeredCount, 2U);
  EXPECT_EQ(replies.isSet, (std::vector<std::uint8_t>{1, 1}));
  return replies.values;
}

TEST(PluginLibrary, DescribesAndAnswers) {
  const Process ceiling = load("");
  ASSERT_NE(ceiling, nullptr);
  const auto description = ceiling->describe();
  EXPECT_EQ(description.name, "ceiling");
  EXPECT_TRUE(description.needs.position);
  EXPECT_FALSE(description.needs.heading);
  EXPECT_TRUE(description.isStateful);
  ASSERT_EQ(description.outputs.size(), 1U);
  EXPECT_EQ(description.outputs[0].name, "mayGrow");
  EXPECT_FALSE(ceiling->open({}).has_value());
  EXPECT_EQ(answersOf(*ceiling, 0), (std::vector<double>{1.0, 1.0}));
}

TEST(PluginLibrary, ItsConfigurationReachesIt) {
  const Process ceiling = load(R"({"height":2})");
  ASSERT_NE(ceiling, nullptr);
  EXPECT_EQ(answersOf(*ceiling, 0), (std::vector<double>{1.0, 0.0}));
}

TEST(PluginLibrary, StateIsSavedRestoredAndRewound) {
  // 3, 2.75, 2.5: the second query, at 2.5, is refused from the third step on
  const Process ceiling = load(R"({"height":3,"sinking":0.25})");
  ASSERT_NE(ceiling, nullptr);
  EXPECT_FALSE(ceiling->open({}).has_value());
  EXPECT_EQ(answersOf(*ceiling, 0), (std::vector<double>{1.0, 1.0}));
  const std::string saved = ceiling->save();
  EXPECT_FALSE(ceiling->tick(1).has_value());
  EXPECT_EQ(answersOf(*ceiling, 2), (std::vector<double>{1.0, 0.0}));
  EXPECT_FALSE(ceiling->restore(saved).has_value());
  EXPECT_EQ(answersOf(*ceiling, 1), (std::vector<double>{1.0, 1.0}));
  EXPECT_FALSE(ceiling->open({}).has_value());
  EXPECT_EQ(answersOf(*ceiling, 0), (std::vector<double>{1.0, 1.0}));
  const auto error = ceiling->restore("xy");
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message, "environment plug-in 'ceiling' failed in restore: a state of 2 bytes instead of 8");
}

TEST(PluginLibrary, ItsErrorsNameIt) {
  const Process ceiling = load(R"({"height":1,"sinking":2})");
  ASSERT_NE(ceiling, nullptr);
  (void)answersOf(*ceiling, 0);
  const turtle::QueryBatch queries = queriesAt(1);
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  const auto error = ceiling->step(queries, replies);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message,
            "environment plug-in 'ceiling' failed in step: the ceiling has reached the ground after 1 steps; take a "
            "smaller 'sinking'");
}

TEST(PluginLibrary, RefusesWhatIsNoPlugin) {
  EXPECT_EQ(problemOf(kCeiling, R"({"height":"high"})"),
            "the plug-in '" + kCeiling +
                "' cannot be used: 'ceiling' refuses its configuration: 'height' and 'sinking' are numbers.");
  EXPECT_NE(problemOf("nowhere.so").find("the plug-in 'nowhere.so' cannot be loaded ("), std::string::npos);
  // a library that is there and has no entry
  EXPECT_NE(problemOf("libm.so.6").find("cannot be loaded"), std::string::npos) << "only files are meant, not names";
}

TEST(PluginProcess, RefusesTablesThatItCannotUse) {
  const auto problem = [](const espalier_plugin& table) {
    const auto made = environment::makePluginProcess(table, nullptr, "");
    return made ? std::string("made") : made.error();
  };
  espalier_plugin table{};
  table.version = 2;
  EXPECT_EQ(problem(table),
            "it has version 2 of the plug-in interface, and this program has version 1: compile it with this program's "
            "environment/plugin.h");
  table.version = ESPALIER_PLUGIN_VERSION;
  table.size = 8;
  EXPECT_NE(problem(table).find("its table has 8 bytes instead of"), std::string::npos);
  table.size = sizeof(espalier_plugin);
  EXPECT_EQ(problem(table), "its table lacks a name");
  table.name = "x";
  EXPECT_EQ(problem(table), "its table lacks create, destroy and step");
  table.create = [](const char*, char*, std::size_t) -> void* { return nullptr; };
  table.destroy = [](void*) {};
  table.step = [](void*, const espalier_queries*, espalier_replies*, char*, std::size_t) { return 0; };
  table.is_stateful = 1;
  EXPECT_EQ(problem(table), "its table lacks save and restore, which it needs because it has a state");
  table.is_stateful = 0;
  EXPECT_EQ(problem(table), "'x' refuses its configuration: it did not say why");
  static int instance = 0;
  table.create = [](const char*, char*, std::size_t) -> void* { return &instance; };
  EXPECT_EQ(problem(table), "made");
}

}  // namespace
}  // namespace espalier::server::plugin_library_test
