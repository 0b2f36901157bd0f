#include "engine/language/dialects/dialect.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <utility>

#include "engine/files/utf8.h"
#include "engine/language/dialects/fractint.h"
#include "engine/language/dialects/lparser.h"
#include "engine/language/dialects/lpy.h"
#include "engine/language/dialects/lsystem_viewer.h"
#include "engine/language/dialects/other_programs.h"
#include "engine/language/dialects/species.h"
#include "engine/language/dialects/textbook/textbook.h"
#include "engine/language/dialects/turtle_painter.h"

namespace espalier::language {
namespace {

constexpr std::array kDialects = {
    Dialect{"fractint", "Fractint", recognisesFractint, fractintEntries, translateFractint},
    Dialect{"lpy", "L-Py", recognisesLpy, nullptr, translateLpy},
    Dialect{"lparser", "Lparser", recognisesLparser, nullptr, translateLparser},
    Dialect{"lsv", "L-System Viewer", recognisesLsystemViewer, nullptr, translateLsystemViewer},
    Dialect{"species", "species of a forest", recognisesSpecies, speciesEntries, translateSpecies},
    Dialect{"turtle-painter", "Turtle Painter", recognisesTurtlePainter, nullptr, translateTurtlePainter},
    Dialect{"textbook", "textbook notation", recognisesTextbook, textbookEntries, translateTextbook},
};

char lower(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

bool isSame(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

// the text of a file with plain blanks in place of those of print, each as long as it was
std::string foreignText(std::string_view bytes) {
  std::string text = files::asUtf8(bytes);
  for (const std::string_view blank :
       {"\u00A0", "\u2002", "\u2003", "\u2007", "\u2009", "\u200A", "\u200B", "\u202F", "\u3000", "\uFEFF"}) {
    for (std::size_t at = text.find(blank); at != std::string::npos; at = text.find(blank, at)) {
      text.replace(at, blank.size(), blank.size(), ' ');
    }
  }
  return text;
}

enum class CpfgLine : std::uint8_t { Lsystem, Directive, Endlsystem };

// whether a line begins with the keyword, or with #include, #if, #ifdef or #ifndef and what belongs behind it
bool hasCpfgLine(std::string_view text, CpfgLine kind) {
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = text.substr(begin, end - begin);
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    const bool isDirective = line.starts_with("#include \"") || line.starts_with("#include\"") ||
                             line.starts_with("#include <") || line.starts_with("#include<") ||
                             line.starts_with("#if ") || line.starts_with("#ifdef ") || line.starts_with("#ifndef ");
    if (kind == CpfgLine::Lsystem      ? isSame(line.substr(0, 8), "lsystem:")
        : kind == CpfgLine::Endlsystem ? isSame(line.substr(0, 10), "endlsystem")
                                       : isDirective) {
      return true;
    }
    begin = end + 1;
  }
  return false;
}

// whether the keywords of a text are those of a cpfg model
bool looksLikeCpfg(std::string_view text) {
  if (hasLsystem(text)) {
    return true;
  }
  // a line of the preprocessor can bring the keyword from another file; in other notations it is a remark
  if (!hasCpfgLine(text, CpfgLine::Directive)) {
    return false;
  }
  return (hasCpfgLine(text, CpfgLine::Endlsystem) && !recognisesLpy(text)) ||
         std::ranges::none_of(kDialects, [&](const Dialect& dialect) { return dialect.recognises(text); });
}

// the asked dialect, or the first that recognises a text; null: cpfg, or none of that name
const Dialect* dialectOf(std::string_view asked, std::string_view text) {
  if (asked == kCpfgDialect || (asked.empty() && looksLikeCpfg(text))) {
    return nullptr;
  }
  const auto found = std::find_if(kDialects.begin(), kDialects.end(), [&](const Dialect& dialect) {
    return asked.empty() ? dialect.recognises(text) : dialect.name == asked;
  });
  return found == kDialects.end() ? nullptr : &*found;
}

// the wanted entry, or the first with a note; the name as the file writes it
std::optional<std::string> chosenEntry(const TranslatedModel& translated, const std::string& wanted,
                                       DialectReport& report) {
  const auto& list = translated.dialect->entries;
  const std::vector<DialectEntry> entries =
      list == nullptr ? std::vector<DialectEntry>{} : list(translated.foreign.text);
  std::vector<std::string_view> names;
  for (const DialectEntry& entry : entries) {
    if (isSame(entry.name, wanted)) {
      return entry.name;
    }
    names.push_back(entry.name);
  }
  if (!wanted.empty()) {
    report.error(
        0, 1, "the file has no entry '" + wanted + "'",
        names.empty() ? "the file holds one model: remove the ':' and the name" : core::suggestName(wanted, names));
    return std::nullopt;
  }
  if (entries.size() > 1) {
    constexpr std::size_t kMostNames = 40;
    std::string all;
    for (std::size_t i = 0; i < std::min(names.size(), kMostNames); ++i) {
      all += (all.empty() ? "" : ", ") + std::string(names[i]);
    }
    all += names.size() > kMostNames ? " and " + std::to_string(names.size() - kMostNames) + " more" : "";
    report.note(entries.front().offset, 1,
                "the file holds " + std::to_string(entries.size()) + " models; the first is used: " + all,
                translated.foreign.name + ":NAME chooses another");
  }
  return entries.empty() ? std::string{} : entries.front().name;
}

}  // namespace

std::span<const Dialect> dialects() {
  return kDialects;
}

std::vector<std::string_view> dialectNames() {
  std::vector<std::string_view> names{kCpfgDialect};
  for (const Dialect& dialect : kDialects) {
    names.push_back(dialect.name);
  }
  return names;
}

bool hasLsystem(std::string_view text) {
  return hasCpfgLine(text, CpfgLine::Lsystem);
}

NamedEntry splitEntry(const std::string& name, core::FileProvider& files) {
  if (name.find(':') == std::string::npos || files.read(name)) {
    return {name, {}};
  }
  // the name of an entry may hold colons and slashes
  std::size_t last = std::string::npos;
  for (std::size_t colon = name.find(':', 1); colon != std::string::npos; colon = name.find(':', colon + 1)) {
    if (files.read(name.substr(0, colon))) {
      return {name.substr(0, colon), name.substr(colon + 1)};
    }
    last = colon;
  }
  const bool isFile = last == std::string::npos || name.find('/', last) != std::string::npos;
  return isFile ? NamedEntry{name, {}} : NamedEntry{name.substr(0, last), name.substr(last + 1)};
}

std::vector<std::string> entriesOf(const CompileInput& input, core::FileProvider& files) {
  const std::optional<std::string> text = files.read(input.modelFile);
  if (!text || text->size() > input.limits.maximumSourceBytes || !fileWithoutText(*text).message.empty()) {
    return {};
  }
  const std::string foreign = foreignText(*text);
  const Dialect* const dialect = dialectOf(input.dialect, foreign);
  std::vector<std::string> names;
  if (dialect != nullptr && dialect->entries != nullptr) {
    for (DialectEntry& entry : dialect->entries(foreign)) {
      names.push_back(std::move(entry.name));
    }
  }
  return names.size() > 1 ? names : std::vector<std::string>{};
}

std::optional<TranslatedModel> translateForeign(const CompileInput& input, core::FileProvider& files) {
  const NamedEntry named = splitEntry(input.modelFile, files);
  std::optional<std::string> text = files.read(named.file);
  if (!text || text->size() > input.limits.maximumSourceBytes) {
    return std::nullopt;
  }
  TranslatedModel translated;
  const ForeignFile noText = fileWithoutText(*text);
  translated.foreign = {named.file, noText.message.empty() ? foreignText(*text) : std::string{}};
  const std::string& foreign = translated.foreign.text;
  const bool isAsked = !input.dialect.empty();
  const bool isOther = noText.message.empty() && !isAsked && !hasLsystem(foreign);
  const ForeignFile other = isOther ? modelOfOtherProgram(foreign) : noText;
  if (!other.message.empty()) {
    DialectReport(translated.foreign, translated.diagnostics)
        .error(other.offset, std::max<std::size_t>(other.length, 1), other.message, other.hint);
    return translated;
  }
  if (input.dialect == kCpfgDialect) {
    return std::nullopt;
  }
  const Dialect* const found = dialectOf(input.dialect, foreign);
  DialectReport report(translated.foreign, translated.diagnostics);
  if (found == nullptr) {
    if (isAsked) {
      report.error(0, 1, "there is no dialect '" + input.dialect + "'",
                   core::suggestName(input.dialect, dialectNames()));
      return translated;
    }
    return std::nullopt;
  }
  translated.dialect = found;
  const std::optional<std::string> entry = chosenEntry(translated, named.entry, report);
  if (entry) {
    translated.entry = *entry;
    translated.model = found->translate(foreign, *entry, report);
  }
  return translated;
}

files::SourceMap foreignSourceMap(const files::SourceMap& map, const MappedText& translation,
                                  const files::SourceMap::File& foreign) {
  files::SourceMap result;
  result.files = map.files;
  result.expansions = map.expansions;
  if (!result.files.empty()) {
    result.files.front() = foreign;
  }
  const std::vector<MappedText::Run>& runs = translation.runs();
  const auto runOf = [&](std::uint32_t offset) {
    const auto next = std::upper_bound(runs.begin(), runs.end(), offset,
                                       [](std::uint32_t at, const MappedText::Run& run) { return at < run.begin; });
    return next == runs.begin() ? runs.end() : next - 1;
  };
  for (std::size_t i = 0; i < map.segments.size(); ++i) {
    const files::SourceMap::Segment& segment = map.segments[i];
    const std::uint32_t end = i + 1 < map.segments.size() ? map.segments[i + 1].outputBegin : segment.outputBegin;
    if (segment.file != 0 || segment.expansion != files::SourceMap::kNoExpansion) {
      result.segments.push_back(segment);
      continue;
    }
    // in a copied run each byte has its own place; all bytes of a made run have one place
    const auto last = static_cast<std::uint32_t>(translation.text().size());
    const std::uint32_t length = i + 1 < map.segments.size() ? end - segment.outputBegin : last - segment.fileOffset;
    for (std::uint32_t done = 0; done < length;) {
      const auto run = runOf(segment.fileOffset + done);
      if (run == runs.end()) {
        break;
      }
      const std::uint32_t inRun = segment.fileOffset + done - run->begin;
      const std::uint32_t runEnd = run + 1 == runs.end() ? last : (run + 1)->begin;
      const std::uint32_t rest = runEnd - (segment.fileOffset + done);
      files::SourceMap::Segment part = segment;
      part.outputBegin = segment.outputBegin + done;
      part.fileOffset = run->foreignOffset + (run->isCopied ? inRun : 0);
      result.segments.push_back(part);
      done += run->isCopied ? rest : 1;
    }
  }
  return result;
}

}  // namespace espalier::language
