#include <set>
#include <string_view>

#include "engine/language/outline/name_uses.h"
#include "engine/language/preprocess/line_reader.h"

namespace espalier::language {
namespace {

// the position of the first byte that is no blank
std::size_t afterBlanks(std::string_view text, std::size_t position) {
  while (position < text.size() && isBlank(text[position])) {
    ++position;
  }
  return position;
}

// the position behind `#define `, `#if ` and so on; npos when the line is no such directive
std::size_t afterDirective(std::string_view line, std::string_view word) {
  std::size_t position = afterBlanks(line, 0);
  if (position >= line.size() || line[position] != '#') {
    return std::string_view::npos;
  }
  position = afterBlanks(line, position + 1);
  const std::size_t end = wordEnd(line, position);
  return line.substr(position, end - position) == word ? afterBlanks(line, end) : std::string_view::npos;
}

/// Calls visit(line, positions) for every logical line of a file.
template <typename Visit>
void forEachLine(const files::SourceMap::File& file, const Visit& visit) {
  LineReader reader(file.text);
  LogicalLine line;
  while (reader.next(line)) {
    visit(line);
  }
}

}  // namespace

std::vector<MacroDefinition> macroDefinitions(const files::SourceMap& map) {
  std::vector<MacroDefinition> definitions;
  for (std::uint32_t file = 0; file < map.files.size(); ++file) {
    forEachLine(map.files[file], [&](const LogicalLine& line) {
      const std::string_view text = line.text;
      const std::size_t begin = afterDirective(text, "define");
      if (begin == std::string_view::npos || begin >= text.size() || !isWordStart(text[begin])) {
        return;
      }
      std::size_t end = wordEnd(text, begin);
      MacroDefinition& definition = definitions.emplace_back();
      definition.name = text.substr(begin, end - begin);
      definition.file = file;
      definition.offset = line.offsetOf(begin);
      definition.isFunctionLike = end < text.size() && text[end] == '(';
      if (definition.isFunctionLike) {
        end = std::min(text.find(')', end), text.size() - 1) + 1;
      }
      const std::size_t body = afterBlanks(text, end);
      definition.text = trimBlanks(text.substr(std::min(body, text.size())));
      definition.textOffset = line.offsetOf(body);
    });
  }
  return definitions;
}

std::vector<NameUse> macroUses(const files::SourceMap& map) {
  std::set<std::string, std::less<>> names;
  for (const MacroDefinition& definition : macroDefinitions(map)) {
    names.insert(definition.name);
  }
  std::vector<NameUse> uses;
  for (std::uint32_t file = 0; file < map.files.size() && !names.empty(); ++file) {
    forEachLine(map.files[file], [&](const LogicalLine& line) {
      const std::string_view text = line.text;
      const std::size_t defined = afterDirective(text, "define");
      StringLiterals literals(text);
      for (std::size_t position = 0; position < text.size();) {
        if (text[position] == '"') {
          position = std::max(literals.endOf(position), position + 1);
          continue;
        }
        const std::size_t end = wordEnd(text, position);
        if (end == position) {
          ++position;
          continue;
        }
        const std::string_view word = text.substr(position, end - position);
        if (names.contains(word)) {
          NameUse& use = uses.emplace_back();
          use.kind = NameKind::Macro;
          use.name = word;
          use.isDefinition = position == defined;
          use.file = file;
          use.offset = line.offsetOf(position);
          use.length = static_cast<std::uint32_t>(word.size());
        }
        position = end;
      }
    });
  }
  return uses;
}

}  // namespace espalier::language
