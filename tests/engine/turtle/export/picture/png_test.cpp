#include "engine/turtle/export/picture/png.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "engine/turtle/export/picture/colour_table.h"

namespace espalier::turtle::png_test {
namespace {

// a picture with many colours, opaque or with holes
PictureImage gradient(int width, int height, bool hasHoles) {
  PictureImage image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const bool isHole = hasHoles && (x + y) % 7 == 0;
      image.pixels.insert(image.pixels.end(),
                          {static_cast<std::uint8_t>(x * 3), static_cast<std::uint8_t>(y * 5),
                           static_cast<std::uint8_t>((x * y) % 256), static_cast<std::uint8_t>(isHole ? 90 : 255)});
    }
  }
  return image;
}

std::string bytesOf(const PictureImage& image, int maximumColours = 0) {
  core::StringSink sink;
  EXPECT_EQ(writePng(image, sink, maximumColours), std::nullopt);
  return sink.take();
}

PictureImage readBack(const std::string& bytes) {
  auto read = files::readPngImage(bytes);
  EXPECT_TRUE(read) << read.error();
  return read.value_or(PictureImage{});
}

TEST(Png, WhatIsWrittenIsReadBack) {
  for (const bool hasHoles : {false, true}) {
    const PictureImage image = gradient(61, 33, hasHoles);
    const std::string bytes = bytesOf(image);
    EXPECT_EQ(readBack(bytes), image);
    // the head as the standard has it: signature, then IHDR with width, height, depth 8, colour 2 (RGB) or 6 (RGBA)
    EXPECT_EQ(bytes.substr(0, 8), "\x89PNG\r\n\x1a\n");
    EXPECT_EQ(bytes.substr(12, 4), "IHDR");
    EXPECT_EQ(bytes[19], 61);
    EXPECT_EQ(bytes[23], 33);
    EXPECT_EQ(bytes[24], 8);
    EXPECT_EQ(bytes[25], hasHoles ? 6 : 2);
    // no time of writing
    EXPECT_EQ(bytes.find("tIME"), std::string::npos);
    EXPECT_EQ(bytesOf(image), bytes);
  }
}

TEST(Png, ATableOfColoursKeepsFewColoursExactlyAndApproximatesMany) {
  PictureImage few{4, 1, {1, 2, 3, 255, 250, 0, 0, 255, 1, 2, 3, 255, 9, 9, 9, 255}};
  EXPECT_EQ(readBack(bytesOf(few, 3)), few);

  const PictureImage many = gradient(80, 50, false);
  const std::string bytes = bytesOf(many, 64);
  EXPECT_EQ(bytes[25], 3);  // colour type: a table
  const PictureImage read = readBack(bytes);
  std::set<std::array<int, 3>> colours;
  double error = 0.0;
  for (std::size_t at = 0; at < many.pixels.size(); at += 4) {
    colours.insert({read.pixels[at], read.pixels[at + 1], read.pixels[at + 2]});
    for (std::size_t k = 0; k < 3; ++k) {
      error += std::abs(many.pixels[at + k] - read.pixels[at + k]);
    }
  }
  EXPECT_LE(colours.size(), 64U);
  EXPECT_GT(colours.size(), 50U);
  // 64 colours in a cube of 240 by 250 by 256 are boxes of about 62, whose points are 62/4 from the middle on average
  EXPECT_LT(error / (80 * 50 * 3), 17.0);
  EXPECT_EQ(bytesOf(many, 64), bytes);
}

TEST(Png, DamageAndOtherFilesAreNamed) {
  const auto problemOf = [](std::string_view bytes) {
    const auto read = files::readPngImage(bytes);
    return read ? std::string{} : read.error();
  };
  EXPECT_TRUE(problemOf("GIF89a").starts_with("this is not a PNG picture: ")) << problemOf("GIF89a");
  const std::string bytes = bytesOf(gradient(61, 33, false));
  const std::string cut = problemOf(std::string_view(bytes).substr(0, bytes.size() / 2));
  EXPECT_TRUE(cut.starts_with("the PNG picture is damaged: ")) << cut;
}

}  // namespace
}  // namespace espalier::turtle::png_test
