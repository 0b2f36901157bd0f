#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/core/identifiers.h"
#include "engine/core/vec3.h"
#include "engine/files/text_cursor.h"

namespace espalier::language {

/// Reads labels and their arguments from the preprocessed text of a view file (docs/model-files.md,
/// 4.1).
///
/// Numbers are looked for across newlines in every mode. When an argument is missing, the compatible modes skip the
/// next line; the Espalier mode reads it as a command.
class ViewLexer {
 public:
  /// The text must outlive the object.
  ViewLexer(std::string_view text, core::Compatibility compatibility)
      : cursor_(text), isCompatible_(compatibility != core::Compatibility::Espalier) {}

  struct Label {
    std::string_view text;  // up to and including the colon, or the whole line when it has none
    core::SourceRange range;
  };
  /// The next label; nothing at the end of the file. A TAB before it belongs to it.
  [[nodiscard]] std::optional<Label> nextLabel();

  // arguments: each returns nothing when it is missing; expected() then names it
  [[nodiscard]] std::optional<double> number();
  [[nodiscard]] std::optional<int> integer();
  [[nodiscard]] std::optional<std::string_view> word();
  /// Three numbers, a comma directly after the first and the second.
  [[nodiscard]] std::optional<core::Vec3> triple();

  /// A number if one follows; its absence is not a mistake.
  [[nodiscard]] std::optional<double> optionalNumber();
  [[nodiscard]] std::optional<int> optionalInteger();
  /// The next word of the same line after blanks, but not after a TAB; empty: none.
  [[nodiscard]] std::string_view optionalUnit();
  /// The rest of the line; the position is then on the next one.
  [[nodiscard]] files::TextCursor line() { return cursor_.takeLine(); }
  /// Skips the rest of the line.
  void skipLine() { (void)cursor_.takeLine(); }

  [[nodiscard]] const std::string& expected() const { return expected_; }
  [[nodiscard]] const files::TextCursor& cursor() const { return cursor_; }
  /// After a missing argument of a label: passes the text that is not read again.
  void recover();
  /// From the last label's beginning to the position, on the label's line.
  [[nodiscard]] core::SourceRange commandRange() const;

 private:
  void beginArgument(std::string_view expected);

  files::TextCursor cursor_;
  bool isCompatible_;
  std::size_t labelBegin_ = 0;
  std::size_t labelEnd_ = 0;
  std::string expected_;
};

}  // namespace espalier::language
