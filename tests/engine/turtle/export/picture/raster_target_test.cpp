#include "engine/turtle/export/picture/raster_target.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>
#include <vector>

namespace espalier::turtle::raster_target_test {
namespace {

constexpr Colour kWhite{255, 255, 255};

RasterTriangle triangleOf(std::array<std::array<float, 2>, 3> corners, float nearness = 0.0F,
                          std::array<float, 3> colour = {255.0F, 0.0F, 0.0F}) {
  RasterTriangle triangle;
  for (std::size_t i = 0; i < 3; ++i) {
    triangle.corners[i] = {corners[i][0], corners[i][1], nearness, colour};
  }
  return triangle;
}

void drawAll(RasterTarget& target, const RasterTriangle& triangle) {
  const auto [left, right, upper, lower] = target.tilesOf(triangle);
  for (int row = upper; row <= lower; ++row) {
    for (int column = left; column <= right; ++column) {
      target.draw(triangle, column, row);
    }
  }
}

std::vector<std::uint8_t> rowOf(const RasterTarget& target, int row, int width, bool isTransparent = true) {
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) * 4);
  target.resolve(row, kWhite, isTransparent, pixels);
  return pixels;
}

TEST(RasterTarget, ATriangleCoversItsShareOfAPixelsSamples) {
  RasterTarget target(2, 0, 1);
  // the left half of the second pixel: 8 of its 16 samples
  drawAll(target, triangleOf({{{1, 0}, {1.5, 0}, {1.5, 1}}}));
  drawAll(target, triangleOf({{{1, 0}, {1.5, 1}, {1, 1}}}));
  const auto pixels = rowOf(target, 0, 2);
  EXPECT_EQ(pixels[3], 0);
  EXPECT_EQ(pixels[7], 127);  // 8 · 255 / 16
  EXPECT_EQ(pixels[4], 255);  // the colour is not mixed with what is not there
  // over white: half red, half white
  EXPECT_EQ(rowOf(target, 0, 2, false), (std::vector<std::uint8_t>{255, 255, 255, 255, 255, 128, 128, 255}));
}

TEST(RasterTarget, TrianglesAtACommonEdgeCoverEachSampleOnce) {
  // a fan of odd angles around a point: with half opacity (of one organ) every sample that two triangles covered, or
  // none, would differ from the share of a single large triangle
  const std::array<std::array<float, 2>, 7> rim{
      {{-40, -3}, {11.3F, -35}, {77, 1.7F}, {71, 33.1F}, {29.7F, 80}, {-9, 61}, {-40, -3}}};
  RasterTarget target(32, 0, 32);
  std::array<int, 32 * 32> sum{};
  for (std::size_t i = 0; i + 1 < rim.size(); ++i) {
    RasterTarget alone(32, 0, 32);
    drawAll(alone, triangleOf({{{13.37F, 17.21F}, rim[i], rim[i + 1]}}));
    for (int row = 0; row < 32; ++row) {
      const auto pixels = rowOf(alone, row, 32);
      for (std::size_t x = 0; x < 32; ++x) {
        // in samples: 255 · n / 16 rounded down
        sum[static_cast<std::size_t>(row) * 32 + x] += (pixels[x * 4 + 3] * 16 + 254) / 255;
      }
    }
  }
  for (const int samples : sum) {
    ASSERT_EQ(samples, 16);
  }
}

TEST(RasterTarget, ATriangleThatNoTileNamesCoversNoSample) {
  RasterTarget chosen(8, 0, 8);
  RasterTarget all(8, 0, 8);
  std::mt19937 random(7);
  int skipped = 0;
  for (int i = 0; i < 2000; ++i) {
    // corners on a grid of eighths of a sample: many edges run through centres of samples
    const auto near = [&random](float place, unsigned eighths) {
      return place + static_cast<float>(random() % eighths) / 32.0F;
    };
    const float x = near(0.0F, 224);
    const float y = near(0.0F, 224);
    const RasterTriangle triangle = triangleOf(
        {{{near(x, 9), near(y, 9)}, {near(x, 9), near(y, 9)}, {near(x, 9), near(y, 9)}}}, static_cast<float>(i));
    const auto tiles = chosen.tilesOf(triangle);
    skipped += tiles[0] > tiles[1] ? 1 : 0;
    drawAll(chosen, triangle);
    all.draw(triangle, 0, 0);
  }
  EXPECT_GT(skipped, 200);
  EXPECT_LT(skipped, 1800);
  for (int row = 0; row < 8; ++row) {
    EXPECT_EQ(rowOf(chosen, row, 8), rowOf(all, row, 8)) << row;
  }
}

