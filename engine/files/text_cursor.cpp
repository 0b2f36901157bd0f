#include "engine/files/text_cursor.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

namespace espalier::files {
namespace {

bool isBlank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}
bool isSpace(char c) {
  return isBlank(c) || c == '\n';
}
bool isDigit(char c) {
  return c >= '0' && c <= '9';
}

/// Whether a number that from_chars calls out of range is too small rather than too large.
bool isTooSmall(std::string_view number) {
  const std::size_t exponent = number.find_first_of("eE");
  if (exponent != std::string_view::npos) {
    return number[exponent + 1] == '-';
  }
  return number.find_first_not_of("0.") > number.find('.');
}

}  // namespace

bool TextCursor::atLineEnd() const {
  std::size_t i = position_;
  while (i < text_.size() && isBlank(text_[i])) {
    ++i;
  }
  return i >= text_.size() || text_[i] == '\n';
}

void TextCursor::skipBlanks() {
  while (!atEnd() && isBlank(text_[position_])) {
    ++position_;
  }
}

void TextCursor::skipSpace() {
  while (!atEnd() && isSpace(text_[position_])) {
    ++position_;
  }
}

void TextCursor::skip(std::string_view characters) {
  while (!atEnd() && characters.find(text_[position_]) != std::string_view::npos) {
    ++position_;
  }
}

std::optional<double> TextCursor::number() {
  std::size_t begin = position_;
  bool isNegative = false;
  if (begin < text_.size() && (text_[begin] == '+' || text_[begin] == '-')) {
    isNegative = text_[begin] == '-';
    ++begin;
  }
  // from_chars would also take inf, nan and a second sign
  const bool isNumber =
      begin < text_.size() &&
      (isDigit(text_[begin]) || (text_[begin] == '.' && begin + 1 < text_.size() && isDigit(text_[begin + 1])));
  if (!isNumber) {
    return std::nullopt;
  }
  double value = 0.0;
  const char* const first = text_.data() + begin;
  const auto [end, error] = std::from_chars(first, text_.data() + text_.size(), value);
  if (error == std::errc::result_out_of_range) {
    if (!isTooSmall({first, static_cast<std::size_t>(end - first)})) {
      return std::nullopt;
    }
    value = 0.0;
  }
  position_ = static_cast<std::size_t>(end - text_.data());
  return isNegative ? -value : value;
}

std::optional<int> TextCursor::integer() {
  std::size_t i = position_;
  const bool isNegative = i < text_.size() && text_[i] == '-';
  if (i < text_.size() && (text_[i] == '+' || text_[i] == '-')) {
    ++i;
  }
  if (i >= text_.size() || !isDigit(text_[i])) {
    return std::nullopt;
  }
  std::int64_t value = 0;
  for (; i < text_.size() && isDigit(text_[i]); ++i) {
    value = std::min<std::int64_t>(value * 10 + (text_[i] - '0'), kLargestInteger);
  }
  position_ = i;
  return static_cast<int>(isNegative ? -value : value);
}

std::string_view TextCursor::word() {
  const std::size_t begin = position_;
  while (!atEnd() && !isSpace(text_[position_])) {
    ++position_;
  }
  return text_.substr(std::min(begin, text_.size()), position_ - begin);
}

bool TextCursor::take(char character) {
  if (peek() != character || atEnd()) {
    return false;
  }
  ++position_;
  return true;
}

bool TextCursor::takeKeywords(std::string_view keywords) {
  const std::size_t begin = position_;
  for (const char c : keywords) {
    if (c == ' ') {
      skipSpace();
    } else if (!take(c)) {
      position_ = begin;
      return false;
    }
  }
  return true;
}

TextCursor TextCursor::takeLine() {
  const std::size_t begin = std::min(position_, text_.size());
  std::size_t end = text_.find('\n', begin);
  if (end == std::string_view::npos) {
    end = text_.size();
    position_ = end;
  } else {
    position_ = end + 1;
  }
  if (end > begin && text_[end - 1] == '\r') {
    --end;
  }
  return TextCursor(text_.substr(0, end), begin);
}

core::SourceRange TextCursor::rangeFrom(std::size_t begin) const {
  return {static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(std::max(position_, begin + 1))};
}

std::string TextCursor::found() const {
  TextCursor next(text_, position_);
  next.skipBlanks();
  if (next.atEnd()) {
    return "the end";
  }
  if (next.peek() == '\n') {
    return "the end of the line";
  }
  constexpr std::size_t kLongest = 40;
  const std::string_view word = next.word();
  std::string text = "'";
  text += word.substr(0, kLongest);
  text += word.size() > kLongest ? "...'" : "'";
  return text;
}

void TextReport::warn(core::SourceRange range, std::string message, std::string hint) const {
  add(core::Severity::Warning, range, std::move(message), std::move(hint));
}

void TextReport::note(core::SourceRange range, std::string message) const {
  add(core::Severity::Note, range, std::move(message), {});
}

void TextReport::add(core::Severity severity, core::SourceRange range, std::string message, std::string hint) const {
  // the search for a line takes the length of the file: not for a message that is only counted
  core::SourceLocation location = isFull() ? core::SourceLocation{} : map_->locate(range);
  diagnostics_->add({severity, std::move(message), std::move(location), std::move(hint)});
}

SourceMap plainSourceMap(std::string file, std::string text) {
  SourceMap map;
  map.files.push_back({std::move(file), std::move(text)});
  map.segments.push_back({});
  return map;
}

}  // namespace espalier::files
