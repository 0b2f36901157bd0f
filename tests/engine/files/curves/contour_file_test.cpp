#include <gtest/gtest.h>

#include <string>

#include "engine/files/curves/contour_file.h"

namespace espalier::files::contour_file_test {
namespace {

struct Read {
  std::optional<Contour> contour;
  std::string message;
};

Read read(const std::string& text) {
  core::DiagnosticList diagnostics;
  const DataFile file("c.con", text, diagnostics);
  Read result{readContourFile(file, 2), ""};
  if (!diagnostics.entries().empty()) {
    const core::Diagnostic& first = diagnostics.entries().front();
    result.message =
        std::to_string(first.location.line) + ":" + std::to_string(first.location.column) + " " + first.message;
  }
  return result;
}

TEST(ContourFile, ReadsVersion13AndRepeatsPoints) {
  const Read result = read("cver 1 3\nname: leaf\npoints: 2 99\ntype: or\nsamples: 8\n-1 0 0 3\n1 0.2 0 3\n");
  ASSERT_TRUE(result.contour.has_value()) << result.message;
  EXPECT_EQ(result.contour->id, 2);
  EXPECT_FALSE(result.contour->isClosed);
  ASSERT_EQ(result.contour->points.size(), 6U);
  EXPECT_EQ(result.contour->points[2], (core::Vec3{-1, 0, 0}));
  EXPECT_EQ(result.contour->points[3], (core::Vec3{1, 0.2, 0}));
}

TEST(ContourFile, SkipsLinesThatEditorsAdd) {
  const Read result = read(
      "cver 1 3\nname: leaf\npoints: 2 6\ntype: ce\nsamples: 8\nbackground: a\nbackgroundXY: 0 0\nmarkers: 1\n0.5\n"
      "-1 0 0 3\n1 0.2 0 3\n");
  ASSERT_TRUE(result.contour.has_value()) << result.message;
  EXPECT_TRUE(result.contour->isClosed);
  EXPECT_EQ(result.contour->points.size(), 6U);
}

TEST(ContourFile, ReadsTheOlderForms) {
  for (const char* type : {"closed", "loop", "opened"}) {
    const std::string text =
        std::string("cver 1 1\nname: a\npoints: 3 3\ntype: ") + type + "\n1 0 0 1\n0 1 0 1\n-1 0 0 1\n";
    EXPECT_TRUE(read(text).contour->isClosed) << type;
  }
  EXPECT_FALSE(read("cver 1 2\nname: a\npoints: 2 4\ntype: or\n1 0 0 2\n0 1 0 2\n").contour->isClosed);
  const Read plain = read("3 2 closed\n1 0\n0 1\n-1 0\n");
  ASSERT_TRUE(plain.contour.has_value()) << plain.message;
  EXPECT_TRUE(plain.contour->isClosed);
  EXPECT_EQ(plain.contour->points.size(), 3U);
  EXPECT_FALSE(read("4 3 whatever\n1 0 0\n0 1 0\n-1 0 0\n0 0 5\n").contour->isClosed);
}

TEST(ContourFile, ReportsEachMistake) {
  EXPECT_EQ(read("cver 1 4\n").message, "1:8 expected 1, 2 or 3 behind 'cver 1' while reading a contour, found '4'");
  EXPECT_EQ(read("hello\n").message,
            "1:1 expected 'cver 1 3', or a count, the dimension 2 or 3 and 'open' or 'closed' while reading a contour, "
            "found 'hello'");
  EXPECT_EQ(read("cver 1 3\nname: a\npoints: 1 3\ntype: or\nsamples: 8\n0 0 0\n").message,
            "6:6 expected the multiplicity of a point while reading a contour, found the end");
  EXPECT_EQ(read("cver 1 3\nname: a\npoints: 1 3\ntype: or\nsamples: 8\n0 0 0 3\n").message,
            "1:1 an open contour needs at least 4 points with their multiplicities, this one has 3");
  EXPECT_EQ(read("cver 1 3\nname: a\npoints: 1 3\ntype: x\n").message,
            "4:7 expected a type that begins with o (open) or c (closed) while reading a contour, found 'x'");
  EXPECT_EQ(read("cver 1 3\nname: a\npoints: 1 3\ntype: or\nsamples: 8\n0 0 0 999999999\n").message,
            "6:1 a contour has at most 100000 points");
}

}  // namespace
}  // namespace espalier::files::contour_file_test
