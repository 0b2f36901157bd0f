#include "environment/output/field_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

namespace espalier::environment::field_picture_test {
namespace {

using files::Image;
using turtle::Field;
using Colour = std::array<std::uint8_t, 3>;

Colour colourAt(const Image& image, int x, int y) {
  const std::size_t at = 4 * static_cast<std::size_t>(y * image.width + x);
  return {image.pixels[at], image.pixels[at + 1], image.pixels[at + 2]};
}

/// How many pixels have a colour in each row of an image.
std::vector<int> pixelsInRows(const Image& image, const Colour& colour) {
  std::vector<int> counts(static_cast<std::size_t>(image.height), 0);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      counts[static_cast<std::size_t>(y)] += colourAt(image, x, y) == colour ? 1 : 0;
    }
  }
  return counts;
}

Image draw(const Field& field, const FieldView& view) {
  return drawField(field, view, viewField(field, view).value());
}

constexpr Colour kBlue{68, 1, 84};
constexpr Colour kYellow{253, 231, 37};

TEST(FieldPicture, CellsAreAsWideAndHighAsTheyAre) {
  // two cells beside each other, each three times as wide as high: 6 by 1, so 512 by 85 pixels
  const Image image = draw({"water", "1", {2, 1, 1}, {0, 0, 0}, {3, 1, 1}, {0, 1}}, {2, std::nullopt});
  int rows = 0;
  for (const int count : pixelsInRows(image, kBlue)) {
    rows += count >= 256 ? 1 : 0;
    EXPECT_LE(count, 256 + 24) << "the cell, and the bar";
  }
  EXPECT_EQ(rows, 85);
}

TEST(FieldPicture, TheGreatestNumberIsAtTheTopOfTheBar) {
  // seen along y the smallest z is at the top: yellow above, blue below, and the same in the bar
  const Image image = draw({"light", "W/m^2", {1, 1, 2}, {0, 0, 0}, {2, 1, 1}, {5, 3}}, {1, std::nullopt});
  const auto yellow = pixelsInRows(image, kYellow);
  const auto blue = pixelsInRows(image, kBlue);
  const auto first = [](const std::vector<int>& rows) {
    return std::find_if(rows.begin(), rows.end(), [](int count) { return count > 0; }) - rows.begin();
  };
  EXPECT_LT(first(yellow), first(blue));
  // the bar's first row is yellow beside the first row of the plane
  EXPECT_EQ(yellow[static_cast<std::size_t>(first(yellow))], 512 + 24);
}

TEST(FieldPicture, EveryFigureHasItsNumbersAndLettersWithinThePage) {
  for (const Field& field :
       {Field{"water", "1", {2, 1, 1}, {0, 0, 0}, {3, 1, 1}, {0, 1}}, Field{"x", "", {1, 1, 1}, {}, {1e-9, 1, 1}, {7}},
        Field{"a long name with much to say about what it is",
              "umol/(m^2 s)",
              {1, 9, 1},
              {},
              {1, 1, 1},
              std::vector<double>(9, 1e300)},
        Field{"far", "m", {3, 1, 1}, {1e9, -1e9, 0}, {1e-3, 1e-3, 1}, {-1e-300, 0, 1e-300}}}) {
    const Image image = draw(field, {2, std::nullopt});
    EXPECT_EQ(image.pixels.size(), 4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    EXPECT_LE(image.width, 900) << field.name;
    EXPECT_LE(image.height, 700) << field.name;
    // a margin of white all around: nothing was cut off
    for (int x = 0; x < image.width; ++x) {
      EXPECT_EQ(colourAt(image, x, 0), (Colour{255, 255, 255}));
      EXPECT_EQ(colourAt(image, x, image.height - 1), (Colour{255, 255, 255}));
    }
    for (int y = 0; y < image.height; ++y) {
      EXPECT_EQ(colourAt(image, 0, y), (Colour{255, 255, 255})) << field.name;
      EXPECT_EQ(colourAt(image, image.width - 1, y), (Colour{255, 255, 255})) << field.name;
    }
  }
}

TEST(FieldPicture, WhatIsNoNumberIsGreyAndDoesNotCount) {
  const double none = std::nan("");
  const Image image = draw({"water", "1", {3, 1, 1}, {0, 0, 0}, {1, 1, 1}, {0, none, 1}}, {2, std::nullopt});
  std::set<Colour> colours;
  for (int x = 0; x < image.width; ++x) {
    colours.insert(colourAt(image, x, 80));
  }
  EXPECT_TRUE(colours.contains(kBlue));
  EXPECT_TRUE(colours.contains(kYellow));
  EXPECT_TRUE(colours.contains(Colour{190, 190, 190}));
}

}  // namespace
}  // namespace espalier::environment::field_picture_test
