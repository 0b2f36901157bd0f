#include "server/language_server/text_positions.h"

#include <algorithm>

namespace espalier::server {
namespace {

// how many units of UTF-16 the character takes that this byte begins; 0 inside a character
std::uint32_t unitsOf(char byte) {
  const auto value = static_cast<unsigned char>(byte);
  return (value & 0xC0U) == 0x80U ? 0 : (value >= 0xF0U ? 2 : 1);
}

std::uint32_t unitsIn(std::string_view text) {
  std::uint32_t units = 0;
  for (const char c : text) {
    units += unitsOf(c);
  }
  return units;
}

}  // namespace

std::uint32_t columnAt(std::string_view line, std::size_t byte, ColumnUnit unit) {
  const std::string_view before = line.substr(0, std::min(byte, line.size()));
  return unit == ColumnUnit::Bytes ? static_cast<std::uint32_t>(before.size()) : unitsIn(before);
}

std::size_t offsetAt(std::string_view text, EditorPosition position, ColumnUnit unit) {
  std::size_t begin = 0;
  for (std::uint32_t line = 0; line < position.line; ++line) {
    const std::size_t newline = text.find('\n', begin);
    if (newline == std::string_view::npos) {
      return text.size();
    }
    begin = newline + 1;
  }
  std::size_t end = std::min(text.find('\n', begin), text.size());
  if (end > begin && text[end - 1] == '\r') {
    --end;
  }
  std::size_t offset = begin;
  std::uint32_t units = 0;
  while (offset < end && units < position.column) {
    units += unit == ColumnUnit::Bytes ? 1 : unitsOf(text[offset]);
    ++offset;
    // the rest of a character of several bytes
    while (unit == ColumnUnit::Utf16 && offset < end && unitsOf(text[offset]) == 0) {
      ++offset;
    }
  }
  return offset;
}

LineIndex::LineIndex(std::string_view text) : text_(text) {
  for (std::size_t newline = text.find('\n'); newline != std::string_view::npos;
       newline = text.find('\n', newline + 1)) {
    begins_.push_back(newline + 1);
  }
  for (std::size_t begin = 0; begin + kPieceBytes <= text.size(); begin += kPieceBytes) {
    pieceUnits_.push_back(pieceUnits_.back() + unitsIn(text.substr(begin, kPieceBytes)));
  }
}

std::size_t LineIndex::unitsBefore(std::size_t offset) const {
  const std::size_t piece = offset / kPieceBytes;
  return pieceUnits_[piece] + unitsIn(text_.substr(piece * kPieceBytes, offset % kPieceBytes));
}

EditorPosition LineIndex::positionAt(std::size_t offset, ColumnUnit unit) const {
  offset = std::min(offset, text_.size());
  const auto line = std::upper_bound(begins_.begin(), begins_.end(), offset) - begins_.begin() - 1;
  const std::size_t begin = begins_[static_cast<std::size_t>(line)];
  const std::size_t column = unit == ColumnUnit::Bytes ? offset - begin : unitsBefore(offset) - unitsBefore(begin);
  return {static_cast<std::uint32_t>(line), static_cast<std::uint32_t>(column)};
}

}  // namespace espalier::server
