#include "protocol/framing.h"

#include <gtest/gtest.h>

namespace espalier::protocol {
namespace {

TEST(Framing, CutsLinesHoweverTheBytesArrive) {
  LineSplitter splitter(100);
  std::string lines;
  for (const char byte : std::string("one\r\n\n\ntwo\nthree\n")) {
    splitter.feed({&byte, 1});
    for (auto line = splitter.next(); line.data() != nullptr; line = splitter.next()) {
      lines += std::string(line) + "|";
    }
  }
  EXPECT_EQ(lines, "one|two|three|");
  EXPECT_FALSE(splitter.hasPartialLine());
  splitter.feed("cut");
  EXPECT_EQ(splitter.next().data(), nullptr);
  EXPECT_TRUE(splitter.hasPartialLine());
}

TEST(Framing, ALineAtTheLimitPassesAndOneBeyondLosesTheFraming) {
  LineSplitter splitter(4);
  splitter.feed("1234\n12345\nok\n");
  EXPECT_EQ(splitter.next(), "1234");
  EXPECT_EQ(splitter.next().data(), nullptr);
  EXPECT_TRUE(splitter.isOverflowed());
  EXPECT_EQ(splitter.overflowBytes(), 5U);
  splitter.feed("ok\n");
  EXPECT_EQ(splitter.next().data(), nullptr);
}

TEST(Framing, AnEndlessLineIsNoticedBeforeItsEnd) {
  LineSplitter splitter(4);
  splitter.feed("12345");
  EXPECT_EQ(splitter.next().data(), nullptr);
  EXPECT_TRUE(splitter.isOverflowed());
}

}  // namespace
}  // namespace espalier::protocol
