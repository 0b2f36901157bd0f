#include "engine/language/message_list.h"

#include <string_view>

#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

/// `#define r = 2`: the place of the '=' with which the text of a macro begins, when the range is the beginning of its
/// expansion. The name stays empty for another range.
struct EqualsMacro {
  std::string name;
  core::SourceLocation place;
};

EqualsMacro equalsMacroAt(core::SourceRange range, const files::SourceMap& map) {
  const auto segment = std::ranges::lower_bound(map.segments, range.begin, {}, &files::SourceMap::Segment::outputBegin);
  if (segment == map.segments.end() || segment->outputBegin != range.begin ||
      segment->expansion == files::SourceMap::kNoExpansion) {
    return {};
  }
  const files::SourceMap::Expansion& expansion = map.expansions[segment->expansion];
  if (expansion.file == files::SourceMap::kNoExpansion) {
    return {};
  }
  const files::SourceMap::File& file = map.files[expansion.file];
  std::size_t at = expansion.definitionOffset + expansion.macro.size();
  while (at < file.text.size() && isBlank(file.text[at])) {
    ++at;
  }
  if (at >= file.text.size() || file.text[at] != '=') {
    return {};
  }
  return {expansion.macro, files::locateInFile(file, static_cast<std::uint32_t>(at), 1)};
}

}  // namespace

void MessageList::moveTo(core::DiagnosticList& list, const files::SourceMap& map) {
  std::stable_sort(messages_.begin(), messages_.end(),
                   [](const Message& a, const Message& b) { return a.range.begin < b.range.begin; });
  // the parser cannot understand a line that could not be preprocessed
  const std::vector<core::Diagnostic> earlier = list.entries();
  const auto isExplained = [&](const core::SourceLocation& place) {
    return std::any_of(earlier.begin(), earlier.end(), [&](const core::Diagnostic& diagnostic) {
      return diagnostic.severity == core::Severity::Error && place.line > 0 && diagnostic.location.line == place.line &&
             diagnostic.location.file == place.file;
    });
  };
  std::vector<std::string> reportedMacros;
  std::size_t errors = 0;
  std::size_t warnings = 0;
  for (Message& message : messages_) {
    // finding a place takes a walk through its file, and the list keeps only its limit of each severity
    const std::size_t rank = message.severity == core::Severity::Error ? errors++ : warnings++;
    const bool isPlaced = rank < core::DiagnosticList::kLimit;
    core::SourceLocation place = isPlaced ? map.locate(message.range) : core::SourceLocation{};
    if (isPlaced && message.text.ends_with(", found '='")) {
      EqualsMacro macro = equalsMacroAt(message.range, map);
      if (std::ranges::find(reportedMacros, macro.name) != reportedMacros.end()) {
        continue;
      }
      if (!macro.name.empty()) {
        message.text = "the text of the macro '" + macro.name + "' begins with '='";
        message.hint = "write '#define " + macro.name + "' and its value, without '='";
        place = std::move(macro.place);
        reportedMacros.push_back(std::move(macro.name));
      }
    }
    if (!isExplained(place)) {
      list.add({message.severity, std::move(message.text), std::move(place), std::move(message.hint)});
    }
  }
  messages_.clear();
}

}  // namespace espalier::language
