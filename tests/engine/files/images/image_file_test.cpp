#include "engine/files/images/image_file.h"

#include <gtest/gtest.h>
#include <png.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "tests/support/places.h"

namespace espalier::files::image_file_test {
namespace {

std::string fileText(const std::string& name) {
  std::ifstream file(sourceFolder() + "/tests/engine/files/images/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

Image imageOf(const std::string& name, const std::string& bytes) {
  auto read = readImageFile(name, bytes);
  EXPECT_TRUE(read) << name << ": " << read.error();
  return read.value_or(Image{});
}

std::string problemOf(const std::string& name, const std::string& bytes) {
  const auto read = readImageFile(name, bytes);
  EXPECT_FALSE(read) << name;
  return read ? "" : read.error();
}

std::array<int, 4> pixelAt(const Image& image, int x, int y) {
  return {image.at(x, y, 0), image.at(x, y, 1), image.at(x, y, 2), image.at(x, y, 3)};
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

// a Utah header of 8 bits a channel with a background of 1, 2, 3, without maps and comment
std::string utahHeader(int flags, int width, int height, int channels) {
  std::string bytes("\x52\xcc\0\0\0\0\0\0\0\0\0\0\x08\0\0", 15);
  bytes[6] = static_cast<char>(width);
  bytes[8] = static_cast<char>(height);
  bytes[10] = static_cast<char>(flags);
  bytes[11] = static_cast<char>(channels);
  return bytes + ((flags & 2) != 0 ? std::string(1, '\0') : std::string("\1\2\3").substr(0, channels == 1 ? 1 : 3));
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

TEST(ImageFile, TheSamePictureInThreeFormatsAgrees) {
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
  EXPECT_EQ(problemOf("a.rgb", bytes.substr(0, bytes.size() - 1)), "the file ends before the picture is complete");
  // one channel is grey
  EXPECT_EQ(pixelAt(imageOf("a.bw", sgiHeader(0, 2, 1, 1, 1) + "\x07"), 0, 0), (std::array{7, 7, 7, 255}));
}

TEST(ImageFile, ABrokenSgiPictureIsAnErrorWithAReason) {
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(0, 3, 2, 2, 3, 2)),
            "the SGI picture has more than one byte a channel; only one byte is supported");
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(0, 3, 2, 2, 5)), "the SGI picture has 5 channels; 1 to 4 are supported");
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(0, 3, 0, 2, 3)), "the picture has no pixels");
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(0, 3, 2, 2, 3) + "abc"), "the file ends before the picture is complete");
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(1, 3, 2, 2, 3)), "the file ends before the picture is complete");
  EXPECT_EQ(problemOf("a.rgb", "\x01\xda\x01"), "this is not an SGI picture");
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(7, 3, 2, 2, 3)), "this is not an SGI picture");
  // tables that point nowhere
  EXPECT_EQ(problemOf("a.rgb", sgiHeader(1, 3, 1, 1, 1) + std::string(8, '\xff')), "row 0 of channel 0 is damaged");
  // a run longer than the row
  std::string run = sgiHeader(1, 3, 2, 1, 1) + std::string("\0\0\x02\x08\0\0\0\x03\x05\x09\x00", 11);
  EXPECT_EQ(problemOf("a.rgb", run), "row 0 of channel 0 is damaged");
  run[520] = 2;
  EXPECT_EQ(pixelAt(imageOf("a.rgb", run), 1, 0), (std::array{9, 9, 9, 255}));
}

TEST(ImageFile, AnSgiRowHasRunsAndLiterals) {
  // one grey row of five: a run of three x, then two literals; tables of one offset and one length
  std::string packed = sgiHeader(1, 3, 5, 1, 1);
  packed += std::string("\0\0\x02\x08\0\0\0\x06", 8) + std::string("\x03x\x82yz\0", 6);
  const Image grey = imageOf("a.rgb", packed);
  EXPECT_EQ(pixelAt(grey, 2, 0), (std::array<int, 4>{'x', 'x', 'x', 255}));
  EXPECT_EQ(grey.at(3, 0, 1), 'y');
  EXPECT_EQ(grey.at(4, 0, 2), 'z');
}

