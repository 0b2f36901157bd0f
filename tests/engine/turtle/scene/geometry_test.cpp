#include "engine/turtle/scene/geometry.h"

#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::geometry_test {
namespace {

using core::Vec3;

Geometry geometryOf(const std::string& string, const files::ViewSettings& view = {}) {
  TurtleRun run(string, view);
  run.draw();
  Geometry geometry;
  const auto symbolOf = [&run](std::uint32_t, std::uint64_t module) {
    return run.program.symbolOf[run.state.string.types()[module]];
  };
  appendGeometry(std::move(run.scene), view, symbolOf, geometry);
  return geometry;
}

double areaOf(const Geometry& geometry, std::size_t organ) {
  double area = 0.0;
  for (std::uint64_t t = geometry.triangleOffset[organ]; t < geometry.triangleOffset[organ + 1]; ++t) {
    const auto& [a, b, c] = geometry.triangles[t];
    const Vec3& origin = geometry.vertices[a];
    area += 0.5 * core::length(core::cross(geometry.vertices[b] - origin, geometry.vertices[c] - origin));
  }
  return area;
}

TEST(Geometry, LinesAreSegmentsWithTheirModuleWidthsColourAndOrder) {
  const Geometry geometry = geometryOf("!(0.5);(3)F(2)[+(90)F(1)]");
  ASSERT_EQ(geometry.segments.size(), 2U);
  EXPECT_EQ(geometry.segments.module, (std::vector<std::uint64_t>{2, 5}));
  EXPECT_EQ(geometry.segments.symbol[0], geometry.segments.symbol[1]);
  EXPECT_EQ(geometry.segments.colour, (std::vector<std::uint8_t>{3, 3}));
  EXPECT_EQ(geometry.segments.branchOrder, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(geometry.start[1], (Vec3{0.0, 2.0, 0.0}));
  EXPECT_NEAR(geometry.end[1].x, -1.0, 1e-12);
  EXPECT_EQ(geometry.startWidth, (std::vector<double>{0.5, 0.5}));
  EXPECT_EQ(geometry.organs.size(), 0U);
}

TEST(Geometry, OnlyLinesOfPixelsHaveNoSizeInTheWorld) {
  files::ViewSettings view;
  view.lineStyle = files::LineStyle::Pixel;
  EXPECT_TRUE(geometryOf("F", view).areWidthsPixels);
  view.lineStyle = files::LineStyle::Cylinder;
  EXPECT_FALSE(geometryOf("F", view).areWidthsPixels);
}

TEST(Geometry, OrgansAreTrianglesThatIndexTheVerticesOfAll) {
  // a right triangle of area 1/2 and a square of area 4
  const Geometry geometry = geometryOf(",(7){.f(1)-(90)f(1)}[f(3)+(90),(8){.f(2)+(90)f(2)+(90)f(2)}]");
  ASSERT_EQ(geometry.organs.size(), 2U);
  EXPECT_EQ(geometry.kind, (std::vector<GeometryKind>{GeometryKind::Polygon, GeometryKind::Polygon}));
  EXPECT_EQ(geometry.organs.module, (std::vector<std::uint64_t>{1, 11}));
  EXPECT_EQ(geometry.organs.colour, (std::vector<std::uint8_t>{7, 8}));
  EXPECT_EQ(geometry.triangleOffset, (std::vector<std::uint64_t>{0, 1, 3}));
  EXPECT_NEAR(areaOf(geometry, 0), 0.5, 1e-12);
  EXPECT_NEAR(areaOf(geometry, 1), 4.0, 1e-12);
  for (std::uint64_t t = geometry.triangleOffset[1]; t < geometry.triangleOffset[2]; ++t) {
    for (const std::uint32_t vertex : geometry.triangles[t]) {
      EXPECT_GE(vertex, geometry.vertexOffset[1]);
      EXPECT_LT(vertex, geometry.vertexOffset[2]);
    }
  }
}

TEST(Geometry, ASphereComesAsTrianglesOfItsSize) {
  const Geometry geometry = geometryOf("@O(2)");
  ASSERT_EQ(geometry.organs.size(), 1U);
  EXPECT_EQ(geometry.kind[0], GeometryKind::Ball);
  // an inscribed polyhedron has a little less than 4 pi
  EXPECT_GT(areaOf(geometry, 0), 0.9 * 12.566);
  EXPECT_LT(areaOf(geometry, 0), 12.567);
}

TEST(Geometry, ScenesAreAppended) {
  files::ViewSettings view;
  Geometry geometry;
  for (int i = 0; i < 2; ++i) {
    TurtleRun run("F{.f-(90)f}", view);
    run.draw();
    appendGeometry(
        std::move(run.scene), view, [](std::uint32_t, std::uint64_t) { return core::SymbolId{4}; }, geometry);
  }
  EXPECT_EQ(geometry.segments.size(), 2U);
  ASSERT_EQ(geometry.organs.size(), 2U);
  EXPECT_EQ(geometry.triangles[1][0], geometry.triangles[0][0] + 3);
  EXPECT_EQ(geometry.organs.symbol[1], 4);
}

}  // namespace
}  // namespace espalier::turtle::geometry_test
