#include "protocol/geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "protocol/codec.h"
#include "protocol/framing.h"

namespace espalier::protocol::geometry_test {
namespace {

/// A segment, a triangle and a square of two triangles, as the difference from one segment before.
struct Example {
  std::vector<std::uint32_t> zero{0}, one{1}, module{4}, runs{0, 1, 4294967293, 0xFFFFFFFF, 1, 0},
      organRuns{0xFFFFFFFF, 2, 0};
  std::vector<std::uint32_t> zeros{0, 0}, modules{5, 9}, symbols{1, 0}, colours{7, 255}, kinds{1, 4},
      vertexCounts{3, 4}, triangleCounts{1, 2}, triangles{0, 1, 2, 0, 1, 2, 0, 2, 3};
  std::vector<double> start{0.1, -0.0, 1e-300}, end{1, 2, 3}, startWidth{0.5}, endWidth{0.25},
      vertices = std::vector<double>(21, 0.3);

  [[nodiscard]] EnvironmentStepParams params(bool isDifference) const {
    EnvironmentStepParams step;
    step.simulation = "s";
    step.queries.offset = kNoOffsets;
    GeometryColumns& g = step.geometry.emplace();
    g.isDifference = isDifference;
    g.areWidthsPixels = isDifference;
    g.symbols = {"F", "L"};
    if (isDifference) {
      g.segmentRuns = runs;
      g.organRuns = organRuns;
    }
    g.segmentPlant = g.segmentSymbol = g.segmentColour = zero;
    g.segmentOrder = one;
    g.segmentModule = module;
    g.segmentStart = start;
    g.segmentEnd = end;
    g.segmentStartWidth = startWidth;
    g.segmentEndWidth = endWidth;
    g.organPlant = g.organOrder = zeros;
    g.organModule = modules;
    g.organSymbol = symbols;
    g.organColour = colours;
    g.organKind = kinds;
    g.organVertices = vertexCounts;
    g.organTriangles = triangleCounts;
    g.vertices = vertices;
    g.triangles = triangles;
    return step;
  }
  static constexpr std::array<std::uint64_t, 1> kNoOffsets{0};
};

Expected<EnvironmentStepParams> crossed(const Body& body) {
  MessageReader reader{FrameLimits{}};
  reader.allowBlocks();
  reader.feed(encodeRequest(MessageId::of(1), "environment.step", body));
  const auto read = reader.next();
  if (!read || !read->has_value()) {
    return tl::unexpected(Error{ErrorCode::Internal, "not read", {}});
  }
  return decodeEnvironmentStepParams(read->value().payload);
}

std::string problem(const EnvironmentStepParams& params, bool isInBlocks) {
  const auto decoded = crossed(isInBlocks ? encodeBlocks(params) : Body(encode(params)));
  return decoded ? "(accepted)" : decoded.error().message;
}

TEST(Geometry, IsReadBackAsItWasWrittenAsTextAndInBlocks) {
  const Example example;
  for (const bool isDifference : {false, true}) {
    const EnvironmentStepParams params = example.params(isDifference);
    for (const Body& body : {Body(encode(params)), encodeBlocks(params)}) {
      const auto decoded = crossed(body).value();
      ASSERT_TRUE(decoded.geometry.has_value());
      EXPECT_EQ(encode(decoded), encode(params));
      EXPECT_TRUE(std::signbit(decoded.geometry->segmentStart[1]));
    }
  }
}

TEST(Geometry, AStepWithoutGeometryHasNone) {
  EnvironmentStepParams params = Example().params(false);
  params.geometry.reset();
  EXPECT_FALSE(crossed(Body(encode(params))).value().geometry.has_value());
  EXPECT_EQ(encode(params).find("geometry"), std::string::npos);
}

TEST(Geometry, WhatIsWrongIsNamedWithItsPlace) {
  Example example;
  const auto withTriangle = [&example](std::uint32_t corner) {
    Example other = example;
    other.triangles[5] = corner;
    return other;
  };
  EXPECT_EQ(problem(withTriangle(4).params(false), false),
            "params.geometry.triangles[1][2]: organ 1 has 4 vertices, there is no vertex 4");
  EXPECT_EQ(problem(withTriangle(4).params(false), true),
            "bin.triangles[1][2]: organ 1 has 4 vertices, there is no vertex 4");
  Example few = example;
  few.triangleCounts = {1, 1};
  EXPECT_EQ(problem(few.params(false), false), "params.geometry.triangles[2][0]: this triangle belongs to no organ");
  few.triangleCounts = {1, 3};
  EXPECT_EQ(problem(few.params(false), true), "bin.organTriangles[1]: expected no more triangles than came, 3 in all");
  Example many = example;
  many.vertexCounts = {4, 4};
  EXPECT_EQ(problem(many.params(false), false),
            "params.geometry.vertices[0][0]: the organs have 8 vertices, but 7 came");
  Example named = example;
  named.symbols = {1, 2};
  EXPECT_EQ(problem(named.params(false), false),
            "params.geometry.organSymbol[1]: there is no symbol 2; geometry.symbols has 2");
  Example coloured = example;
  coloured.colours = {7, 256};
  EXPECT_EQ(problem(coloured.params(false), true), "bin.organColour[1]: expected a colour from 0 to 255, found 256");
  Example shaped = example;
  shaped.kinds = {5, 0};
  EXPECT_EQ(problem(shaped.params(false), false), "params.geometry.organKind[0]: expected a kind from 0 to 4, found 5");
  Example longer = example;
  longer.end.push_back(1.0);
  longer.end.push_back(1.0);
  longer.end.push_back(1.0);
  EXPECT_EQ(problem(longer.params(false), false), "params.geometry.segmentEnd: expected 1 rows, found 2");
  EXPECT_EQ(problem(longer.params(false), true), "bin.segmentEnd: expected the shape [1,3], found [2,3]");
}

TEST(Geometry, FormAndWidthsAreWords) {
  const auto problemOf = [](const std::string& geometry) {
    const auto decoded = crossed(Body(R"({"simulation":"s","step":0,"geometry":)" + geometry + R"(,"queries":[]})"));
    return decoded ? "(accepted)" : decoded.error().message;
  };
  EXPECT_EQ(problemOf("3"), "params.geometry: expected an object, found 3");
  EXPECT_EQ(problemOf(R"({"form":"part"})"), "params.geometry.form: expected whole or difference, found \"part\"");
  EXPECT_EQ(problemOf(R"({"form":"whole","widths":"metres"})"),
            "params.geometry.widths: expected pixels or world, found \"metres\"");
  EXPECT_EQ(problemOf(R"({"form":"whole","widths":"world","symbols":[],"segmentPlant":[]})"),
            "params.geometry.segmentModule: expected an array, found nothing");
}

TEST(Geometry, NumbersThatAreNotFiniteAreNotWritten) {
  Example example;
  example.vertices[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)encode(example.params(false)), NonFiniteNumber);
  EXPECT_THROW((void)encodeBlocks(example.params(false)), NonFiniteNumber);
}

}  // namespace
}  // namespace espalier::protocol::geometry_test
