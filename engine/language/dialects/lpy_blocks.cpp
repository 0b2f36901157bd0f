#include "engine/language/dialects/lpy_blocks.h"

#include <algorithm>
#include <cctype>

#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

constexpr std::size_t kMostRepetitions = 1000;
constexpr std::string_view kOneColumn = "the statements of a block begin in one column";

// the end of the code of a line: a '#' outside of quotes begins a remark
std::size_t endOfCode(std::string_view line) {
  char quote = '\0';
  for (std::size_t at = 0; at < line.size(); ++at) {
    const char c = line[at];
    if (quote != '\0') {
      quote = c == quote ? '\0' : quote;
    } else if (c == '"') {
      quote = c;
    } else if (c == '#') {
      return at;
    }
  }
  return line.size();
}

// the place of the ':' that ends the head of a compound statement
std::size_t headEnd(std::string_view code) {
  int depth = 0;
  for (std::size_t at = 0; at < code.size(); ++at) {
    depth += code[at] == '(' || code[at] == '[' ? 1 : code[at] == ')' || code[at] == ']' ? -1 : 0;
    if (code[at] == ':' && depth <= 0) {
      return at;
    }
  }
  return std::string_view::npos;
}

int parenthesisDepth(std::string_view code) {
  int depth = 0;
  for (const char c : code) {
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
  }
  return depth;
}

}  // namespace

std::vector<PythonLine> pythonLines(std::string_view text) {
  std::vector<PythonLine> lines;
  bool isInString = false;
  std::string_view quotes;
  bool continues = false;
  for (const TextPiece& line : linesOf(text)) {
    if (line.text.starts_with("###")) {
      break;
    }
    const TextPiece trimmed = line.trimmed();
    // a string of several lines that stands alone is a remark
    if (isInString) {
      isInString = trimmed.text.find(quotes) == std::string_view::npos;
      continue;
    }
    for (const std::string_view mark : {"\"\"\"", "'''"}) {
      if (!continues && trimmed.text.starts_with(mark)) {
        quotes = mark;
        isInString = trimmed.text.find(mark, mark.size()) == std::string_view::npos;
      }
    }
    if (!continues && (isInString || trimmed.text.starts_with("\"\"\"") || trimmed.text.starts_with("'''"))) {
      continue;
    }
    TextPiece code = TextPiece{line.to(endOfCode(line.text))}.trimmed();
    if (code.empty()) {
      continue;
    }
    if (continues) {
      PythonLine& last = lines.back();
      last.code.text = text.substr(last.code.offset, code.offset + code.text.size() - last.code.offset);
    } else {
      std::size_t indent = 0;
      for (std::size_t at = 0; at < code.offset - line.offset; ++at) {
        indent = line.text[at] == '\t' ? (indent / 8 + 1) * 8 : indent + 1;
      }
      lines.push_back({indent, code});
    }
    // a backslash at the end, or an open parenthesis, joins the next line
    continues = code.text.ends_with('\\') || parenthesisDepth(lines.back().code.text) > 0;
  }
  return lines;
}

std::vector<PythonStatement> pythonBlock(const std::vector<PythonLine>& lines, std::size_t begin, std::size_t end,
                                         DialectReport& report) {
  std::vector<PythonStatement> statements;
  for (std::size_t i = begin; i < end;) {
    if (lines[i].indent < lines[begin].indent) {
      report.error(lines[i].code.offset, lines[i].code.text.size(), "the line begins between the columns of two blocks",
                   std::string(kOneColumn));
    }
    PythonStatement statement{lines[i].code, {}, false};
    bool hasBlock = false;
    std::size_t next = i + 1;
    while (next < end && lines[next].indent > lines[i].indent) {
      ++next;
    }
    const std::string word = firstWord(lines[i].code).first;
    const bool isCompound = word == "if" || word == "elif" || word == "else" || word == "for" || word == "while" ||
                            word == "def" || word == "class" || word == "try" || word == "with";
    const std::size_t colon = isCompound ? headEnd(lines[i].code.text) : std::string_view::npos;
    if (colon != std::string_view::npos) {
      statement.isCompound = true;
      statement.code = lines[i].code.to(colon).trimmed();
      const TextPiece rest = lines[i].code.from(colon + 1).trimmed();
      hasBlock = rest.empty();
      statement.body =
          hasBlock ? pythonBlock(lines, i + 1, next, report) : std::vector<PythonStatement>{{rest, {}, false}};
    }
    if (hasBlock && next == i + 1) {
      report.error(lines[i].code.offset, lines[i].code.text.size(),
                   "no line of '" + word + "' is indented deeper than it", "its statements stand to the right of it");
    } else if (!hasBlock && next > i + 1) {
      report.error(lines[i + 1].code.offset, lines[i + 1].code.text.size(),
                   "the line is indented deeper than its block", std::string(kOneColumn));
    }
    statements.push_back(std::move(statement));
    i = next;
  }
  return statements;
}

