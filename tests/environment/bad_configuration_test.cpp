// Wrong configurations of every process and the messages about them. A process is made, opened and asked; one of the
// three must give the message.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "tests/environment/candidates.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::bad_configuration_test {
namespace {

/// The message of making, opening or asking the process.
std::string saidBy(const BadConfiguration& bad) {
  auto made = makeProcess(bad.name, bad.configuration);
  if (!made) {
    std::string text;
    for (const core::Diagnostic& problem : made.error()) {
      text += problem.message + "\n" + problem.hint + "\n";
      EXPECT_FALSE(problem.message.empty());
      EXPECT_NE(problem.message.find(bad.name), std::string::npos) << problem.message;
    }
    return text;
  }
  const auto& process = made.value();
  if (const auto error = process->open({})) {
    return error->message;
  }
  QueryBuilder builder;
  builder.add({0.5, 0.5, 0.5}, bad.parameters);
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  const auto error = process->step(builder.batch(), replies);
  return error ? error->message : "nothing";
}

TEST(BadConfiguration, IsNamedWithTheProcessTheKeyAndWhatIsExpected) {
  for (const BadConfiguration& bad : badConfigurations()) {
    const std::string said = saidBy(bad);
    EXPECT_NE(said.find(bad.said), std::string::npos) << bad.name << " " << bad.configuration << " says: " << said;
  }
}

TEST(BadConfiguration, IsTriedOnEveryProcess) {
  std::set<std::string> tried;
  for (const BadConfiguration& bad : badConfigurations()) {
    tried.insert(bad.name);
  }
  for (const std::string& name : processNames()) {
    EXPECT_TRUE(tried.contains(name)) << "tests/environment/processes/" << name << ".json has no \"wrong\"";
  }
}

TEST(ConfigurationSchema, HasEveryKeyThatIsReadAndNoOther) {
  for (const std::string& name : processNames()) {
    const auto schema = nlohmann::json::parse(configurationSchema(name));
    for (const auto& [key, property] : schema["properties"].items()) {
      EXPECT_FALSE(property["description"].get<std::string>().empty()) << name << " " << key;
      EXPECT_TRUE(property.contains("default")) << name << " " << key;
      // an object is the value of no key: its refusal by name shows that the key is read
      nlohmann::json wrong = {{key, {{"an", "object"}}}};
      auto made = makeProcess(name, wrong.dump());
      ASSERT_FALSE(made.has_value()) << name << " " << key;
      EXPECT_NE(made.error().front().message.find("'" + key + "' must be"), std::string::npos)
          << made.error().front().message;
      // its default is a value that it takes
      made = makeProcess(name, nlohmann::json{{key, property["default"]}}.dump());
      EXPECT_EQ(errorsOf(made), "") << name << " " << key;
    }
    auto made = makeProcess(name, R"({"noSuchKey":1})");
    ASSERT_FALSE(made.has_value()) << name;
    EXPECT_NE(made.error().front().message.find("unknown key 'noSuchKey'"), std::string::npos);
  }
}

}  // namespace
}  // namespace espalier::environment::bad_configuration_test
