#include "engine/core/message_text.h"

#include <algorithm>

namespace espalier::core {
namespace {

constexpr std::size_t kLineColumns = 200;  // of a line of a message

/// Bytes of the UTF-8 character that begins at `at`; 0: none does.
std::size_t characterBytes(std::string_view text, std::size_t at) {
  const auto first = static_cast<unsigned char>(text[at]);
  const std::size_t length = first < 0x80                     ? 1
                             : first >= 0xC2 && first <= 0xDF ? 2
                             : first >= 0xE0 && first <= 0xEF ? 3
                             : first >= 0xF0 && first <= 0xF4 ? 4
                                                              : 0;
  if (length == 0 || at + length > text.size()) {
    return 0;
  }
  for (std::size_t i = 1; i < length; ++i) {
    if ((static_cast<unsigned char>(text[at + i]) & 0xC0U) != 0x80U) {
      return 0;
    }
  }
  return length;
}

}  // namespace

void makePrintable(std::string& text, bool keepsLines) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = characterBytes(text, at);
    if (length == 0) {
      text[at] = '?';
    } else if (length == 1 && text[at] != '\t' && !(keepsLines && text[at] == '\n') &&
               (static_cast<unsigned char>(text[at]) < 0x20 || text[at] == 0x7F)) {
      text[at] = ' ';
    } else if (length == 2 && text[at] == '\xC2' && static_cast<unsigned char>(text[at + 1]) < 0xA0) {
      // the second set of control characters
      text[at] = text[at + 1] = ' ';
    }
    at += std::max<std::size_t>(length, 1);
  }
}

std::size_t characterCount(std::string_view text) {
  std::size_t count = 0;
  for (std::size_t at = 0; at < text.size(); at += std::max<std::size_t>(characterBytes(text, at), 1)) {
    ++count;
  }
  return count;
}

std::string placeText(const SourceLocation& place) {
  const std::size_t before = place.column > 0 ? place.column - 1 : 0;
  const std::string_view line = std::string_view(place.lineText).substr(0, before);
  // bytes of a line that is not kept count as characters
  const std::size_t column = place.column > 0 ? before - line.size() + characterCount(line) + 1 : 0;
  return place.file + ':' + std::to_string(place.line) + ':' + std::to_string(column);
}

std::string messageText(std::string text, std::size_t used) {
  makePrintable(text, true);
  constexpr std::string_view kIndent = "\n         ";
  std::size_t column = used;
  std::size_t blank = std::string::npos;  // the last one of the line
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '\n') {
      column = 0;
      blank = std::string::npos;
      continue;
    }
    column += (static_cast<unsigned char>(text[at]) & 0xC0U) != 0x80U ? 1 : 0;
    blank = text[at] == ' ' ? at : blank;
    if (column > kLineColumns && blank != std::string::npos) {
      text.replace(blank, 1, kIndent);
      at = blank + kIndent.size() - 1;
      column = kIndent.size() - 1;
      blank = std::string::npos;
    }
  }
  return text;
}

}  // namespace espalier::core
