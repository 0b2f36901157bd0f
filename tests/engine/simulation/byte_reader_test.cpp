#include "engine/simulation/byte_reader.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "engine/simulation/byte_writer.h"

namespace espalier::simulation::byte_reader_test {
namespace {

TEST(ByteReader, ReadsWhatWasWritten) {
  ByteWriter writer;
  writer.byte(200);
  writer.flag(true);
  writer.number16(0xBEEF);
  writer.number32(0xDEADBEEF);
  writer.number64(0x0123456789ABCDEFULL);
  writer.real(-0.1);
  writer.text("growth");
  writer.reals(std::array{1.5, std::numeric_limits<double>::infinity()});
  ByteReader reader(writer.bytes());
  EXPECT_EQ(reader.byte(), 200);
  EXPECT_TRUE(reader.flag());
  EXPECT_EQ(reader.number16(), 0xBEEF);
  EXPECT_EQ(reader.number32(), 0xDEADBEEFU);
  EXPECT_EQ(reader.number64(), 0x0123456789ABCDEFULL);
  EXPECT_EQ(reader.real(), -0.1);
  EXPECT_EQ(reader.text(), "growth");
  EXPECT_EQ(reader.reals(), (std::vector<double>{1.5, std::numeric_limits<double>::infinity()}));
  EXPECT_EQ(reader.remaining(), 0U);
  EXPECT_FALSE(reader.hasFailed());
}

TEST(ByteReader, NumbersAreLittleEndian) {
  ByteWriter writer;
  writer.number32(1);
  EXPECT_EQ(writer.bytes(), std::string("\1\0\0\0", 4));
}

TEST(ByteReader, ReadingBeyondTheEndFailsForGood) {
  ByteReader reader("abc");
  EXPECT_EQ(reader.number64(), 0U);
  EXPECT_TRUE(reader.hasFailed());
  EXPECT_EQ(reader.byte(), 0);
  EXPECT_EQ(reader.remaining(), 0U);
}

TEST(ByteReader, ALengthThatCannotBeFailsWithoutAllocating) {
  ByteWriter writer;
  writer.number64(std::numeric_limits<std::uint64_t>::max());
  ByteReader text(writer.bytes());
  EXPECT_EQ(text.text(), "");
  EXPECT_TRUE(text.hasFailed());
  ByteReader reals(writer.bytes());
  EXPECT_TRUE(reals.reals().empty());
  EXPECT_TRUE(reals.hasFailed());
}

}  // namespace
}  // namespace espalier::simulation::byte_reader_test
