#include "engine/language/dialects/dialect.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "engine/files/utf8.h"
#include "engine/language/dialects/fractint.h"
#include "engine/language/dialects/lsystem_viewer.h"
#include "engine/language/dialects/species.h"
#include "engine/language/dialects/textbook.h"
#include "engine/language/dialects/turtle_painter.h"

namespace espalier::language {
namespace {

constexpr std::array kDialects = {
    Dialect{"fractint", "Fractint", recognisesFractint, fractintEntries, translateFractint},
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
    std::string all;
    for (const std::string_view name : names) {
      all += (all.empty() ? "" : ", ") + std::string(name);
    }
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

bool looksLikeCpfg(std::string_view text) {
  // the keyword at the beginning of a line; a preprocessor's line can bring it from another file
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = text.substr(begin, end - begin);
    line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
    if (isSame(line.substr(0, 8), "lsystem:") || line.starts_with("#include") || line.starts_with("#if")) {
      return true;
    }
    begin = end + 1;
  }
  return false;
}

NamedEntry splitEntry(const std::string& name, core::FileProvider& files) {
  const std::size_t colon = name.rfind(':');
  const std::size_t slash = name.rfind('/');
  const bool hasEntry = colon != std::string::npos && colon > 0 && (slash == std::string::npos || slash < colon);
  if (!hasEntry || files.read(name)) {
    return {name, {}};
  }
  return {name.substr(0, colon), name.substr(colon + 1)};
}

std::optional<TranslatedModel> translateForeign(const CompileInput& input, core::FileProvider& files) {
  const NamedEntry named = splitEntry(input.modelFile, files);
  std::optional<std::string> text = files.read(named.file);
  if (!text || input.dialect == kCpfgDialect || text->size() > input.limits.maximumSourceBytes) {
    return std::nullopt;
  }
  TranslatedModel translated;
  translated.foreign = {named.file, files::asUtf8(*text)};
  const std::string& foreign = translated.foreign.text;
  const bool isAsked = !input.dialect.empty();
  if (!isAsked && looksLikeCpfg(foreign)) {
    return std::nullopt;
  }
  const auto found = std::find_if(kDialects.begin(), kDialects.end(), [&](const Dialect& dialect) {
    return isAsked ? dialect.name == input.dialect : dialect.recognises(foreign);
  });
  DialectReport report(translated.foreign, translated.diagnostics);
  if (found == kDialects.end()) {
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
