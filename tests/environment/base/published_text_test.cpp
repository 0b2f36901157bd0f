#include "environment/base/published_text.h"

#include <gtest/gtest.h>

namespace espalier::environment {
namespace {

TEST(PublishedText, SplitsKeywordsAtTheColonAndKeepsThemExactly) {
  std::vector<core::Diagnostic> warnings;
  const auto lines = readPublishedLines("m.spec", "radius: 1.5 \r\n\n3d case:on\n odd : a:b\n",
                                        PublishedSyntax::Specification, warnings);
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

TEST(PublishedText, EnvironmentFilesAlsoSplitAtATab) {
  std::vector<core::Diagnostic> warnings;
  const auto lines = readPublishedLines("m.e", "executable\thonda81 -e x:y\n", PublishedSyntax::Environment, warnings);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].keyword, "executable");
  EXPECT_EQ(lines[0].value, "honda81 -e x:y");
}

TEST(PublishedText, LinesOfNumbersBelongToTheKeywordAbove) {
  std::vector<core::Diagnostic> warnings;
  const auto lines =
      readPublishedLines("m.spec", "array: 2 2\n0.5 0.9\n  -.2:4\nname: x\n", PublishedSyntax::Specification, warnings);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].data, (std::vector<std::string>{"0.5 0.9", "-.2:4"}));
  EXPECT_TRUE(warnings.empty());
}

TEST(PublishedText, WarnsOfLinesWithoutAKeyword) {
  std::vector<core::Diagnostic> warnings;
  EXPECT_TRUE(readPublishedLines("m.spec", "\nhello\n", PublishedSyntax::Specification, warnings).empty());
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(core::formatDiagnostic(warnings[0]),
            "m.spec:2:1: warning: line without a keyword is ignored\n    2 | hello\n      | ^~~~~\n"
            "   hint: expected 'keyword: values'");
}

TEST(PublishedText, CutsLongLinesWithAWarning) {
  std::vector<core::Diagnostic> warnings;
  const std::string value(300, '7');
  const auto lines = readPublishedLines("m.spec", "a: " + value, PublishedSyntax::Specification, warnings);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].value.size(), 251U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].message, "line longer than 254 characters: the rest is ignored");
  EXPECT_EQ(warnings[0].location.column, 254U);
  std::vector<core::Diagnostic> none;
  EXPECT_EQ(
      readPublishedLines("m.spec", "a: " + value.substr(0, 251), PublishedSyntax::Specification, none)[0].value.size(),
      251U);
  EXPECT_TRUE(none.empty());
}

TEST(PublishedText, NumbersAreSeparatedAsInPublishedFiles) {
  EXPECT_EQ(readPublishedNumbers("10x20 ,3;4:5\t-6e1 +.5"), (std::vector<double>{10, 20, 3, 4, 5, -60, 0.5}));
  std::string_view rest;
  EXPECT_EQ(readPublishedNumbers(" 1 2 three 4", &rest), (std::vector<double>{1, 2}));
  EXPECT_EQ(rest, "three 4");
  EXPECT_TRUE(readPublishedNumbers(" x ").empty());
}

TEST(PublishedText, FilesLieBesideTheFileThatNamesThem) {
  EXPECT_EQ(besideFile("models/tree/model.e", "model.spec"), "models/tree/model.spec");
  EXPECT_EQ(besideFile("model.e", "model.spec"), "model.spec");
  EXPECT_EQ(besideFile("models/model.e", "/data/model.spec"), "/data/model.spec");
}

}  // namespace
}  // namespace espalier::environment
