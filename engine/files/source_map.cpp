#include "engine/files/source_map.h"

#include <algorithm>
#include <utility>

#include "engine/core/message_text.h"

namespace espalier::files {

SourceMap::File::File(std::string fileName, std::string fileText)
    : name(std::move(fileName)), text(std::move(fileText)), lineBegins{0} {
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', end + 1)) {
    lineBegins.push_back(static_cast<std::uint32_t>(end + 1));
  }
}

core::SourceLocation locateInFile(const SourceMap::File& file, std::uint32_t offset, std::uint32_t length) {
  const std::string& text = file.text;
  const std::size_t position = std::min<std::size_t>(offset, text.size());
  const auto after = std::upper_bound(file.lineBegins.begin(), file.lineBegins.end(), position);
  const std::size_t lineBegin = after == file.lineBegins.begin() ? 0 : *(after - 1);
  std::size_t lineEnd = std::min(text.find('\n', position), text.size());
  if (lineEnd > lineBegin && text[lineEnd - 1] == '\r') {
    --lineEnd;
  }
  const std::size_t restOfLine = lineEnd > position ? lineEnd - position : 0;
  core::SourceLocation location;
  location.file = file.name;
  location.line = static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(1, after - file.lineBegins.begin()));
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
      location.expansion += " (" + core::placeText(definition) + ")";
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
