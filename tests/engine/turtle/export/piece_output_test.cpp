#include "engine/turtle/export/piece_output.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace espalier::turtle {
namespace {

/// Remembers the size of each piece.
class PieceSink final : public core::ByteSink {
 public:
  void write(std::string_view bytes) override {
    text.append(bytes);
    sizes.push_back(bytes.size());
  }
  std::string text;
  std::vector<std::size_t> sizes;
};

std::string lettersOf(std::size_t count) {
  std::string text(count, ' ');
  for (std::size_t i = 0; i < count; ++i) {
    text[i] = static_cast<char>('a' + i % 26);
  }
  return text;
}

TEST(PieceOutput, WritesOfEverySizeComeInOrder) {
  PieceSink sink;
  std::string inString;
  std::string expected;
  PieceOutput toSink(sink);
  PieceOutput toString(inString);
  for (const std::size_t size : {0U, 1U, 511U, 512U, 513U, 1U, 1024U, 65'536U, 65'537U, 3U, 200'000U, 0U, 7U}) {
    const std::string text = lettersOf(size);
    toSink.bytes(text);
    toString.bytes(text);
    expected += text;
  }
  toSink.bytes({});
  toString.bytes({});
  toSink.flush();
  toString.flush();
  EXPECT_EQ(sink.text, expected);
  EXPECT_EQ(inString, expected);
}

TEST(PieceOutput, KeepsWhatFitsInTheRoom) {
  std::string text;
  PieceOutput out(text);
  std::string expected;
  for (int i = 0; i < 1000; ++i) {
    char* const to = out.room(PieceOutput::kMostRoom);
    const std::size_t size = static_cast<std::size_t>(i) % (PieceOutput::kMostRoom + 1);
    std::fill_n(to, size, static_cast<char>('a' + i % 26));
    out.take(size);
    expected.append(size, static_cast<char>('a' + i % 26));
  }
  EXPECT_NE(text, expected) << "the last ones are not in the string before";
  out.flush();
  EXPECT_EQ(text, expected);
}

/// Throws at a write after so many bytes.
class FullSink final : public core::ByteSink {
 public:
  explicit FullSink(std::size_t most) : most_(most) {}
  void write(std::string_view bytes) override {
    if (size_ + bytes.size() > most_) {
      throw std::length_error("full");
    }
    size_ += bytes.size();
  }

 private:
  std::size_t most_;
  std::size_t size_ = 0;
};

TEST(PieceOutput, AFullSinkIsNotWrittenToAgainAtTheEnd) {
  for (const std::size_t most : {0U, 1'000U, 100'000U}) {
    FullSink sink(most);
    EXPECT_THROW(
        {
          PieceOutput out(sink);
          for (int i = 0; i < 100'000; ++i) {
            out.bytes("1234567");
          }
          out.flush();
        },
        std::length_error)
        << most;
  }
  FullSink sink(0);
  PieceOutput out(sink);
  out.bytes("left where it is, because nobody asked for it");
}

TEST(PieceOutput, HandsSmallWritesOnInLargePieces) {
  PieceSink sink;
  PieceOutput out(sink);
  for (int i = 0; i < 100'000; ++i) {
    out.bytes("1234567");
  }
  out.flush();
  EXPECT_EQ(sink.text.size(), 700'000U);
  ASSERT_GE(sink.sizes.size(), 2U);
  sink.sizes.pop_back();
  EXPECT_GE(std::ranges::min(sink.sizes), 65'536U);
  EXPECT_LE(std::ranges::max(sink.sizes), 70'000U);
}

}  // namespace
}  // namespace espalier::turtle
