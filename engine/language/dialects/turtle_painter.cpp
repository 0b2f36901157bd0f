#include "engine/language/dialects/turtle_painter.h"

#include <cctype>

#include "engine/language/dialects/painter_objects.h"
#include "engine/language/dialects/text_lines.h"
#include "engine/language/dialects/textbook/textbook.h"

namespace espalier::language {

namespace {

// `%` as a value, a random number; behind a number it is per cent
bool hasRandomPercent(std::string_view text) {
  for (std::size_t at = text.find('%'); at != std::string_view::npos; at = text.find('%', at + 1)) {
    const std::size_t before = at == 0 ? std::string_view::npos : text.find_last_not_of(' ', at - 1);
    if (before == std::string_view::npos || std::isdigit(static_cast<unsigned char>(text[before])) == 0) {
      return true;
    }
  }
  return false;
}

}  // namespace

bool recognisesTurtlePainter(std::string_view text) {
  if (!recognisesTextbook(text)) {
    return false;
  }
  bool isFirst = true;
  for (const TextPiece& line : linesOf(text)) {
    const std::string small = lowered(line.trimmed().text);
    const std::size_t colon = small.find(':');
    const bool isPainters = isPainterStatement(small) || small.starts_with("iteracja") ||
                            (isFirst && small.find("turtle painter") != std::string::npos) ||
                            (colon != std::string::npos && hasRandomPercent(std::string_view(small).substr(colon)));
    if (isPainters) {
      return true;
    }
    isFirst = isFirst && small.empty();
  }
  return false;
}

CpfgModel translateTurtlePainter(std::string_view text, const std::string& entry, DialectReport& report) {
  return translateTextbookWith(text, entry, TextbookExtension{true}, report);
}

}  // namespace espalier::language
