#include <gtest/gtest.h>

#include <string>

#include "engine/files/curves/blob_file.h"

namespace espalier::files::blob_file_test {
namespace {

BlobField read(const std::string& text, core::DiagnosticList& diagnostics) {
  const DataFile file("b.sdat", text, diagnostics);
  return readBlobFile(file);
}

// q = (1/2)² = 1/4: 1 - 2.444444/4 + 1.888889/16 - 0.444444/64 = 0.500000
TEST(BlobField, FadesFromOneToZeroAtTheRadius) {
  core::DiagnosticList diagnostics;
  const BlobField field = read("# a point\ne\no 1 0 0\nr 2\nq\n", diagnostics);
  EXPECT_TRUE(diagnostics.entries().empty());
  EXPECT_NEAR(field.value({1, 0, 0}), 1.0, 1e-12);
  EXPECT_NEAR(field.value({2, 0, 0}), 0.5, 1e-6);
  EXPECT_EQ(field.value({3, 0, 0}), 0.0);
}

TEST(BlobField, AnLLineCountsTwiceAndASegmentOnce) {
  core::DiagnosticList diagnostics;
  const BlobField line = read("L 0 0 0 4 0 0 2 2\n", diagnostics);
  const BlobField segment = read("l\no 0 0 0\no 4 0 0\nr 2\nq\n", diagnostics);
  EXPECT_TRUE(diagnostics.entries().empty());
  EXPECT_NEAR(line.value({2, 1, 0}), 1.0, 1e-6);
  EXPECT_NEAR(segment.value({2, 1, 0}), 0.5, 1e-6);
}

TEST(BlobField, RadiusIsInterpolatedAlongASegment) {
  core::DiagnosticList diagnostics;
  const BlobField field = read("l\no 0 0 0\no 4 0 0\nr 1 3\nq\n", diagnostics);
  // in the middle the radius is 2
  EXPECT_NEAR(field.value({2, 1, 0}), 0.5, 1e-6);
}

TEST(BlobField, AxesMakeAnEllipsoid) {
  core::DiagnosticList diagnostics;
  const BlobField field = read("e\no 0 0 0\na 2 0 0 0 4 0 0 0 1\nq\n", diagnostics);
  EXPECT_NEAR(field.value({1, 0, 0}), 0.5, 1e-6);
  EXPECT_NEAR(field.value({0, 2, 0}), 0.5, 1e-6);
  EXPECT_NEAR(field.value({0, 0, 0.5}), 0.5, 1e-6);
}

TEST(BlobField, UnknownLinesAreLeftOutWithAWarning) {
  core::DiagnosticList diagnostics;
  const BlobField field = read("r 2\nz 1\no 1 2 3\ne\no 1 0\n", diagnostics);
  EXPECT_EQ(field.objects().size(), 0U);
  ASSERT_EQ(diagnostics.warningCount(), 3U);
  EXPECT_EQ(diagnostics.entries()[0].message, "expected one of # L l e o r a q while reading a blob field, found 'z'");
  EXPECT_EQ(diagnostics.entries()[0].location.line, 2U);
  EXPECT_EQ(diagnostics.entries()[1].message, "expected 'l' or 'e' before 'o' while reading a blob field, found 'o'");
  EXPECT_EQ(diagnostics.entries()[2].message,
            "expected three coordinates after 'o' while reading a blob field, found 'o'");
}

}  // namespace
}  // namespace espalier::files::blob_file_test
