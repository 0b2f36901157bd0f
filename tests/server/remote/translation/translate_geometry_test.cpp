#include "server/remote/translation/translate_geometry.h"

#include <gtest/gtest.h>

#include "protocol/codec.h"
#include "protocol/framing.h"

namespace espalier::server::translate_geometry_test {
namespace {

const std::vector<std::string> kSymbols{"F", "L"};

turtle::Geometry example(double bend, std::uint64_t shift) {
  turtle::Geometry geometry;
  const auto add = [](turtle::GeometrySources& sources, std::uint64_t module, core::SymbolId symbol) {
    sources.plant.push_back(1);
    sources.module.push_back(module);
    sources.symbol.push_back(symbol);
    sources.colour.push_back(200);
    sources.branchOrder.push_back(3);
  };
  for (std::uint64_t i = 0; i < 3; ++i) {
    const double x = static_cast<double>(i);
    add(geometry.segments, 2 * i + shift, 0);
    geometry.start.push_back({x, 0.1, -0.0});
    geometry.end.push_back({x, 1.0 + (i == 1 ? bend : 0.0), 0.0});
    geometry.startWidth.push_back(0.5);
    geometry.endWidth.push_back(0.25);
    add(geometry.organs, 2 * i + 1 + shift, 1);
    geometry.kind.push_back(turtle::GeometryKind::Polygon);
    const auto first = static_cast<std::uint32_t>(geometry.vertices.size());
    for (const core::Vec3& corner : {core::Vec3{x, 0, 0}, core::Vec3{x + 1, 0, 0}, core::Vec3{x, 1, bend * x}}) {
      geometry.vertices.push_back(corner);
    }
    geometry.triangles.push_back({first, first + 1, first + 2});
    geometry.vertexOffset.push_back(geometry.vertices.size());
    geometry.triangleOffset.push_back(geometry.triangles.size());
  }
  return geometry;
}

/// The columns that arrive when these cross the wire.
protocol::GeometryColumns crossed(const protocol::GeometryColumns& columns, bool isInBlocks) {
  static constexpr std::array<std::uint64_t, 1> kNoOffsets{0};
  protocol::EnvironmentStepParams params;
  params.simulation = "s";
  params.queries.offset = kNoOffsets;
  params.geometry = columns;
  protocol::MessageReader reader{protocol::FrameLimits{}};
  reader.allowBlocks();
  reader.feed(protocol::encodeRequest(protocol::MessageId::of(1), "environment.step",
                                      isInBlocks ? protocol::encodeBlocks(params) : protocol::Body(encode(params))));
  const auto read = reader.next();
  const auto decoded = protocol::decodeEnvironmentStepParams(read->value().payload);
  return *decoded.value().geometry;
}

TEST(TranslateGeometry, WholeAndDifferenceArriveBitByBit) {
  const auto before = std::make_shared<const turtle::Geometry>(example(0.0, 0));
  const auto now = std::make_shared<const turtle::Geometry>(example(0.3, 7));
  for (const bool isInBlocks : {false, true}) {
    // the symbols of the other side have other numbers
    std::vector<std::string> symbols{"E", "L"};
    turtle::Geometry arrived;
    EXPECT_EQ(toGeometry(crossed(toColumns(before, nullptr, kSymbols), isInBlocks), nullptr, symbols, arrived),
              std::nullopt);
    EXPECT_EQ(symbols, (std::vector<std::string>{"E", "L", "F"}));
    EXPECT_EQ(arrived.segments.symbol[0], 2);
    EXPECT_EQ(arrived.organs.symbol[0], 1);

    const auto columns = toColumns(now, before.get(), kSymbols);
    EXPECT_EQ(columns.segmentPlant.size(), 1U);  // one of three is bent
    EXPECT_EQ(columns.organPlant.size(), 2U);
    turtle::Geometry next;
    EXPECT_EQ(toGeometry(crossed(columns, isInBlocks), &arrived, symbols, next), std::nullopt);
    turtle::Geometry expected = *now;
    expected.segments.symbol.assign(3, 2);
    EXPECT_EQ(next, expected);
  }
}

TEST(TranslateGeometry, ModulesThatMovedBackKeepTheirRows) {
  const auto before = std::make_shared<const turtle::Geometry>(example(0.0, 50));
  const auto now = std::make_shared<const turtle::Geometry>(example(0.0, 0));
  const auto columns = toColumns(now, before.get(), kSymbols);
  EXPECT_TRUE(columns.segmentPlant.empty());
  std::vector<std::string> symbols = kSymbols;
  turtle::Geometry next;
  EXPECT_EQ(toGeometry(crossed(columns, true), before.get(), symbols, next), std::nullopt);
  EXPECT_EQ(next, *now);
}

TEST(TranslateGeometry, ADifferenceNeedsTheOneBefore) {
  const auto geometry = std::make_shared<const turtle::Geometry>(example(0.0, 0));
  std::vector<std::string> symbols = kSymbols;
  turtle::Geometry next;
  EXPECT_EQ(toGeometry(toColumns(geometry, geometry.get(), kSymbols), nullptr, symbols, next),
            "it is a difference, but no geometry came before it");
}

TEST(TranslateGeometry, ASymbolWithoutANameIsAQuestionMark) {
  const auto geometry = std::make_shared<const turtle::Geometry>(example(0.0, 0));
  EXPECT_EQ(toColumns(geometry, nullptr, {"F"}).symbols, (std::vector<std::string>{"F", "?"}));
}

}  // namespace
}  // namespace espalier::server::translate_geometry_test
