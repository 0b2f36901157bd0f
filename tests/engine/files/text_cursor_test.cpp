#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "engine/files/text_cursor.h"

namespace espalier::files::text_cursor_test {
namespace {

std::optional<double> number(std::string_view text) {
  return TextCursor(text).number();
}

TEST(TextCursor, ReadsNumbersAsStrtodDoes) {
  EXPECT_EQ(number(".5"), 0.5);
  EXPECT_EQ(number("2."), 2.0);
  EXPECT_EQ(number("1e3"), 1000.0);
  EXPECT_EQ(number("+4"), 4.0);
  EXPECT_EQ(number("-.25x"), -0.25);
  EXPECT_EQ(number("1e"), 1.0);
  EXPECT_EQ(number("1e-999"), 0.0);
}

TEST(TextCursor, RefusesNumbersThatAreNotDecimalAndFinite) {
  for (const char* text : {"", "x", "-", "+-1", "--1", ".", "inf", "nan", "-inf", "1e999"}) {
    EXPECT_EQ(number(text), std::nullopt) << text;
  }
}

TEST(TextCursor, NumberStopsBehindItself) {
  TextCursor cursor("1e5e6");
  EXPECT_EQ(cursor.number(), 1e5);
  EXPECT_EQ(cursor.position(), 3U);
  TextCursor failed("abc");
  EXPECT_FALSE(failed.number().has_value());
  EXPECT_EQ(failed.position(), 0U);
}

TEST(TextCursor, IntegersAreBounded) {
  EXPECT_EQ(TextCursor("-12.5").integer(), -12);
  EXPECT_EQ(TextCursor("99999999999999999999").integer(), TextCursor::kLargestInteger);
  EXPECT_EQ(TextCursor("-99999999999999999999").integer(), -TextCursor::kLargestInteger);
  EXPECT_EQ(TextCursor("+").integer(), std::nullopt);
}

TEST(TextCursor, LinesKeepTheirOffsets) {
  TextCursor cursor("ab\r\ncd");
  TextCursor first = cursor.takeLine();
  EXPECT_EQ(first.rest(), "ab");
  TextCursor second = cursor.takeLine();
  EXPECT_EQ(second.position(), 4U);
  EXPECT_EQ(second.rest(), "cd");
  EXPECT_TRUE(cursor.atEnd());
}

TEST(TextCursor, KeywordsMatchAcrossBlanksOrNotAtAll) {
  TextCursor cursor("END\n  POINT  X:1");
  EXPECT_TRUE(cursor.takeKeywords("END POINT "));
  EXPECT_FALSE(cursor.takeKeywords("Y: "));
  EXPECT_TRUE(cursor.takeKeywords("X: "));
  EXPECT_EQ(cursor.number(), 1.0);
}

}  // namespace
}  // namespace espalier::files::text_cursor_test
