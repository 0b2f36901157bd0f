#include "server/store/compression.h"

#include <gtest/gtest.h>

#include <string>

namespace espalier::server::compression_test {
namespace {

TEST(Compression, AFrameThatPromisesMoreThanItCanHoldIsDamaged) {
  // a frame of one empty block that says that it has 2^60 bytes
  const std::string frame("\x28\xB5\x2F\xFD\xE0\0\0\0\0\0\0\0\x10\x01\0\0", 16);
  EXPECT_EQ(decompress(frame), std::nullopt);
  std::string cut = compress(std::string(1'000, 'x'));
  cut.resize(cut.size() - 1);
  EXPECT_EQ(decompress(cut), std::nullopt);
  EXPECT_EQ(decompress("no frame"), std::nullopt);
}

TEST(Compression, AFewBytesDoNotFillTheMemory) {
  const std::string packed = compress(std::string(10'000'000, 'x'));
  EXPECT_LT(packed.size(), 2'000U);
  EXPECT_EQ(decompress(packed, 9'999'999), std::nullopt);
  EXPECT_EQ(decompress(packed, 10'000'000), std::string(10'000'000, 'x'));
}

}  // namespace
}  // namespace espalier::server::compression_test
