#include "engine/files/image_file.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "tests/support/places.h"

namespace espalier::language {
namespace {

std::string fileText(const std::string& name) {
  std::ifstream file(sourceFolder() + "/tests/engine/files/images/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Image imageOf(const std::string& name, const std::string& bytes) {
  auto read = readImageFile(name, bytes);
  EXPECT_TRUE(std::holds_alternative<Image>(read)) << name << ": " << std::get<std::string>(read);
  return std::holds_alternative<Image>(read) ? std::get<Image>(std::move(read)) : Image{};
}

std::string problemOf(const std::string& name, const std::string& bytes) {
  const auto read = readImageFile(name, bytes);
  EXPECT_TRUE(std::holds_alternative<std::string>(read)) << name;
  return std::holds_alternative<std::string>(read) ? std::get<std::string>(read) : "";
}

std::array<int, 4> pixelAt(const Image& image, int x, int y) {
  const std::size_t at = static_cast<std::size_t>(y * image.width + x) * 4;
  return {image.pixels[at], image.pixels[at + 1], image.pixels[at + 2], image.pixels[at + 3]};
}

// an SGI header: storage, dimensions, width, height, channels
std::string sgiHeader(int storage, int dimensions, int width, int height, int channels, int channelBytes = 1) {
  std::string bytes(512, '\0');
  const auto put = [&bytes](std::size_t at, int value) {
    bytes[at] = static_cast<char>(value >> 8);
    bytes[at + 1] = static_cast<char>(value & 255);
  };
  put(0, 0x01DA);
  bytes[2] = static_cast<char>(storage);
  bytes[3] = static_cast<char>(channelBytes);
  put(4, dimensions);
  put(6, width);
  put(8, height);
  put(10, channels);
  return bytes;
}

std::string tgaHeader(int kind, int width, int height, int bits, int order) {
  std::string bytes(18, '\0');
  bytes[2] = static_cast<char>(kind);
  bytes[12] = static_cast<char>(width);
  bytes[14] = static_cast<char>(height);
  bytes[16] = static_cast<char>(bits);
  bytes[17] = static_cast<char>(order);
  return bytes;
}

TEST(ImageFile, ForeignPicturesOfOneMotifAgree) {
  const Image png = imageOf("python.png", fileText("python.png"));
  EXPECT_EQ(png.width, 16);
  EXPECT_EQ(png.height, 16);
  // without loss, run-length encoded, bottom row first
  EXPECT_EQ(imageOf("python.sgi", fileText("python.sgi")), png);
  // with loss, most of it of colour
  const Image jpeg = imageOf("python.jpg", fileText("python.jpg"));
  ASSERT_EQ(jpeg.pixels.size(), png.pixels.size());
  const auto brightness = [](const Image& image, std::size_t at) {
    return 0.299 * image.pixels[at] + 0.587 * image.pixels[at + 1] + 0.114 * image.pixels[at + 2];
  };
  double difference = 0.0;
  for (std::size_t at = 0; at < png.pixels.size(); at += 4) {
    difference += std::abs(brightness(jpeg, at) - brightness(png, at));
    EXPECT_EQ(jpeg.pixels[at + 3], 255);
  }
  EXPECT_LT(difference / 256.0, 8.0);
  EXPECT_TRUE(isPng(fileText("python.png")));
  EXPECT_TRUE(isJpeg(fileText("python.jpg")));
  EXPECT_FALSE(isJpeg(fileText("python.sgi")));
}

TEST(ImageFile, AnSgiPictureBeginsWithItsBottomRowAndHasPlanes) {
  // 2 by 2: red 1 2 / 3 4, green 5 6 / 7 8, blue 9 10 / 11 12, opacity 13 14 / 15 16, from the bottom
  std::string bytes = sgiHeader(0, 3, 2, 2, 4);
  for (int i = 1; i <= 16; ++i) {
    bytes.push_back(static_cast<char>(i));
  }
  const Image image = imageOf("a.rgb", bytes);
  EXPECT_EQ(pixelAt(image, 0, 1), (std::array{1, 5, 9, 13}));
  EXPECT_EQ(pixelAt(image, 1, 1), (std::array{2, 6, 10, 14}));
  EXPECT_EQ(pixelAt(image, 0, 0), (std::array{3, 7, 11, 15}));
  EXPECT_EQ(problemOf("a.rgb", bytes.substr(0, bytes.size() - 1)), "the file ends before the picture does");
  // one channel is grey
  EXPECT_EQ(pixelAt(imageOf("a.bw", sgiHeader(0, 2, 1, 1, 1) + "\x07"), 0, 0), (std::array{7, 7, 7, 255}));
}

TEST(ImageFile, ABrokenSgiPictureSaysWhatIsWrong) {
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(0, 3, 2, 2, 3, 2)),
            "the SGI picture has more than one byte a channel; such pictures are not read");
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(0, 3, 2, 2, 5)), "the SGI picture has 5 channels; 1 to 4 are read");
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(0, 3, 0, 2, 3)), "the picture has no points");
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(0, 3, 20'000, 2, 3)),
            "the picture has 20000 by 2 points; at most 16384 each way are read");
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(7, 3, 2, 2, 3)), "this is not an SGI picture");
  // tables that point nowhere
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(1, 3, 1, 1, 1) + std::string(8, '\xff')), "row 0 of channel 0 is damaged");
  // a run longer than the row
  std::string run = sgiHeader(1, 3, 2, 1, 1) + std::string("\0\0\x02\x08\0\0\0\x03\x05\x09\x00", 11);
  EXPECT_EQ(problemOf("a.rgb", run), "row 0 of channel 0 is damaged");
  run[520] = 2;
  EXPECT_EQ(pixelAt(imageOf("a.rgb", run), 1, 0), (std::array{9, 9, 9, 255}));
}

