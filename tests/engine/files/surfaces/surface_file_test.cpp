#include <gtest/gtest.h>

#include <string>

#include "engine/core/frame.h"
#include "engine/files/surfaces/surface_file.h"

namespace espalier::files::surface_file_test {
namespace {

using core::Vec3;

std::string surfaceText(const std::string& heading, const std::string& up, const std::string& end,
                        const std::string& size,
                        const std::string& neighbours = "AL: ~ A: ~ AR: ~ L: ~ R: ~ BL: ~ B: ~ BR: ~",
                        const std::string& precision = "") {
  return "0 1 0 1 0 0\n" + precision + "CONTACT POINT X: 0 Y: 0 Z: 0\nEND POINT " + end + "\nHEADING " + heading +
         "\nUP " + up + "\nSIZE: " + size + "\none\nTOP COLOR: 3 DIFFUSE: 0 BOTTOM COLOR: 4 DIFFUSE: 0\n" + neighbours +
         "\n0 0 0 .33 0 0 .66 0 0 1 0 0\n0 .33 0 .33 .33 0 .66 .33 0 1 .33 0\n"
         "0 .66 0 .33 .66 0 .66 .66 0 1 .66 0\n0 1 0 .33 1 0 .66 1 0 1 1 0\n";
}

const char* const kUpright = "X: 0 Y: 1 Z: 0";

struct Read {
  std::optional<Surface> surface;
  std::string message;
};

Read read(const std::string& text, double scale = 1.0, int s = 0, int t = 0) {
  core::DiagnosticList diagnostics;
  const DataFile file("p.s", text, diagnostics);
  Read result{readSurfaceFile(file, 'p', scale, s, t), ""};
  if (!diagnostics.entries().empty()) {
    const core::Diagnostic& first = diagnostics.entries().front();
    result.message =
        std::to_string(first.location.line) + ":" + std::to_string(first.location.column) + " " + first.message;
  }
  return result;
}

/// Where the initial turtle takes a local point.
Vec3 atTheInitialTurtle(const Vec3& local) {
  const core::Frame frame;
  return frame.left * local.x + frame.heading * local.y + frame.up * local.z;
}

void expectNear(const Vec3& value, const Vec3& expected) {
  EXPECT_NEAR(value.x, expected.x, 1e-12);
  EXPECT_NEAR(value.y, expected.y, 1e-12);
  EXPECT_NEAR(value.z, expected.z, 1e-12);
}

TEST(SurfaceFile, AFrameWithoutAPlaneIsNamed) {
  const char* const kZero = "X: 0 Y: 0 Z: 0";
  const char* const kForward = "X: 0 Y: 0 Z: 1";
  EXPECT_EQ(read(surfaceText(kUpright, kForward, kUpright, "1")).message, "");
  const Read parallel = read(surfaceText(kUpright, "X: 0 Y: -2 Z: 0", kUpright, "1"));
  EXPECT_TRUE(parallel.surface.has_value());
  EXPECT_EQ(parallel.message, "4:1 UP of the surface has the direction of HEADING, or is 0: it is a line");
  EXPECT_EQ(read(surfaceText(kUpright, kZero, kUpright, "1")).message, parallel.message);
  EXPECT_EQ(read(surfaceText(kZero, kForward, kUpright, "1")).message,
            "4:1 HEADING of the surface is 0: it is a point");
}

TEST(SurfaceFile, TheFormatOfAnotherEditorIsNamed) {
  const Read result = read("VERSION stedit 1.0\n0 0 0 0 0 0\n");
  EXPECT_FALSE(result.surface);
  EXPECT_EQ(result.message,
            "1:1 the surface is in the format of the editor stedit, which the reference program does not read");
}

// recorded from the reference program: HEADING (0.6,0.8,0), UP (0,0,1), end (1,0,0), SIZE 2, scale 1
TEST(SurfaceFile, ObliqueHeadingSendsTheFilesAxesToItsFrame) {
  const Read result = read(surfaceText("X: 0.6 Y: 0.8 Z: 0", "X: 0 Y: 0 Z: 1", "X: 1 Y: 0 Z: 0", "2"));
  ASSERT_TRUE(result.surface.has_value()) << result.message;
  expectNear(atTheInitialTurtle(result.surface->endPoint), {-0.4, -0.3, 0.0});
}

// conformance case 169: UP (0,0,-1) gives a surface as drawn in its file
TEST(SurfaceFile, UpTowardsTheViewerKeepsTheFilesCoordinates) {
  const Read result = read(surfaceText(kUpright, "X: 0 Y: 0 Z: -1", "X: 0.5 Y: 1 Z: 0.25", "1"));
  ASSERT_TRUE(result.surface.has_value()) << result.message;
  expectNear(atTheInitialTurtle(result.surface->endPoint), {0.5, 1.0, 0.25});
  ASSERT_EQ(result.surface->patches.size(), 1U);
  expectNear(atTheInitialTurtle(result.surface->patches[0].points[7]), {1.0, 0.33, 0.0});
  EXPECT_EQ(result.surface->patches[0].topColour, 3);
  EXPECT_EQ(result.surface->patches[0].bottomColour, 4);
}

TEST(SurfaceFile, ScaleIsDividedByTheSize) {
  const Read result = read(surfaceText(kUpright, "X: 0 Y: 0 Z: -1", "X: 0 Y: 4 Z: 0", "4"), 10.0);
  ASSERT_TRUE(result.surface.has_value());
  expectNear(result.surface->endPoint, {0.0, 10.0, 0.0});
}

TEST(SurfaceFile, OnePrecisionServesBothDirectionsAndTheCommandWins) {
  const std::string text = surfaceText(kUpright, "X:0 Y:0 Z:-1", "X:0 Y:1 Z:0", "1",
                                       "AL: ~ A: ~ AR: ~ L: ~ R: ~ BL: ~ B: ~ BR: ~", "PRECISION S: 7 T: 3\n");
  EXPECT_EQ(read(text).surface->subdivisionS, 7);
  EXPECT_EQ(read(text).surface->subdivisionT, 7);
  EXPECT_EQ(read(text, 1.0, 2, 99).surface->subdivisionS, 2);
  EXPECT_EQ(read(text, 1.0, 2, 99).surface->subdivisionT, 10);
}

TEST(SurfaceFile, NeighboursMustExistAndBeMutual) {
  const auto withNeighbours = [](const std::string& neighbours) {
    return read(surfaceText(kUpright, "X: 0 Y: 0 Z: -1", "X: 0 Y: 1 Z: 0", "1", neighbours));
  };
  EXPECT_TRUE(withNeighbours("AL: ~ A: one AR: ~ L: ~ R: ~ BL: ~ B: one BR: ~").surface.has_value());
  const Read oneSided = withNeighbours("AL: ~ A: one AR: ~ L: ~ R: ~ BL: ~ B: ~ BR: ~");
  EXPECT_FALSE(oneSided.surface.has_value());
  EXPECT_EQ(oneSided.message, "7:1 'A:' of patch 'one' names 'one', whose 'B:' does not name it back");
  const Read unknown = withNeighbours("AL: ~ A: ~ AR: ~ L: two R: ~ BL: ~ B: ~ BR: ~");
  EXPECT_FALSE(unknown.surface.has_value());
  EXPECT_EQ(unknown.message, "7:1 'L:' of patch 'one' names 'two', which is not a patch of this surface");
}

TEST(SurfaceFile, ReportsMissingParts) {
  EXPECT_EQ(read("0 1 0 1 0").message,
            "1:10 expected the six numbers of the bounding box while reading a surface, found the end");
  EXPECT_EQ(read("0 1 0 1 0 1\nEND POINT").message,
            "2:1 expected 'CONTACT POINT' while reading a surface, found 'END'");
  std::string cut = surfaceText(kUpright, "X: 0 Y: 0 Z: -1", "X: 0 Y: 1 Z: 0", "1");
  cut.resize(cut.size() - 3);
  const Read result = read(cut);
  EXPECT_FALSE(result.surface.has_value());
  EXPECT_NE(result.message.find("expected the 48 numbers of a patch while reading a surface, found the end"),
            std::string::npos)
      << result.message;
}

TEST(SurfaceFile, SizeOfZeroIsRefused) {
  const Read result = read(surfaceText(kUpright, "X: 0 Y: 0 Z: -1", "X: 0 Y: 1 Z: 0", "0"));
  EXPECT_FALSE(result.surface.has_value());
  EXPECT_EQ(result.message, "1:1 the size 0 of the surface gives points that are not finite");
}

TEST(TriangleSurfaceFile, ReadsVerticesScalesPositionsAndFillsNormals) {
  core::DiagnosticList diagnostics;
  const DataFile file("t.ray",
                      "remark\ntriangle\n0,0,0 0 0 1\n\n1 0 0\t0 0 1 .5 .5\n0 1 0\ntriangle\n0 0 0\n1 0 0\n0 0 1\n",
                      diagnostics);
  const std::optional<TriangleSurface> surface = readTriangleSurfaceFile(file, 't', 2.0);
  ASSERT_TRUE(surface.has_value());
  ASSERT_EQ(surface->triangles.size(), 2U);
  EXPECT_EQ(surface->triangles[0].points[1], (Vec3{2, 0, 0}));
  EXPECT_EQ(surface->triangles[0].normals[1], (Vec3{0, 0, 1}));
  // a vertex without a normal: (1,0,0) x (0,0,1) = (0,-1,0)
  EXPECT_EQ(surface->triangles[1].normals[0], (Vec3{0, -1, 0}));
}

TEST(TriangleSurfaceFile, AnIncompleteTriangleDiscardsTheSurface) {
  core::DiagnosticList diagnostics;
  const DataFile file("t.ray", "triangle\n0 0 0\n1 0 0\n", diagnostics);
  EXPECT_FALSE(readTriangleSurfaceFile(file, 't', 1.0).has_value());
  ASSERT_EQ(diagnostics.warningCount(), 1U);
  EXPECT_EQ(diagnostics.entries()[0].message,
            "expected at least three numbers of a vertex while reading a triangle, found the end");
  EXPECT_EQ(diagnostics.entries()[0].location.line, 4U);
}

}  // namespace
}  // namespace espalier::files::surface_file_test
