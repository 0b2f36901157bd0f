#include <gtest/gtest.h>
#include <png.h>

#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "protocol/base64.h"
#include "tests/server/server_fixture.h"
#include "tests/support/places.h"

namespace espalier::server::pictures_in_use_test {
namespace {

constexpr std::uint64_t kMemoryBytes = 30'000'000;

/// The answer to the check of a model with a texture, on a server with 30 MB.
client::Outcome checked(const std::string& name, const std::string& picture) {
  ServerOptions options;
  options.limits.memoryBytes = kMemoryBytes;
  const RunningServer server(options);
  protocol::JsonWriter params;
  params.beginObject().key("main").text("tree.l").key("files").beginObject();
  params.key("tree.l").text("Lsystem: 1\nderivation length: 1\nAxiom: F(1)\nF(x) --> F(x)\nendlsystem\n");
  params.key("tree.v").text("texture: F " + name + "\n").endObject();
  params.key("binaryFiles").beginObject().key(name).text(protocol::toBase64(picture)).endObject().endObject();
  return connectTo(server)->request("model.check", params.view());
}

/// A black PNG picture.
std::string blackPng(unsigned width, unsigned height) {
  const std::vector<unsigned char> pixels(std::size_t{width} * height, 0);
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = width;
  png.height = height;
  png.format = PNG_FORMAT_GRAY;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  EXPECT_NE(png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels.data(), 0, nullptr), 0);
  bytes.resize(size);
  return bytes;
}

/// A progressive JPEG picture whose header says another size.
std::string progressiveJpeg(unsigned side) {
  std::ifstream file(sourceFolder() + "/tests/engine/files/images/progressive.jpg", std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const std::size_t size = bytes.find("\xff\xc2") + 5;
  for (std::size_t at = size; at < size + 4; at += 2) {
    bytes[at] = static_cast<char>(side >> 8U);
    bytes[at + 1] = static_cast<char>(side & 0xFFU);
  }
  return bytes;
}

TEST(PicturesInUse, AFewBytesTakeNoMoreMemoryThanThereIs) {
  const std::string small = blackPng(100, 100);
  EXPECT_NE(resultOf(checked("bark.png", small)), "");
  // 36 MB of pixels
  const std::string large = blackPng(3000, 3000);
  EXPECT_LT(large.size(), 100'000U);
  EXPECT_EQ(member(errorOf(checked("bark.png", large)).data, "limit"), "memoryBytes");
  // 16 MB of pixels, and 24 MB that libjpeg keeps for the scans
  EXPECT_EQ(member(errorOf(checked("bark.jpg", progressiveJpeg(2000))).data, "limit"), "memoryBytes");
  EXPECT_NE(resultOf(checked("bark.jpg", progressiveJpeg(1000))), "");
}

TEST(PicturesInUse, APictureThatIsShorterThanItsSizeSaysTakesNoMemory) {
  const std::string tga("\0\0\x02\0\0\0\0\0\0\0\0\0\0\x20\0\x20\x18\0abc", 21);
  std::string packed = tga;
  packed[2] = 10;
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>("bark.pgm", "P2 8192 8192 255 1 2 3"),
                                    {"bark.ppm", "P6 8192 8192 255 abc"},
                                    {"bark.tga", tga},
                                    {"bark.tga", packed}}) {
    const std::string found = resultOf(checked(name, bytes));
    EXPECT_NE(found.find("the file ends before the picture is complete"), std::string::npos) << name << ": " << found;
  }
}

}  // namespace
}  // namespace espalier::server::pictures_in_use_test