TEST(ImageFile, ATgaPictureIsBlueGreenRedFromTheBottomUnlessItSaysOtherwise) {
  const std::string points("\x03\x02\x01\x06\x05\x04", 6);
  EXPECT_EQ(pixelAt(imageOf("a.tga", tgaHeader(2, 1, 2, 24, 0) + points), 0, 1), (std::array{1, 2, 3, 255}));
  EXPECT_EQ(pixelAt(imageOf("a.tga", tgaHeader(2, 1, 2, 24, 0x20) + points), 0, 0), (std::array{1, 2, 3, 255}));
  EXPECT_EQ(pixelAt(imageOf("a.TGA", tgaHeader(2, 1, 1, 32, 0) + "\x03\x02\x01\x09"), 0, 0), (std::array{1, 2, 3, 9}));
  // a run of two points, then one as it is
  const Image packed =
      imageOf("a.tga", tgaHeader(10, 3, 1, 24, 0) + std::string("\x81\x03\x02\x01\x00\x06\x05\x04", 8));
  EXPECT_EQ(pixelAt(packed, 1, 0), (std::array{1, 2, 3, 255}));
  EXPECT_EQ(pixelAt(packed, 2, 0), (std::array{4, 5, 6, 255}));
  EXPECT_EQ(problemOf("a.tga", tgaHeader(2, 2, 2, 24, 0) + points), "the file ends before the picture does");
  EXPECT_EQ(problemOf("a.tga", tgaHeader(1, 2, 2, 8, 0) + points), "this is no TGA picture of true colour or grey");
}

TEST(ImageFile, WhatIsNoPictureSaysWhichKindsAreRead) {
  const std::string kinds = "it is no picture of a kind that is read: PNG, JPEG, SGI (.rgb) or TGA";
  EXPECT_EQ(problemOf("a.bmp", "BM..."), kinds);
  EXPECT_EQ(problemOf("a.rle", ""), kinds);
  EXPECT_TRUE(problemOf("a.png", fileText("python.png").substr(0, 900)).starts_with("the PNG picture is damaged: "));
  EXPECT_TRUE(problemOf("a.jpg", fileText("python.jpg").substr(0, 10)).starts_with("this is not a JPEG picture: "));
  std::string broken = fileText("python.jpg");
  broken.replace(20, 60, 60, '\0');
  EXPECT_NE(problemOf("a.jpg", broken).find("JPEG picture"), std::string::npos);
}

}  // namespace
}  // namespace espalier::language