TEST(ImageFile, PnmRowsComeFromTheTop) {
  const Image image = imageOf("a", "P3\n# a comment\n2 2\n255\n1 2 3  4 5 6\n7 8 9  10 11 12\n");
  EXPECT_EQ(image.width, 2);
  EXPECT_EQ(image.height, 2);
  EXPECT_EQ(pixelAt(image, 0, 0), (std::array{1, 2, 3, 255}));
  EXPECT_EQ(pixelAt(image, 1, 1), (std::array{10, 11, 12, 255}));
  EXPECT_EQ(imageOf("a", "P2 1 1 100 50").at(0, 0, 1), 127);
  EXPECT_EQ(imageOf("a", std::string("P6 1 1 255\n") + "\x10\x20\x30").at(0, 0, 2), 0x30);
  EXPECT_EQ(imageOf("a", std::string("P5 1 1 255\n") + "\x10").at(0, 0, 2), 0x10);
  EXPECT_EQ(problemOf("a", "P3 2 2"), "the PNM picture must begin with width, height and a largest value up to 255");
  EXPECT_EQ(problemOf("a", "P2 2 2 255 1 2 3"), "the file ends before the picture is complete");
  EXPECT_EQ(problemOf("a", "P2 1 1 100 101"), "the PNM picture has a value above its largest value, 100");
  EXPECT_EQ(problemOf("a", "P2 99999 99999 255 1"),
            "the picture has 99999 by 99999 pixels; at most 67108864 pixels are read");
}

TEST(ImageFile, OverBlackLaysPngOverBlackAndDropsTheOpacityOfOtherFormats) {
  const std::array<unsigned char, 8> pixels{255, 40, 0, 128, 9, 8, 7, 255};
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = 1;
  png.height = 2;
  png.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = 0;
  ASSERT_NE(png_image_write_to_memory(&png, nullptr, &size, 0, pixels.data(), 0, nullptr), 0);
  std::string bytes(size, '\0');
  ASSERT_NE(png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels.data(), 0, nullptr), 0);
  const auto kept = readImageFile("a.png", bytes);
  const auto opaque = readImageFile("a.png", bytes, Opacity::OverBlack);
  ASSERT_TRUE(kept && opaque);
  EXPECT_EQ(pixelAt(*kept, 0, 0), (std::array{255, 40, 0, 128}));
  EXPECT_EQ(pixelAt(*kept, 0, 1), (std::array{9, 8, 7, 255}));
  // half of white light is not half of its sRGB number: 255 * 0.502 ^ (1 / 2.2)
  EXPECT_NEAR(opaque->at(0, 0, 0), 188, 2);
  EXPECT_EQ(opaque->at(0, 0, 3), 255);
  EXPECT_EQ(pixelAt(*opaque, 0, 1), (std::array{9, 8, 7, 255}));
  const auto sgi = readImageFile("a.rgb", sgiHeader(0, 3, 1, 1, 4) + "abc\x09", Opacity::OverBlack);
  ASSERT_TRUE(sgi);
  EXPECT_EQ(pixelAt(*sgi, 0, 0), (std::array<int, 4>{'a', 'b', 'c', 255}));
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
  EXPECT_EQ(problemOf("a.tga", tgaHeader(2, 2, 2, 24, 0) + points), "the file ends before the picture is complete");
  EXPECT_EQ(problemOf("a.tga", tgaHeader(1, 2, 2, 8, 0) + points), "this is not a TGA picture of true colour or grey");
}

TEST(ImageFile, ATgaPictureThatIsCutOffAnywhereIsRefused) {
  for (const std::string& whole :
       {tgaHeader(2, 2, 1, 24, 0) + "\x03\x02\x01\x06\x05\x04", tgaHeader(10, 3, 1, 32, 0) + "\x82\x04\x03\x02\x01"}) {
    EXPECT_FALSE(imageOf("a.tga", whole).pixels.empty());
    for (std::size_t bytes = 0; bytes < whole.size(); ++bytes) {
      EXPECT_NE(problemOf("a.tga", whole.substr(0, bytes)), "") << bytes;
    }
  }
}

TEST(ImageFile, AnUnknownFormatIsAnErrorThatNamesTheKnownOnes) {
  const std::string kinds = "the format is unknown; use PNG, JPEG, SGI (.rgb), Utah (.rle), PNM or TGA";
  EXPECT_EQ(problemOf("a.bmp", "BM..."), kinds);
  EXPECT_EQ(problemOf("a.rle", ""), kinds);
  EXPECT_TRUE(problemOf("a.png", fileText("python.png").substr(0, 900)).starts_with("the PNG picture is damaged: "));
  EXPECT_TRUE(problemOf("a.jpg", fileText("python.jpg").substr(0, 10)).starts_with("this is not a JPEG picture: "));
  std::string broken = fileText("python.jpg");
  broken.replace(20, 60, 60, '\0');
  EXPECT_NE(problemOf("a.jpg", broken).find("JPEG picture"), std::string::npos);
}

