#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

namespace espalier::server {

/// The unit in which an editor counts the characters of a line.
enum class ColumnUnit : std::uint8_t { Utf16, Bytes };

/// A place in a text as editors give it: both numbers from 0.
struct EditorPosition {
  std::uint32_t line = 0;
  std::uint32_t column = 0;
};

/// The byte offset of a place. A column behind the end of its line is the end; a line behind the last is the end of the
/// text. O(offset).
[[nodiscard]] std::size_t offsetAt(std::string_view text, EditorPosition position, ColumnUnit unit);

/// The column of a byte in its line. O(byte).
[[nodiscard]] std::uint32_t columnAt(std::string_view line, std::size_t byte, ColumnUnit unit);

/// Finds the places of byte offsets in a text, which must outlive the object.
class LineIndex {
 public:
  explicit LineIndex(std::string_view text);
  /// O(log lines), also in a line of megabytes.
  [[nodiscard]] EditorPosition positionAt(std::size_t offset, ColumnUnit unit) const;

 private:
  static constexpr std::size_t kPieceBytes = 256;

  /// The units of UTF-16 before a byte of the text.
  [[nodiscard]] std::size_t unitsBefore(std::size_t offset) const;

  std::string_view text_;
  std::vector<std::size_t> begins_{0};      // of the lines
  std::vector<std::size_t> pieceUnits_{0};  // of UTF-16 before each piece of the text
};

}  // namespace espalier::server
