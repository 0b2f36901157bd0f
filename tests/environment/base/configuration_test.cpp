#include "environment/base/configuration.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/environment/query_builder.h"

namespace espalier::environment::configuration_test {
namespace {

constexpr std::array<std::string_view, 2> kModes{"fast", "exact"};
constexpr std::array kStart{1.0, 2.0};
constexpr std::array kKeys{
    ConfigurationKey{.name = "radius", .description = "how far", .minimum = 0.0, .defaultNumber = 2.5},
    ConfigurationKey{.name = "part", .description = "how much", .minimum = 0.0, .maximum = 1.0},
    ConfigurationKey{
        .name = "span", .description = "how wide", .minimum = 0.0, .isMinimumExclusive = true, .defaultNumber = 1},
    ConfigurationKey{.name = "count", .kind = KeyKind::Integer, .description = "how many", .maximum = 9},
    ConfigurationKey{.name = "isOpen", .kind = KeyKind::Boolean, .description = "whether", .defaultNumber = 1},
    ConfigurationKey{
        .name = "mode", .kind = KeyKind::Choice, .description = "which", .defaultText = "exact", .choices = kModes},
    ConfigurationKey{.name = "title", .kind = KeyKind::Text, .description = "what", .defaultText = "none"},
    ConfigurationKey{.name = "start",
                     .kind = KeyKind::Numbers,
                     .description = "where",
                     .defaultNumbers = kStart,
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{
        .name = "sources", .kind = KeyKind::Rows, .description = "from where", .minimumCount = 1, .maximumCount = 3},
};

std::string errorsOfText(std::string_view json) {
  const auto result = readConfiguration("demo", kKeys, json);
  std::string text;
  if (!result) {
    for (const ConfigurationError& error : result.error()) {
      text += (text.empty() ? "" : "\n") + core::formatDiagnostic(error.diagnostic);
    }
  }
  return text;
}

TEST(Configuration, EmptyTextGivesTheDefaults) {
  for (const std::string_view text : {"", " \n", "{}"}) {
    const auto result = readConfiguration("demo", kKeys, text);
    const auto& configuration = result.value();
    EXPECT_EQ(configuration.number("radius"), 2.5);
    EXPECT_EQ(configuration.integer("count"), 0);
    EXPECT_TRUE(configuration.flag("isOpen"));
    EXPECT_EQ(configuration.text("mode"), "exact");
    EXPECT_EQ(configuration.numbers("start"), (std::vector<double>{1.0, 2.0}));
    EXPECT_TRUE(configuration.rows("sources").empty());
    EXPECT_FALSE(configuration.isGiven("radius"));
  }
}

TEST(Configuration, ReadsEveryKindOfValue) {
  const auto result = readConfiguration(
      "demo", kKeys,
      R"({"radius":1,"count":3.0,"isOpen":false,"mode":"fast","title":"x","start":[0.1,-2],"sources":[[1],[2,3,4]]})");
  const auto& configuration = result.value();
  EXPECT_EQ(configuration.number("radius"), 1.0);
  EXPECT_EQ(configuration.integer("count"), 3);
  EXPECT_FALSE(configuration.flag("isOpen"));
  EXPECT_EQ(configuration.text("mode"), "fast");
  EXPECT_EQ(configuration.text("title"), "x");
  EXPECT_EQ(configuration.numbers("start"), (std::vector<double>{0.1, -2.0}));
  EXPECT_EQ(configuration.rows("sources"), (ConfigurationRows{{1.0}, {2.0, 3.0, 4.0}}));
  EXPECT_TRUE(configuration.isGiven("radius"));
  EXPECT_FALSE(configuration.isGiven("part"));
}

TEST(Configuration, WrittenValuesReadBackExactly) {
  const ConfigurationValues values{{"radius", 0.1},
                                   {"isOpen", false},
                                   {"start", std::vector<double>{1.0 / 3.0, 1e-300}},
                                   {"sources", ConfigurationRows{{0.3}}}};
  const auto result = readConfiguration("demo", kKeys, writeConfiguration(values));
  const auto& configuration = result.value();
  EXPECT_EQ(configuration.number("radius"), 0.1);
  EXPECT_EQ(configuration.numbers("start"), (std::vector<double>{1.0 / 3.0, 1e-300}));
  EXPECT_EQ(configuration.rows("sources"), (ConfigurationRows{{0.3}}));
}

TEST(Configuration, UnknownKeyNamesTheNearest) {
  EXPECT_EQ(
      errorsOfText(R"({"raduis": 1})"),
      "error: environment process 'demo': unknown key 'raduis'\n"
      "   hint: Did you mean 'radius'? Available: count, isOpen, mode, part, radius, sources, span, start, title.");
}

TEST(Configuration, NoNumberIsSoLargeThatItsPowersAreInfinite) {
  EXPECT_EQ(errorsOfText(R"({"start":[0,-1e31]})"),
            "error: environment process 'demo': 'start[1]' must be between -1.0e+30 and 1.0e+30, found -1.0e+31\n"
            "   hint: start: where");
  EXPECT_EQ(errorsOfText(R"({"start":[1e30,-1e30]})"), "");
  // a length that is divided by is not so small that its quotients are
  constexpr std::array kSizes{ConfigurationKey{
      .name = "size", .description = "how wide", .minimum = 0.0, .isMinimumExclusive = true, .defaultNumber = 1.0}};
  const auto tiny = readConfiguration("demo", kSizes, R"({"size":1e-31})");
  ASSERT_FALSE(tiny.has_value());
  EXPECT_EQ(tiny.error().front().diagnostic.message,
            "environment process 'demo': 'size' must be at least 1.0e-30, found 1.0e-31");
  EXPECT_TRUE(readConfiguration("demo", kSizes, R"({"size":1e-30})").has_value());
}

TEST(Configuration, WrongTypesNameThePathAndWhatWasFound) {
  EXPECT_EQ(
      errorsOfText(R"({"radius":"big"})"),
      "error: environment process 'demo': 'radius' must be a number, found the text 'big'\n   hint: radius: how far");
  EXPECT_EQ(errorsOfText(R"({"count":1.5})"),
            "error: environment process 'demo': 'count' must be a whole number, found the number 1.5\n"
            "   hint: count: how many");
  EXPECT_EQ(errorsOfText(R"({"isOpen":1})"),
            "error: environment process 'demo': 'isOpen' must be true or false, found the number 1\n"
            "   hint: isOpen: whether");
  EXPECT_EQ(
      errorsOfText(R"({"mode":[]})"),
      "error: environment process 'demo': 'mode' must be one of 'fast', 'exact', found a list\n   hint: mode: which");
  EXPECT_EQ(errorsOfText(R"({"title":null})"),
            "error: environment process 'demo': 'title' must be a text, found null\n   hint: title: what");
  EXPECT_EQ(errorsOfText(R"({"start":[1,true]})"),
            "error: environment process 'demo': 'start[1]' must be a number, found true\n   hint: start: where");
  EXPECT_EQ(errorsOfText(R"({"start":{}})"),
            "error: environment process 'demo': 'start' must be a list of 2 numbers, found an object\n"
            "   hint: start: where");
  EXPECT_EQ(errorsOfText(R"({"sources":[[1],[2,"x"]]})"),
            "error: environment process 'demo': 'sources[1][1]' must be a number, found the text 'x'\n"
            "   hint: sources: from where");
  // one message for a list
  EXPECT_EQ(
      errorsOfText(R"({"start":["a","b"]})"),
      "error: environment process 'demo': 'start[0]' must be a number, found the text 'a'\n   hint: start: where");
  EXPECT_EQ(errorsOfText(R"({"sources":[1,0.08,3]})"),
            "error: environment process 'demo': 'sources' must be a list of lists of 1 to 3 numbers, found a list of "
            "numbers\n   hint: write [[1, …]]. sources: from where");
  EXPECT_EQ(
      errorsOfText(R"({"sources":3})"),
      "error: environment process 'demo': 'sources' must be a list of lists of 1 to 3 numbers, found the number 3\n"
      "   hint: sources: from where");
}

TEST(Configuration, ValuesOutOfRangeNameTheRange) {
  EXPECT_EQ(errorsOfText(R"({"radius":-1})"),
            "error: environment process 'demo': 'radius' must be at least 0, found -1\n   hint: radius: how far");
  EXPECT_EQ(errorsOfText(R"({"part":1.5})"),
            "error: environment process 'demo': 'part' must be between 0 and 1, found 1.5\n   hint: part: how much");
  EXPECT_EQ(errorsOfText(R"({"span":0})"),
            "error: environment process 'demo': 'span' must be greater than 0, found 0\n   hint: span: how wide");
  EXPECT_EQ(errorsOfText(R"({"count":10})"),
            "error: environment process 'demo': 'count' must be at most 9, found 10\n   hint: count: how many");
  EXPECT_EQ(errorsOfText(R"({"start":[1]})"),
            "error: environment process 'demo': 'start' must be a list of 2 numbers, found 1\n   hint: start: where");
  EXPECT_EQ(errorsOfText(R"({"mode":"exakt"})"),
            "error: environment process 'demo': 'mode' must be one of 'fast', 'exact', found 'exakt'\n"
            "   hint: Did you mean 'exact'? Available: fast, exact.");
}

TEST(Configuration, AllErrorsOfATextAreReported) {
  const auto result = readConfiguration("demo", kKeys, R"({"radius":-1,"count":"a","x":1})");
  EXPECT_EQ(result.error().size(), 3U);
}

TEST(Configuration, BrokenJsonIsLocated) {
  const std::string text = errorsOfText("{\n  \"radius\": 1,\n  ]\n}");
  EXPECT_EQ(text.substr(0, 98),
            "configuration:3:3: error: environment process 'demo': the configuration is not valid JSON: unexpec")
      << text;
  EXPECT_NE(text.find("    3 |   ]\n"), std::string::npos) << text;
}

TEST(Configuration, AKeyWrittenTwiceIsAnError) {
  const std::string text = errorsOfText(R"({"radius":1, "radius":2})");
  EXPECT_EQ(text.substr(0, text.find('\n')),
            "configuration:1:14: error: environment process 'demo': the configuration has the key 'radius' twice");
}

TEST(Configuration, MustBeAnObject) {
  EXPECT_EQ(errorsOfText("[1]"),
            "error: environment process 'demo': the configuration must be an object of keys and values, found a list");
}

}  // namespace
}  // namespace espalier::environment::configuration_test
