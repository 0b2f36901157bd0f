#include "environment/base/published_text.h"

#include <gtest/gtest.h>

namespace espalier::environment::published_text_test {
namespace {

TEST(PublishedText, SplitsKeywordsAtTheColonAndKeepsThemExactly) {
  std::vector<core::Diagnostic> warnings;
  const auto lines = readPublishedLines("m.spec", "radius: 1.5 \r\n\n3d case:on\n odd : a:b\n", warnings);
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0].keyword, "radius");
  EXPECT_EQ(lines[0].value, "1.5");
  EXPECT_EQ(lines[1].keyword, "3d case");
  EXPECT_EQ(lines[1].value, "on");
  EXPECT_EQ(lines[1].location.line, 3U);
  EXPECT_EQ(lines[2].keyword, " odd ");
  EXPECT_EQ(lines[2].value, "a:b");
  EXPECT_TRUE(warnings.empty());
}

TEST(PublishedText, ATabEndsAKeywordToo) {
  std::vector<core::Diagnostic> warnings;
  const auto lines = readPublishedLines("m.e", "executable\thonda81 -e x:y\n", warnings);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].keyword, "executable");
  EXPECT_EQ(lines[0].value, "honda81 -e x:y");
}

TEST(PublishedText, EveryEncodingOfAModelIsRead) {
  const std::string plain = "grid size: 2\nradius: 3\n";
  std::string utf16 = "\xFF\xFE";
  for (const char c : plain) {
    utf16 += c;
    utf16 += '\0';
  }
  for (const std::string& text : {"\xEF\xBB\xBF" + plain, std::string("grid size: 2\rradius: 3\r"), utf16}) {
    std::vector<core::Diagnostic> warnings;
    const auto lines = readPublishedLines("a.e", text, warnings);
    ASSERT_EQ(lines.size(), 2U);
    EXPECT_EQ(lines[0].keyword, "grid size");
    EXPECT_EQ(lines[1].location.line, 2U);
    EXPECT_TRUE(warnings.empty());
  }
}

TEST(PublishedText, LinesOfNumbersBelongToTheKeywordAbove) {
  std::vector<core::Diagnostic> warnings;
  const auto lines =
      readPublishedLines("m.spec", "array: 2 2\n0.5 0.9\n  -.2:4\nname: x\n3d case: on\n4x view: 1\n", warnings);
  // a word that only begins with a number begins a keyword; one that is a number does not
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_EQ(lines[0].data, (std::vector<std::string>{"0.5 0.9", "-.2:4"}));
  EXPECT_EQ(lines[0].dataLocations[1].line, 3U);
  EXPECT_EQ(lines[0].dataLocations[1].column, 3U);
  EXPECT_EQ(lines[2].keyword, "3d case");
  EXPECT_EQ(lines[2].data, std::vector<std::string>{"4x view: 1"});
  EXPECT_TRUE(warnings.empty());
}

TEST(PublishedText, WarnsOfLinesWithoutAKeyword) {
  std::vector<core::Diagnostic> warnings;
  EXPECT_TRUE(readPublishedLines("m.spec", "\nhello\n", warnings).empty());
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(core::formatDiagnostic(warnings[0]),
            "m.spec:2:1: warning: line without a keyword is ignored\n    2 | hello\n      | ^~~~~\n"
            "   hint: expected 'keyword: values'");
}

TEST(PublishedText, CutsLongLinesWithAWarning) {
  std::vector<core::Diagnostic> warnings;
  const std::string value(300, '7');
  const auto lines = readPublishedLines("m.spec", "a: " + value, warnings);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].value.size(), 251U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].message, "line longer than 254 characters: the rest is ignored");
  EXPECT_EQ(warnings[0].location.column, 254U);
  std::vector<core::Diagnostic> none;
  EXPECT_EQ(readPublishedLines("m.spec", "a: " + value.substr(0, 251), none)[0].value.size(), 251U);
  EXPECT_TRUE(none.empty());
}

TEST(PublishedText, NumbersAreSeparatedAsInPublishedFiles) {
  EXPECT_EQ(readPublishedNumbers("10x20 ,3;4:5\t-6e1 +.5"), (std::vector<double>{10, 20, 3, 4, 5, -60, 0.5}));
  EXPECT_TRUE(readPublishedNumbers(" x ").empty());
}

TEST(PublishedText, AWordIsTheLongestNumberAtItsBeginning) {
  const std::vector<std::pair<std::string, double>> words{
      {"100view", 100}, {"8.", 8},  {"half", 0}, {"0.5m", 0.5},  {"-3.5e2y", -350}, {"1e", 1},  {"1e+", 1},
      {"2.5.7", 2.5},   {"+4", 4},  {"-", 0},    {".", 0},       {".e3", 0},        {"--1", 0}, {"1e2.5", 100},
      {"inf", 0},       {"nan", 0}, {"5-6", 5},  {"-.5z", -0.5}, {"0E1", 0}};
  for (const auto& [word, value] : words) {
    EXPECT_EQ(readPublishedNumbers(word), std::vector<double>{value}) << word;
  }
  EXPECT_EQ(readPublishedNumbers("100x100view"), (std::vector<double>{100, 100}));
  bool areWhole = true;
  EXPECT_EQ(readPublishedNumbers("1, 8.;-2e3", &areWhole), (std::vector<double>{1, 8, -2000}));
  EXPECT_TRUE(areWhole);
  EXPECT_EQ(readPublishedNumbers("1 0.5m", &areWhole), (std::vector<double>{1, 0.5}));
  EXPECT_FALSE(areWhole);
}

TEST(PublishedText, TheWordOfASwitchIsTheFirst) {
  EXPECT_EQ(firstPublishedWord(" on, please"), "on");
  EXPECT_EQ(firstPublishedWord("one"), "one");
  EXPECT_EQ(firstPublishedWord(" \t"), "");
}

TEST(PublishedText, FilesLieBesideTheFileThatNamesThem) {
  EXPECT_EQ(besideFile("models/tree/model.e", "model.spec"), "models/tree/model.spec");
  EXPECT_EQ(besideFile("model.e", "model.spec"), "model.spec");
  EXPECT_EQ(besideFile("models/model.e", "/data/model.spec"), "/data/model.spec");
}

}  // namespace
}  // namespace espalier::environment::published_text_test
