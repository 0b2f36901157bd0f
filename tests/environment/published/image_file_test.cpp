#include <gtest/gtest.h>

#include <png.h>

#include <string>

#include "environment/published/image_file.h"

namespace espalier::environment {
namespace {

std::string problemOf(const std::string& content) {
  const auto decoded = decodeImage(content);
  const auto* problem = std::get_if<std::string>(&decoded);
  return problem == nullptr ? "" : *problem;
}

Image imageOf(const std::string& content) {
  auto decoded = decodeImage(content);
  EXPECT_TRUE(std::holds_alternative<Image>(decoded)) << problemOf(content);
  return std::holds_alternative<Image>(decoded) ? std::get<Image>(decoded) : Image{};
}

std::string sgiHeader(int storage, int width, int height, int channels) {
  std::string header(512, '\0');
  header[0] = '\x01';
  header[1] = '\xda';
  header[2] = static_cast<char>(storage);
  header[3] = 1;
  header[5] = 3;
  header[7] = static_cast<char>(width);
  header[9] = static_cast<char>(height);
  header[11] = static_cast<char>(channels);
  return header;
}

TEST(ImageFile, PnmRowsComeFromTheTop) {
  const Image image = imageOf("P3\n# a comment\n2 2\n255\n1 2 3  4 5 6\n7 8 9  10 11 12\n");
  ASSERT_EQ(image.width, 2U);
  ASSERT_EQ(image.height, 2U);
  EXPECT_EQ(image.at(0, 1, 0), 1);
  EXPECT_EQ(image.at(1, 0, 2), 12);
  EXPECT_EQ(imageOf("P2 1 1 100 50").at(0, 0, 1), 127);
  EXPECT_EQ(imageOf(std::string("P6 1 1 255\n") + "\x10\x20\x30").at(0, 0, 2), 0x30);
  EXPECT_EQ(imageOf(std::string("P5 1 1 255\n") + "\x10").at(0, 0, 2), 0x10);
}

TEST(ImageFile, SgiImagesAreReadPlainAndRunLength) {
  // planes of red, green, blue, each 2 x 2 from the bottom
  const Image plain = imageOf(sgiHeader(0, 2, 2, 3) + "abcdefghijkl");
  EXPECT_EQ(plain.at(0, 0, 0), 'a');
  EXPECT_EQ(plain.at(1, 1, 0), 'd');
  EXPECT_EQ(plain.at(0, 1, 1), 'g');
  EXPECT_EQ(plain.at(1, 1, 2), 'l');
  // one grey row of five: a run of three x, then two literals; tables of one offset and one length
  std::string packed = sgiHeader(1, 5, 1, 1);
  packed += std::string("\0\0\x02\x08\0\0\0\x06", 8) + std::string("\x03x\x82yz\0", 6);
  const Image grey = imageOf(packed);
  EXPECT_EQ(grey.at(2, 0, 0), 'x');
  EXPECT_EQ(grey.at(3, 0, 1), 'y');
  EXPECT_EQ(grey.at(4, 0, 2), 'z');
}

TEST(ImageFile, PngRowsComeFromTheTop) {
  const unsigned char pixels[]{1, 2, 3, 4, 5, 6};
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = 1;
  png.height = 2;
  png.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  ASSERT_NE(png_image_write_to_memory(&png, nullptr, &size, 0, pixels, 0, nullptr), 0);
  std::string content(size, '\0');
  ASSERT_NE(png_image_write_to_memory(&png, content.data(), &size, 0, pixels, 0, nullptr), 0);
  const Image image = imageOf(content.substr(0, size));
  ASSERT_EQ(image.height, 2U);
  EXPECT_EQ(image.at(0, 1, 0), 1);
  EXPECT_EQ(image.at(0, 0, 2), 6);
  EXPECT_NE(problemOf(content.substr(0, 40)).find("is a damaged PNG file: "), std::string::npos);
}

TEST(ImageFile, DamagedAndForeignFilesAreSaid) {
  EXPECT_EQ(problemOf("GIF89a"), "is no image that can be read: use PNG, SGI rgb or PNM");
  EXPECT_EQ(problemOf("P3 2 2"),
            "is a damaged PNM file: its first line must have width, height and a largest value up to 255");
  EXPECT_EQ(problemOf("P2 2 2 255 1 2 3"), "is a damaged PNM file: its pixels are cut off or beyond the largest value");
  EXPECT_EQ(problemOf("P2 99999 99999 255 1"), "has no pixels or more than 67108864");
  EXPECT_EQ(problemOf("\x01\xda\x01"), "is a damaged SGI image: its header is cut off");
  EXPECT_EQ(problemOf(sgiHeader(0, 2, 2, 3) + "abc"), "is a damaged SGI image: its rows are cut off");
  EXPECT_EQ(problemOf(sgiHeader(1, 2, 2, 3)), "is a damaged SGI image: its tables are cut off");
  std::string twoBytes = sgiHeader(0, 1, 1, 1);
  twoBytes[3] = 2;
  EXPECT_EQ(problemOf(twoBytes), "is an SGI image with two bytes a channel: one byte is read");
  EXPECT_EQ(problemOf(sgiHeader(1, 5, 1, 1) + std::string("\0\0\x02\x08\0\0\0\x03", 8) + std::string("\x03x\0", 3)),
            "is a damaged SGI image: a row has a wrong length");
}

}  // namespace
}  // namespace espalier::environment
