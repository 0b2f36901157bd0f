#include "environment/environment_entries.h"

#include <gtest/gtest.h>

#include "tests/environment/query_builder.h"

namespace espalier::environment::environment_entries_test {
namespace {

std::vector<EnvironmentEntry> entriesOf(std::string_view text) {
  const auto result = parseEnvironmentEntries(text);
  EXPECT_EQ(errorsOf(result), "");
  return result.value_or(std::vector<EnvironmentEntry>{});
}

TEST(EnvironmentEntries, OneObjectIsOneEnvironmentNamedByItsType) {
  const auto entries = entriesOf(R"({"type":"honda","radius":0.5})");
  ASSERT_EQ(entries.size(), 1U);
  EXPECT_EQ(entries[0].type, "honda");
  EXPECT_EQ(entries[0].name, "honda");
  EXPECT_EQ(entries[0].configuration, R"({"radius":0.5})");
}

TEST(EnvironmentEntries, AListKeepsItsOrderAndNames) {
  const auto entries = entriesOf(
      R"([{"type":"shadow","name":"Light"},{"type":"offered","name":"mylight"},{"type":"tcp","address":"h:1"}])");
  ASSERT_EQ(entries.size(), 3U);
  EXPECT_EQ(entries[0].type, "shadow");
  EXPECT_EQ(entries[0].name, "Light");
  EXPECT_EQ(entries[0].configuration, "{}");
  EXPECT_EQ(entries[1].type, "offered");
  EXPECT_EQ(entries[1].name, "mylight");
  EXPECT_EQ(entries[2].configuration, R"({"address":"h:1"})");
  EXPECT_TRUE(entriesOf("[]").empty());
}

TEST(EnvironmentEntries, ConfigurationKeepsNumbersExactly) {
  const auto entries = entriesOf(R"({"type":"honda","radius":0.1})");
  EXPECT_EQ(entries[0].configuration, R"({"radius":0.1})");
}

TEST(EnvironmentEntries, ErrorsNameTheEntryAndTheKey) {
  constexpr const char* kHint = "\n   hint: an environment is written as {\"type\":\"honda\",\"radius\":0.5}";
  EXPECT_EQ(errorsOf(parseEnvironmentEntries(R"({"radius":1})")),
            std::string("error: environment has no 'type'") + kHint);
  EXPECT_EQ(errorsOf(parseEnvironmentEntries(R"({"tpye":"honda","radius":1})")),
            "error: environment has no 'type'\n"
            "   hint: is 'tpye' the 'type'? an environment is written as {\"type\":\"honda\",\"radius\":0.5}");
  EXPECT_EQ(errorsOf(parseEnvironmentEntries(R"([{"type":"honda"},{"type":3}])")),
            std::string("error: environment[1]: 'type' must be a text, found the number 3") + kHint);
  EXPECT_EQ(errorsOf(parseEnvironmentEntries(R"({"type":"honda","name":""})")),
            std::string("error: environment: 'name' is empty") + kHint);
  EXPECT_EQ(errorsOf(parseEnvironmentEntries(R"([7])")),
            std::string("error: environment[0] must be an object, found the number 7") + kHint);
  EXPECT_EQ(errorsOf(parseEnvironmentEntries(R"("honda")")),
            std::string("error: environment must be an object or a list of objects, found the text 'honda'") + kHint);
}

TEST(EnvironmentEntries, TwoOfOneNameAreAnError) {
  EXPECT_EQ(errorsOf(parseEnvironmentEntries(R"([{"type":"honda"},{"type":"shadow","name":"Honda"}])")),
            "error: environment[1]: another environment is named 'honda' already\n"
            "   hint: give one of them another 'name': a model addresses it as ?Name(...)");
}

TEST(EnvironmentEntries, BrokenJsonIsLocated) {
  const std::string text = errorsOf(parseEnvironmentEntries("{\"type\":}"));
  EXPECT_EQ(text.substr(0, text.find(':', 30)), "environment:1:9: error: the environment is not valid JSON") << text;
}

}  // namespace
}  // namespace espalier::environment::environment_entries_test
