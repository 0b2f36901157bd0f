#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "engine/core/diagnostic.h"
#include "engine/files/source_map.h"

namespace espalier::files {

/// A position in a text, with functions that read words, numbers and lines from there. Offsets count from the beginning
/// of the whole text, also in the cursor of a single line. The text must outlive the cursor.
class TextCursor {
 public:
  explicit TextCursor(std::string_view text, std::size_t position = 0) : text_(text), position_(position) {}

  [[nodiscard]] std::size_t position() const { return position_; }
  void setPosition(std::size_t position) { position_ = position; }
  [[nodiscard]] bool atEnd() const { return position_ >= text_.size(); }
  /// The next character; 0 at the end.
  [[nodiscard]] char peek() const { return atEnd() ? '\0' : text_[position_]; }
  /// Whether only blanks stand before the next newline or the end of the text. Does not move.
  [[nodiscard]] bool atLineEnd() const;
  [[nodiscard]] std::string_view rest() const {
    return text_.substr(position_ < text_.size() ? position_ : text_.size());
  }

  [[nodiscard]] std::string_view textBetween(std::size_t begin, std::size_t end) const {
    return text_.substr(begin, end > begin ? end - begin : 0);
  }

  /// Passes blanks, TABs and carriage returns.
  void skipBlanks();
  /// Passes blanks and newlines.
  void skipSpace();
  /// Passes any of the given characters.
  void skip(std::string_view characters);

  /// A decimal number as strtod reads it, without hexadecimal, inf and nan, independent of the locale. It must start at
  /// the position; nothing (and no move) otherwise, also when it is too large for a double.
  [[nodiscard]] std::optional<double> number();
  /// A decimal integer with an optional sign, at the position. Values beyond ±kLargestInteger become ±kLargestInteger.
  [[nodiscard]] std::optional<int> integer();
  static constexpr int kLargestInteger = 1'000'000'000;
  /// The characters up to the next blank or newline; empty at one.
  [[nodiscard]] std::string_view word();
  /// Passes `character` when it is next.
  bool take(char character);
  /// Passes `keywords` when they are next. A blank in `keywords` matches any number of blanks and newlines.
  bool takeKeywords(std::string_view keywords);
  /// The rest of the line, without its newline and a carriage return before it, as a cursor of its own; moves to the
  /// next line.
  [[nodiscard]] TextCursor takeLine();

  /// From an earlier position to this one, at least one byte.
  [[nodiscard]] core::SourceRange rangeFrom(std::size_t begin) const;
  /// The word at the position, for a message: quoted, or "the end of the line", or "the end" of the text.
  [[nodiscard]] std::string found() const;

 private:
  std::string_view text_;
  std::size_t position_;
};

/// Writes warnings and notes about a text into a list.
class TextReport {
 public:
  /// Both must outlive the object.
  TextReport(const SourceMap& map, core::DiagnosticList& diagnostics) : map_(&map), diagnostics_(&diagnostics) {}
  void warn(core::SourceRange range, std::string message, std::string hint = {}) const;
  void note(core::SourceRange range, std::string message) const;
  [[nodiscard]] core::SourceLocation locate(core::SourceRange range) const { return map_->locate(range); }
  /// Whether further warnings are only counted: their text need not be made.
  [[nodiscard]] bool isFull() const { return diagnostics_->warningCount() >= core::DiagnosticList::kLimit; }

 private:
  void add(core::Severity severity, core::SourceRange range, std::string message, std::string hint) const;

  const SourceMap* map_;
  core::DiagnosticList* diagnostics_;
};

/// The source map of a file that is not preprocessed.
[[nodiscard]] SourceMap plainSourceMap(std::string file, std::string text);

}  // namespace espalier::files