std::pair<std::string, TextPiece> firstWord(const TextPiece& code) {
  std::size_t end = 0;
  while (end < code.text.size() && isIdentifierPart(code.text[end])) {
    ++end;
  }
  return {std::string(code.text.substr(0, end)), code.from(end).trimmed()};
}

std::optional<PythonAssignment> assignmentOf(const TextPiece& code) {
  const auto [name, rest] = firstWord(code);
  if (name.empty() || std::isdigit(static_cast<unsigned char>(name.front())) != 0 || rest.empty()) {
    return std::nullopt;
  }
  if (rest.text.starts_with('=') && !rest.text.starts_with("==")) {
    return PythonAssignment{name, '=', rest.from(1).trimmed()};
  }
  if (rest.text.size() > 1 && rest.text[1] == '=' &&
      std::string_view("+-*/").find(rest.text[0]) != std::string_view::npos) {
    return PythonAssignment{name, rest.text[0], rest.from(2).trimmed()};
  }
  return std::nullopt;
}

std::optional<PythonLoop> loopOf(const TextPiece& head, const LpyScope& scope, LpyDraws& draws, DialectReport& report) {
  const TextPiece loop = head.from(3).trimmed();
  PythonLoop result;
  TextPiece rest;
  std::tie(result.variable, rest) = firstWord(loop);
  const auto [word, range] = firstWord(rest);
  const bool isRange = word == "in" && (range.text.starts_with("range") || range.text.starts_with("xrange"));
  const std::size_t open = range.text.find('(');
  if (!isRange || open == std::string_view::npos || !range.text.ends_with(')')) {
    report.error(head.offset, head.text.size(), "a loop over anything but range(...) needs Python",
                 std::string(kNeedsPython));
    return std::nullopt;
  }
  std::vector<double> bounds;
  for (const TextPiece& argument : lpyArguments(range.to(range.text.size() - 1).from(open + 1))) {
    const auto value = translateLpyExpression(argument, scope, draws, report);
    if (!value) {
      return std::nullopt;
    }
    if (!value->number) {
      report.error(
          argument.offset, argument.text.size(), "a loop whose bounds are not constant needs Python",
          "give range() numbers or constants of the file, or write a rule that counts: A(i) : i < n --> B A(i+1)");
      return std::nullopt;
    }
    bounds.push_back(*value->number);
  }
  if (bounds.empty() || bounds.size() > 3) {
    report.error(head.offset, head.text.size(), "range() takes one to three numbers", "write range(3)");
    return std::nullopt;
  }
  const double first = bounds.size() > 1 ? bounds[0] : 0.0;
  const double last = bounds.size() > 1 ? bounds[1] : bounds[0];
  const double step = bounds.size() > 2 ? bounds[2] : 1.0;
  for (double value = first; step > 0.0 ? value < last : step < 0.0 && value > last; value += step) {
    if (result.values.size() == kMostRepetitions) {
      report.error(head.offset, head.text.size(), "a loop of more than 1000 repetitions",
                   "loops are written out: write a rule that counts instead");
      return std::nullopt;
    }
    result.values.push_back(value);
  }
  return result;
}

}  // namespace espalier::language
