#include "server/stream/text_difference.h"

#include <gtest/gtest.h>

#include <random>

namespace espalier::server::text_difference_test {
namespace {

std::string applied(std::string_view base, const std::vector<TextPiece>& pieces) {
  std::string text;
  for (const TextPiece& piece : pieces) {
    text += piece.count > 0 ? base.substr(piece.from, piece.count) : piece.own;
  }
  return text;
}

std::size_t ownBytes(const std::vector<TextPiece>& pieces) {
  std::size_t bytes = 0;
  for (const TextPiece& piece : pieces) {
    bytes += piece.own.size();
  }
  return bytes;
}

TEST(TextDifference, AnInsertionIsOwnAndTheRestIsKept) {
  std::string base;
  for (int i = 0; i < 200; ++i) {
    base += "F(" + std::to_string(i) + ")";
  }
  const std::string text = base.substr(0, 301) + "[+A]" + base.substr(301);
  const auto pieces = differenceOf(base, text);
  EXPECT_EQ(applied(base, pieces), text);
  // text that does not begin where the table has a stretch is found a few bytes later, and then from its beginning
  EXPECT_LE(ownBytes(pieces), 4U);
  EXPECT_EQ(pieces.size(), 3U);
}

TEST(TextDifference, TextsWithNothingInCommonAreOwn) {
  EXPECT_EQ(ownBytes(differenceOf("", "FFFF")), 4U);
  EXPECT_TRUE(differenceOf("FFFF", "").empty());
  EXPECT_EQ(ownBytes(differenceOf(std::string(100, 'A'), std::string(100, 'B'))), 100U);
}

TEST(TextDifference, ItsPiecesMakeTheTextWhateverItIs) {
  std::mt19937 dice(7);
  const auto draw = [&dice](std::size_t bound) { return static_cast<std::size_t>(dice()) % bound; };
  for (int round = 0; round < 300; ++round) {
    std::string base;
    for (std::size_t i = draw(400); i > 0; --i) {
      base += "FA[]+-(1)"[draw(9)];
    }
    std::string text = base;
    for (std::size_t i = draw(6); i > 0; --i) {
      const std::size_t at = draw(text.size() + 1);
      text = draw(2) == 0 ? text.substr(0, at) + "X" + text.substr(at) : text.substr(at) + text.substr(0, at);
    }
    ASSERT_EQ(applied(base, differenceOf(base, text)), text) << base;
  }
}

}  // namespace
}  // namespace espalier::server::text_difference_test
