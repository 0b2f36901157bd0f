#include "environment/registry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tests/environment/query_builder.h"

namespace espalier::environment::registry_test {
namespace {

TEST(Registry, NamesAreSortedAndWithoutAliases) {
  const auto names = processNames();
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
  for (const std::string name : {"constant", "height", "honda", "shadow"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  }
  EXPECT_EQ(std::find(names.begin(), names.end(), "honda81"), names.end());
}

TEST(Registry, EveryProcessIsMadeWithAllDefaultsAndDescribesItself) {
  for (const std::string& name : processNames()) {
    const auto process = openProcess(name, "");
    ASSERT_NE(process, nullptr);
    const auto description = process->describe();
    EXPECT_EQ(description.name, name);
    EXPECT_FALSE(description.summary.empty());
    EXPECT_EQ(description.summary.back(), '.') << name;
    EXPECT_EQ(process->save().empty(), !description.isStateful) << name;
    for (const auto& variable : description.outputs) {
      EXPECT_FALSE(variable.unit.empty()) << name << " " << variable.name;
    }
  }
}

TEST(Registry, PublishedNamesAreAliases) {
  EXPECT_EQ(openProcess("honda81", "")->describe().name, "honda");
  EXPECT_EQ(openProcess("shadowpyramid", "")->describe().name, "shadow");
}

TEST(Registry, EveryProcessSaysWhereItComesFrom) {
  for (const std::string& name : processNames()) {
    EXPECT_FALSE(sourceOf(name).empty()) << name;
  }
  EXPECT_NE(sourceOf("honda81").find("Honda, Tomlinson & Fisher 1981"), std::string::npos);
  EXPECT_EQ(aliasesOf("honda"), std::vector<std::string>{"honda81"});
  EXPECT_EQ(sourceOf("hodna"), "");
  EXPECT_TRUE(aliasesOf("hodna").empty());
}

TEST(Registry, TimeOfAnyProcessMayPassOnlyWithQueries) {
  // a substance that decays to half in a step
  const std::string keys = R"({"gridSize":[1,1,1],"initialConcentration":8,"decayRate":0.6931471805599453)";
  const auto after = [&](const std::string& more) {
    const auto process = openProcess("emission", keys + more + "}");
    EXPECT_FALSE(process->tick(0).has_value());
    EXPECT_FALSE(process->tick(1).has_value());
    return *answersOf(*process, QueryBuilder().add({0.5, 0.5, 0.5}, {0}).batch())[0][0];
  };
  EXPECT_NEAR(after(""), 2, 1e-12);
  EXPECT_NEAR(after(R"(,"tick":"always")"), 2, 1e-12);
  EXPECT_NEAR(after(R"(,"tick":"queries")"), 8, 1e-12);
  EXPECT_NE(errorsOf(makeProcess("honda", R"({"tick":"never"})")).find("'tick' must be one of"), std::string::npos)
      << errorsOf(makeProcess("honda", R"({"tick":"never"})"));
}

TEST(Registry, UnknownNameSuggestsTheNearestAndListsAll) {
  const std::string text = errorsOf(makeProcess("hodna", ""));
  EXPECT_NE(text.find("environment process 'hodna' is unknown. Did you mean 'honda'? Available: "), std::string::npos)
      << text;
  for (const std::string& name : processNames()) {
    EXPECT_NE(text.find(name), std::string::npos);
  }
}

TEST(Registry, SchemaIsJsonAndNamesEveryKeyWithUnitAndDefault) {
  for (const std::string& name : processNames()) {
    const auto schema = nlohmann::json::parse(configurationSchema(name));
    EXPECT_EQ(schema["title"], name);
    EXPECT_EQ(schema["additionalProperties"], false);
    for (const auto& [key, property] : schema["properties"].items()) {
      EXPECT_TRUE(property.contains("default")) << name << "." << key;
      EXPECT_TRUE(property.contains("description")) << name << "." << key;
    }
  }
  const auto honda = nlohmann::json::parse(configurationSchema("honda81"));
  EXPECT_EQ(honda["properties"]["radius"]["unit"], "length");
  EXPECT_EQ(honda["properties"]["radius"]["minimum"], 0.0);
  EXPECT_EQ(honda["properties"]["plane"]["default"], "xz");
  EXPECT_EQ(configurationSchema("nothing"), "");
}

TEST(Registry, TheDefaultsOfASchemaAreAValidConfiguration) {
  for (const std::string& name : processNames()) {
    const auto schema = nlohmann::json::parse(configurationSchema(name));
    nlohmann::json configuration = nlohmann::json::object();
    for (const auto& [key, property] : schema["properties"].items()) {
      configuration[key] = property["default"];
    }
    EXPECT_EQ(errorsOf(makeProcess(name, configuration.dump())), "") << name;
  }
}

TEST(Registry, CanonicalNamesResolveAliases) {
  EXPECT_EQ(canonicalName("honda81"), "honda");
  EXPECT_EQ(canonicalName("shadow"), "shadow");
  EXPECT_EQ(canonicalName("nothing"), "nothing");
}

}  // namespace
}  // namespace espalier::environment::registry_test
