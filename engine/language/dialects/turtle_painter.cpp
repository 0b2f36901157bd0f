#include "engine/language/dialects/turtle_painter.h"

#include "engine/language/dialects/painter_objects.h"
#include "engine/language/dialects/text_lines.h"
#include "engine/language/dialects/textbook.h"

namespace espalier::language {

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
                            (colon != std::string::npos && small.find("%", colon) != std::string::npos);
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
