#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {

/// One logical line of a file: physical lines joined at `\`, comments replaced by a blank. A comment over several lines
/// ends no directive.
struct LogicalLine {
  std::string text;
  std::vector<std::uint32_t> offsets;  // of each byte of `text` in the file
  std::uint32_t end = 0;               // offset of the newline, or of the end of the file
  bool startsInComment = false;

  void add(char c, std::size_t offset) {
    text.push_back(c);
    offsets.push_back(static_cast<std::uint32_t>(offset));
  }
  [[nodiscard]] std::uint32_t offsetOf(std::size_t i) const { return i < offsets.size() ? offsets[i] : end; }
};

/// Cuts the text of a file into logical lines; the text must outlive the reader.
class LineReader {
 public:
  explicit LineReader(std::string_view text) : text_(text) {}

  /// The next line; false at the end of the file.
  bool next(LogicalLine& line) {
    line = {};
    if (position_ >= text_.size()) {
      return false;
    }
    line.startsInComment = isInComment_;
    bool isInLineComment = false;
    while (position_ < text_.size()) {
      if (const std::size_t length = newlineLength(position_); length > 0) {
        // a directive goes on behind a comment over several lines
        if (isInComment_ && !line.startsInComment && line.text.starts_with('#')) {
          position_ += length;
          continue;
        }
        line.end = static_cast<std::uint32_t>(position_);
        position_ += length;
        return true;
      }
      const char c = text_[position_];
      const std::size_t spliceLength = c == '\\' ? newlineLength(position_ + 1) : 0;
      if (spliceLength > 0) {
        position_ += 1 + spliceLength;
      } else if (isInComment_) {
        isInComment_ = !(c == '*' && peek(1) == '/');
        position_ += isInComment_ ? 1 : 2;
      } else if (isInLineComment) {
        ++position_;
      } else if (c == '/' && (peek(1) == '*' || peek(1) == '/')) {
        // a comment is one blank; its newlines stay
        isInComment_ = peek(1) == '*';
        isInLineComment = !isInComment_;
        commentBegin_ = position_;
        line.add(' ', position_);
        position_ += 2;
      } else if (c == '"') {
        copyString(line);
      } else {
        line.add(c, position_++);
      }
    }
    line.end = static_cast<std::uint32_t>(position_);
    return true;
  }

  /// Whether the file ended, or the last line did, inside a comment; it began at commentBegin.
  [[nodiscard]] bool isInComment() const { return isInComment_; }
  [[nodiscard]] std::size_t commentBegin() const { return commentBegin_; }

 private:
  [[nodiscard]] char peek(std::size_t ahead) const {
    return position_ + ahead < text_.size() ? text_[position_ + ahead] : '\0';
  }
  [[nodiscard]] std::size_t newlineLength(std::size_t position) const {
    if (position < text_.size() && text_[position] == '\n') {
      return 1;
    }
    return position + 1 < text_.size() && text_[position] == '\r' && text_[position + 1] == '\n' ? 2 : 0;
  }
  void copyString(LogicalLine& line) {
    if (position_ >= quotedLineEnd_) {
      quotedLineEnd_ = std::min(text_.find('\n', position_), text_.size());
      literals_ = StringLiterals(text_.substr(0, quotedLineEnd_));
    }
    const std::size_t end = std::max(literals_.endOf(position_), position_ + 1);
    while (position_ < end) {
      line.add(text_[position_], position_);
      ++position_;
    }
  }

  std::string_view text_;
  std::size_t position_ = 0;
  std::size_t quotedLineEnd_ = 0;                // of the last line that had a quote
  StringLiterals literals_{std::string_view{}};  // of that line
  bool isInComment_ = false;
  std::size_t commentBegin_ = 0;
};

}  // namespace espalier::language
