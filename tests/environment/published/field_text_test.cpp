#include "environment/published/field_text.h"

#include <gtest/gtest.h>

namespace espalier::environment {
namespace {

TEST(FieldText, SplitsKeywordsAtTheColonAndKeepsThemExactly) {
  std::vector<core::Diagnostic> warnings;
  const auto lines =
      readFieldLines("m.spec", "radius: 1.5 \r\n\n3d case:on\n odd : a:b\n", FieldSyntax::Specification, warnings);
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

TEST(FieldText, EnvironmentFilesAlsoSplitAtATab) {
  std::vector<core::Diagnostic> warnings;
  const auto lines = readFieldLines("m.e", "executable\thonda81 -e x:y\n", FieldSyntax::Environment, warnings);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].keyword, "executable");
  EXPECT_EQ(lines[0].value, "honda81 -e x:y");
}

TEST(FieldText, LinesOfNumbersBelongToTheKeywordAbove) {
  std::vector<core::Diagnostic> warnings;
  const auto lines =
      readFieldLines("m.spec", "array: 2 2\n0.5 0.9\n  -.2:4\nname: x\n", FieldSyntax::Specification, warnings);
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].data, (std::vector<std::string>{"0.5 0.9", "-.2:4"}));
  EXPECT_TRUE(warnings.empty());
}

TEST(FieldText, WarnsOfLinesWithoutAKeyword) {
  std::vector<core::Diagnostic> warnings;
  EXPECT_TRUE(readFieldLines("m.spec", "\nhello\n", FieldSyntax::Specification, warnings).empty());
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(core::formatDiagnostic(warnings[0]),
            "m.spec:2:1: warning: line without a keyword is ignored\n    2 | hello\n      | ^~~~~\n"
            "   hint: expected 'keyword: values'");
}

TEST(FieldText, CutsLongLinesWithAWarning) {
  std::vector<core::Diagnostic> warnings;
  const std::string value(300, '7');
  const auto lines = readFieldLines("m.spec", "a: " + value, FieldSyntax::Specification, warnings);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].value.size(), 251U);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].message, "line longer than 254 characters: the rest is ignored");
  EXPECT_EQ(warnings[0].location.column, 254U);
  std::vector<core::Diagnostic> none;
  EXPECT_EQ(readFieldLines("m.spec", "a: " + value.substr(0, 251), FieldSyntax::Specification, none)[0].value.size(),
            251U);
  EXPECT_TRUE(none.empty());
}

TEST(FieldText, NumbersAreSeparatedAsTheFieldSeparatesThem) {
  EXPECT_EQ(readFieldNumbers("10x20 ,3;4:5\t-6e1 +.5"), (std::vector<double>{10, 20, 3, 4, 5, -60, 0.5}));
  std::string_view rest;
  EXPECT_EQ(readFieldNumbers(" 1 2 three 4", &rest), (std::vector<double>{1, 2}));
  EXPECT_EQ(rest, "three 4");
  EXPECT_TRUE(readFieldNumbers(" x ").empty());
}

TEST(FieldText, FilesLieBesideTheFileThatNamesThem) {
  EXPECT_EQ(besideFile("models/tree/model.e", "model.spec"), "models/tree/model.spec");
  EXPECT_EQ(besideFile("model.e", "model.spec"), "model.spec");
  EXPECT_EQ(besideFile("models/model.e", "/data/model.spec"), "/data/model.spec");
}

}  // namespace
}  // namespace espalier::environment
