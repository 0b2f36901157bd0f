#include "server/language_server/handbook_rows.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

// the page itself is in the program: what it says is written once
__asm__(".section .rodata\nespalierLanguagePageBegin:\n.incbin \"" ESPALIER_LANGUAGE_PAGE
        "\"\nespalierLanguagePageEnd:\n.byte 0\n.previous\n");
extern "C" const char espalierLanguagePageBegin[];
extern "C" const char espalierLanguagePageEnd[];

namespace espalier::server {
namespace {

struct Row {
  std::string left, right;
};

/// The first two cells of every row of the tables whose first heading is `heading`.
std::vector<Row> rowsOf(std::string_view page, std::string_view heading) {
  std::vector<Row> rows;
  bool isInTable = false;
  while (!page.empty()) {
    const std::size_t end = std::min(page.find('\n'), page.size());
    const std::string_view line = page.substr(0, end);
    page.remove_prefix(std::min(end + 1, page.size()));
    if (!line.starts_with('|')) {
      isInTable = false;
      continue;
    }
    std::array<std::string, 2> cells;
    std::size_t cell = 0;
    for (std::size_t i = 1; i < line.size() && cell < cells.size(); ++i) {
      if (line[i] == '\\' && i + 1 < line.size() && line[i + 1] == '|') {
        cells[cell] += line[++i];
      } else if (line[i] == '|') {
        ++cell;
      } else {
        cells[cell] += line[i];
      }
    }
    for (std::string& text : cells) {
      text.erase(0, std::min(text.find_first_not_of(' '), text.size()));
      text.erase(text.find_last_not_of(' ') + 1);
    }
    if (cells[0] == heading) {
      isInTable = true;
    } else if (isInTable && !cells[0].starts_with("---")) {
      rows.push_back({cells[0], cells[1]});
    }
  }
  return rows;
}

std::string_view languagePage() {
  return {espalierLanguagePageBegin, static_cast<std::size_t>(espalierLanguagePageEnd - espalierLanguagePageBegin)};
}

/// The code of a cell: what stands between backquotes, with blanks between the pieces.
std::string codeOf(std::string_view cell) {
  std::string code;
  bool isCode = false;
  for (const char c : cell) {
    if (c == '`') {
      isCode = !isCode;
      code += ' ';
    } else if (isCode) {
      code += c;
    }
  }
  return code;
}

std::string asMarkdown(const Row& row) {
  return row.left + "\n\n" + row.right;
}

bool isNameCharacter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

/// The names in the code of a functions' row: words that stand outside parentheses and quotes.
std::vector<std::string> functionNames(const std::string& code) {
  std::vector<std::string> names;
  int depth = 0;
  for (std::size_t i = 0; i < code.size(); ++i) {
    depth += code[i] == '(' ? 1 : (code[i] == ')' ? -1 : 0);
    if (depth == 0 && isNameCharacter(code[i])) {
      std::size_t end = i;
      while (end < code.size() && isNameCharacter(code[end])) {
        ++end;
      }
      names.push_back(code.substr(i, end - i));
      i = end - 1;
    }
  }
  return names;
}

/// The symbols in the code of a symbols' row: a character, or `@` with what follows it, outside parentheses.
std::vector<std::string> symbolNames(const std::string& code) {
  std::vector<std::string> names;
  int depth = 0;
  for (std::size_t i = 0; i < code.size(); ++i) {
    depth += code[i] == '(' ? 1 : (code[i] == ')' ? -1 : 0);
    if (depth != 0 || code[i] == ' ' || code[i] == ')') {
      continue;
    }
    std::size_t end = i + 1;
    if (code[i] == '@') {
      end = std::min(i + 2, code.size());
      while (end < code.size() && code[end] >= 'a' && code[end] <= 'z') {
        ++end;
      }
    } else if (code[i] == '~' && end < code.size()) {
      ++end;  // the letter of a surface
    }
    names.push_back(code[i] == '~' ? "~" : code.substr(i, end - i));
    i = end - 1;
  }
  return names;
}

using Table = std::map<std::string, std::string, std::less<>>;

Table functionTable() {
  Table table;
  for (const Row& row : rowsOf(languagePage(), "function")) {
    for (const std::string& name : functionNames(codeOf(row.left))) {
      table.emplace(name, asMarkdown(row));
    }
  }
  return table;
}

Table symbolTable() {
  Table table;
  for (const Row& row : rowsOf(languagePage(), "symbol")) {
    for (const std::string& name : symbolNames(codeOf(row.left))) {
      table.emplace(name, asMarkdown(row));
    }
  }
  return table;
}

std::optional<std::string> findIn(const Table& table, std::string_view name) {
  const auto found = table.find(name);
  return found == table.end() ? std::nullopt : std::optional<std::string>(found->second);
}

}  // namespace

std::optional<std::string> handbookFunction(std::string_view name) {
  static const Table table = functionTable();
  return findIn(table, name);
}

std::optional<std::string> handbookSymbol(std::string_view symbol) {
  static const Table table = symbolTable();
  return findIn(table, symbol);
}

}  // namespace espalier::server