TEST(RasterTarget, TheNearerHidesTheFartherAndOfEqualsTheLaterIsSeen) {
  const std::array<std::array<float, 2>, 3> page{{{-10, -10}, {30, -10}, {-10, 30}}};
  RasterTarget target(1, 0, 1);
  drawAll(target, triangleOf(page, 2.0F, {10, 0, 0}));
  drawAll(target, triangleOf(page, 1.0F, {20, 0, 0}));
  EXPECT_EQ(rowOf(target, 0, 1)[0], 10);
  drawAll(target, triangleOf(page, 2.0F, {30, 0, 0}));
  EXPECT_EQ(rowOf(target, 0, 1)[0], 30);
}

TEST(RasterTarget, ColoursAreLinearAcrossATriangle) {
  RasterTarget target(64, 0, 1);
  RasterTriangle triangle = triangleOf({{{0, -100}, {64, 0.5F}, {0, 101}}}, 0.0F, {0, 0, 0});
  triangle.corners[1].colour = {128, 0, 0};
  drawAll(target, triangle);
  // at pixel x the mean of the samples is 2 · (x + 1/2)
  const auto pixels = rowOf(target, 0, 64);
  EXPECT_NEAR(pixels[10 * 4], 21, 1);
  EXPECT_NEAR(pixels[40 * 4], 81, 1);
}

TEST(RasterTarget, OpacityCoversItsShareOfTheSamples) {
  RasterTriangle triangle = triangleOf({{{-10, -10}, {30, -10}, {-10, 30}}});
  for (const float opacity : {0.25F, 0.5F, 0.75F}) {
    RasterTarget target(1, 0, 1);
    triangle.opacity = opacity;
    drawAll(target, triangle);
    EXPECT_EQ(rowOf(target, 0, 1)[3], static_cast<int>(opacity * 255.0F));
  }
}

TEST(RasterTarget, WhatIsBesideThePageOrHasNoAreaOrIsNotFiniteDrawsNothing) {
  RasterTarget target(4, 0, 4);
  const auto isOutside = [&](const RasterTriangle& triangle) {
    const auto tiles = target.tilesOf(triangle);
    return tiles[0] > tiles[1];
  };
  EXPECT_TRUE(isOutside(triangleOf({{{5, 0}, {9, 0}, {5, 9}}})));
  EXPECT_TRUE(isOutside(triangleOf({{{0, -9}, {4, -9}, {0, -1}}})));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const RasterTriangle& triangle :
       {triangleOf({{{0, 0}, {4, 4}, {2, 2}}}), triangleOf({{{0, 0}, {nan, 4}, {2, 0}}}),
        triangleOf({{{0, 0}, {infinity, 3}, {-infinity, 3}}})}) {
    if (!isOutside(triangle)) {
      target.draw(triangle, 0, 0);
    }
  }
  EXPECT_EQ(rowOf(target, 0, 4)[3], 0);
}

TEST(RasterTarget, APartOfThePageDrawsThatPart) {
  const RasterTriangle triangle = triangleOf({{{0, 0}, {90.3F, 33.7F}, {12.9F, 150}}});
  RasterTarget whole(100, 0, 160);
  drawAll(whole, triangle);
  RasterTarget part(100, 71, 60);
  drawAll(part, triangle);
  for (int row = 0; row < 60; ++row) {
    ASSERT_EQ(rowOf(part, row, 100), rowOf(whole, row + 71, 100)) << row;
  }
}

}  // namespace
}  // namespace espalier::turtle::raster_target_test
