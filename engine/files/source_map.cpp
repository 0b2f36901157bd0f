#include "engine/files/source_map.h"

#include <algorithm>

namespace espalier::files {

core::SourceLocation locateInFile(const SourceMap::File& file, std::uint32_t offset, std::uint32_t length) {
  const std::string& text = file.text;
  const std::size_t position = std::min<std::size_t>(offset, text.size());
  const auto lineCount = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(position), '\n');
  const std::size_t lastNewline = position == 0 ? std::string::npos : text.rfind('\n', position - 1);
  const std::size_t lineBegin = lastNewline == std::string::npos ? 0 : lastNewline + 1;
  std::size_t lineEnd = std::min(text.find('\n', position), text.size());
  if (lineEnd > lineBegin && text[lineEnd - 1] == '\r') {
    --lineEnd;
  }
  const std::size_t restOfLine = lineEnd > position ? lineEnd - position : 0;
  core::SourceLocation location;
  location.file = file.name;
  location.line = static_cast<std::uint32_t>(lineCount) + 1;
  location.column = static_cast<std::uint32_t>(position - lineBegin) + 1;
  location.length = static_cast<std::uint32_t>(std::max<std::size_t>(1, std::min<std::size_t>(length, restOfLine)));
  location.lineText = text.substr(lineBegin, lineEnd - lineBegin);
  return location;
}

core::SourceLocation SourceMap::locate(core::SourceRange range) const {
  if (files.empty()) {
    return {};
  }
  if (segments.empty()) {
    return locateInFile(files.front(), 0, 1);
  }
  auto next = std::upper_bound(segments.begin(), segments.end(), range.begin,
                               [](std::uint32_t begin, const Segment& segment) { return begin < segment.outputBegin; });
  const Segment& segment = next == segments.begin() ? *next : *(next - 1);
  // the place of a whole expansion is the use of its macro
  if (segment.expansion != kNoExpansion) {
    const Expansion& expansion = expansions[segment.expansion];
    core::SourceLocation location = locateInFile(files[segment.file], segment.fileOffset, expansion.useLength);
    location.expansion = "in the expansion of " + expansion.macro;
    if (expansion.file == kNoExpansion) {
      location.expansion += " (defined by the caller)";
    } else {
      const core::SourceLocation definition = locateInFile(files[expansion.file], expansion.definitionOffset, 1);
      location.expansion += " (" + definition.file + ":" + std::to_string(definition.line) + ":" +
                            std::to_string(definition.column) + ")";
    }
    return location;
  }
  // a copied run maps byte by byte; the underline ends with the run
  const std::uint32_t skipped = range.begin - std::min(range.begin, segment.outputBegin);
  std::uint32_t end = std::max(range.end, range.begin + 1);
  if (next != segments.end()) {
    end = std::min(end, std::max(next->outputBegin, range.begin + 1));
  }
  return locateInFile(files[segment.file], segment.fileOffset + skipped, end - range.begin);
}

}  // namespace espalier::files
