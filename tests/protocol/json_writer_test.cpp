#include "protocol/json_writer.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "protocol/codec.h"

namespace espalier::protocol::json_writer_test {
namespace {

std::string number(double value) {
  return JsonWriter().number(value).take();
}

/// Through text and the decoder, as between two programs.
double roundTrip(double value) {
  const std::string line =
      R"({"jsonrpc":"2.0","id":1,"result":{"replies":[{"id":0,"parameters":[)" + number(value) + "]}]}}";
  const auto message = decodeMessage(line).value();
  return decodeReplies(message.payload, 1).value().values[0];
}

TEST(JsonWriter, WritesTheShortestDecimalThatReadsBack) {
  EXPECT_EQ(number(0.1), "0.1");
  EXPECT_EQ(number(3.0), "3");
  EXPECT_EQ(number(1e300), "1e+300");
  EXPECT_EQ(number(-0.0), "-0.0");
}

TEST(JsonWriter, EveryDoubleCrossesTheWireBitwise) {
  const std::vector<double> special{0.0,
                                    -0.0,
                                    1.0,
                                    0.1,
                                    1.0 / 3.0,
                                    9007199254740993.0,
                                    18446744073709551616.0,
                                    -9223372036854775808.0,
                                    1e22,
                                    1e23,
                                    std::numeric_limits<double>::max(),
                                    std::numeric_limits<double>::min(),
                                    std::numeric_limits<double>::denorm_min()};
  for (const double value : special) {
    EXPECT_EQ(std::bit_cast<std::uint64_t>(roundTrip(value)), std::bit_cast<std::uint64_t>(value)) << number(value);
  }
  std::mt19937_64 bits(20260101);
  for (int i = 0; i < 2'000; ++i) {
    const auto value = std::bit_cast<double>(bits());
    if (std::isfinite(value)) {
      EXPECT_EQ(std::bit_cast<std::uint64_t>(roundTrip(value)), std::bit_cast<std::uint64_t>(value)) << number(value);
    }
  }
}

TEST(JsonWriter, RefusesNumbersThatJsonDoesNotHave) {
  EXPECT_THROW(number(std::nan("")), NonFiniteNumber);
  EXPECT_THROW(number(std::numeric_limits<double>::infinity()), NonFiniteNumber);
}

TEST(JsonWriter, EscapesTextAndReplacesWhatIsNotUtf8) {
  EXPECT_EQ(JsonWriter().text("a\"b\\c\n\t\x01").take(), R"("a\"b\\c\n\t\u0001")");
  EXPECT_EQ(JsonWriter().text("gr\xc3\xbcn \xe2\x82\xac \xf0\x9f\x8c\xb1").take(),
            "\"gr\xc3\xbcn \xe2\x82\xac \xf0\x9f\x8c\xb1\"");
  // Latin-1, an overlong slash, a surrogate, a cut sequence
  EXPECT_EQ(JsonWriter().text("\xfc").take(), "\"\xef\xbf\xbd\"");
  EXPECT_EQ(JsonWriter().text("\xc0\xaf").take(), "\"\xef\xbf\xbd\xef\xbf\xbd\"");
  EXPECT_EQ(JsonWriter().text("\xed\xa0\x80").take(), "\"\xef\xbf\xbd\xef\xbf\xbd\xef\xbf\xbd\"");
  EXPECT_EQ(JsonWriter().text("\xe2\x82").take(), "\"\xef\xbf\xbd\xef\xbf\xbd\"");
}

TEST(JsonWriter, PlacesCommas) {
  JsonWriter writer;
  writer.beginObject().key("a").beginArray().integer(1).beginObject().endObject().null().endArray();
  writer.key("b").boolean(true).key("c").raw("[2]").endObject();
  EXPECT_EQ(writer.view(), R"({"a":[1,{},null],"b":true,"c":[2]})");
}

}  // namespace
}  // namespace espalier::protocol::json_writer_test