TEST(ImageFile, AJpegPictureOfMoreThanAHundredScansIsRefused) {
  // the whole last scan of a progressive picture again and again
  const std::string once = fileText("progressive.jpg");
  const std::size_t scan = once.rfind("\xff\xda");
  ASSERT_NE(scan, std::string::npos);
  const std::size_t end = once.size() - 2;
  const auto withFurtherScans = [&](int count) {
    std::string bytes = once.substr(0, end);
    for (int i = 0; i < count; ++i) {
      bytes += once.substr(scan, end - scan);
    }
    return bytes + once.substr(end);
  };
  EXPECT_EQ(imageOf("a.jpg", withFurtherScans(50)).width, 16);
  EXPECT_EQ(problemOf("a.jpg", withFurtherScans(100)), "the JPEG picture is damaged: it has more than 100 scans");
}

TEST(UtahImage, RunsBytesAndSkipsAreRead) {
  // bottom row: red 9 9 (a run), green 7 8 (bytes); the row above: blue from the second pixel on; a long operand
  const std::string bytes = utahHeader(0, 2, 3, 3) + std::string("\x02\0\x06\x01\x09\0\x02\x01\x05\x01\x07\x08", 12) +
                            std::string("\x41\0\x01\0\x02\x02\x03\x01\x05\0\x0b\0\x07\0", 14);
  const Image image = imageOf("a.rle", bytes);
  EXPECT_EQ(pixelAt(image, 0, 2), (std::array{9, 7, 3, 255}));
  EXPECT_EQ(pixelAt(image, 1, 2), (std::array{9, 8, 3, 255}));
  EXPECT_EQ(pixelAt(image, 0, 1), (std::array{1, 2, 3, 255}));
  EXPECT_EQ(pixelAt(image, 1, 1), (std::array{1, 2, 11, 255}));
  EXPECT_EQ(pixelAt(image, 1, 0), (std::array{1, 2, 3, 255}));
}

TEST(UtahImage, OpacityAndGreyAreRead) {
  const std::string bytes =
      utahHeader(2 | 4, 2, 1, 1) + std::string("\x02\0\x06\x01\x28\0\x02\xff\x05\0\x50\0\x07\0", 14);
  const Image image = imageOf("grey", bytes);
  EXPECT_EQ(pixelAt(image, 0, 0), (std::array{40, 40, 40, 80}));
  EXPECT_EQ(pixelAt(image, 1, 0), (std::array{40, 40, 40, 0}));
}

TEST(UtahImage, ColourMapsAndCommentsArePassed) {
  std::string bytes = utahHeader(2 | 8, 1, 1, 1);
  bytes[13] = 3;  // maps of 2 entries
  bytes[14] = 1;
  for (const int value : {10, 20, 30, 40, 50, 60}) {
    bytes += std::string(1, '\0') + static_cast<char>(value);
  }
  bytes += std::string("\x03\0abc\0", 6) + std::string("\x02\0\x05\0\x01\0\x07\0", 8);
  EXPECT_EQ(pixelAt(imageOf("m.rle", bytes), 0, 0), (std::array{20, 40, 60, 255}));
}

TEST(UtahImage, DamagedFilesAreNamed) {
  const std::string good = utahHeader(0, 2, 1, 3) + std::string("\x05\x01\x07\x08\x07\0", 6);
  EXPECT_EQ(problemOf("a.rle", good.substr(0, good.size() - 2)), "the file ends before the picture is complete");
  EXPECT_EQ(problemOf("a.rle", good.substr(0, good.size() - 3)), "the file ends before the picture is complete");
  EXPECT_EQ(problemOf("a.rle", utahHeader(0, 2, 1, 3) + "\x09 "), "byte 20 of the Utah picture is no operation");
  EXPECT_EQ(problemOf("a.rle", utahHeader(0, 2, 1, 2)), "the Utah picture has 2 channels; 1 and 3 are supported");
  EXPECT_EQ(problemOf("a.rle", utahHeader(0, 0, 1, 3)), "the picture has no pixels");
  EXPECT_EQ(problemOf("a.rle", "\x52\xcc"), "this is not a Utah picture of 8 bits a channel");
}

}  // namespace
}  // namespace espalier::files::image_file_test
