#include "engine/files/utf8.h"

#include <gtest/gtest.h>

namespace espalier::files::utf8_test {
namespace {

TEST(Utf8, SequencesHaveOneToFourBytes) {
  EXPECT_EQ(sequenceLength("F"), 1U);
  EXPECT_EQ(sequenceLength("δF"), 2U);
  EXPECT_EQ(sequenceLength("→F"), 3U);
  EXPECT_EQ(sequenceLength("\xF0\x9F\x8C\xB1"), 4U);
}

TEST(Utf8, AnInvalidSequenceHasNoLength) {
  // empty, cut off, a continuation byte, two overlong forms, beyond the last code point
  for (const char* const text : {"", "\xCE", "\xE2\x86", "\x86", "\xC0\x80", "\xC1\xBF", "\xF5\x80\x80\x80", "\xCE!"}) {
    EXPECT_EQ(sequenceLength(text), 0U) << text;
  }
}

TEST(Utf8, TheByteOrderMarkIsNoText) {
  EXPECT_EQ(withoutByteOrderMark("\xEF\xBB\xBFω"), "ω");
  EXPECT_EQ(withoutByteOrderMark("\xEF\xBB"), "\xEF\xBB");
  EXPECT_EQ(asUtf8("\xEF\xBB\xBFω"), "ω");
}

TEST(Utf8, OtherTextIsTakenForLatin1) {
  EXPECT_EQ(asUtf8("25,7\xB0 Esp\xE9\x63ie"), "25,7° Espécie");
  EXPECT_EQ(asUtf8("δ = 25,7°"), "δ = 25,7°");
  EXPECT_EQ(asUtf8(""), "");
}

}  // namespace
}  // namespace espalier::files::utf8_test
