#include "engine/language/preprocess/macro_table.h"

#include <algorithm>
#include <optional>

#include "engine/core/work_meter.h"

namespace espalier::language {
namespace {

// the longest text that macros may expand to: so many bytes, and so many for each byte of the model's text
constexpr std::uint64_t kLeastExpansion = 1'000'000;
constexpr std::uint64_t kMostExpansion = 100;

}  // namespace

std::size_t stringLiteralEnd(std::string_view line, std::size_t begin) {
  // a line of quotes that have no partners asks for each of them
  core::pollWork();
  for (std::size_t i = begin + 1; i < line.size(); ++i) {
    if (line[i] == '\\') {
      ++i;
    } else if (line[i] == '"') {
      return i + 1;
    }
  }
  return begin;
}

std::size_t wordEnd(std::string_view line, std::size_t begin) {
  std::size_t end = begin;
  if (end < line.size() && isWordStart(line[end])) {
    while (end < line.size() && isWordPart(line[end])) {
      ++end;
    }
  } else if (end < line.size() && isDigit(line[end])) {
    while (end < line.size() && (isWordPart(line[end]) || line[end] == '.')) {
      ++end;
    }
  }
  return end;
}

std::string_view trimBlanks(std::string_view text) {
  while (!text.empty() && isBlank(text.front())) {
    text.remove_prefix(1);
  }
  while (!text.empty() && isBlank(text.back())) {
    text.remove_suffix(1);
  }
  return text;
}

bool MacroTable::define(Macro macro) {
  const auto found = macros_.find(macro.name);
  if (found != macros_.end() && found->second.isFixed) {
    return false;
  }
  std::string name = macro.name;
  macros_.insert_or_assign(std::move(name), std::move(macro));
  return true;
}

void MacroTable::undefine(std::string_view name) {
  const auto found = macros_.find(name);
  if (found != macros_.end() && !found->second.isFixed) {
    macros_.erase(found);
  }
}

std::vector<std::string> MacroTable::names() const {
  std::vector<std::string> result;
  for (const auto& [name, macro] : macros_) {
    result.push_back(name);
  }
  return result;
}

const Macro* MacroTable::find(std::string_view name) const {
  const auto found = macros_.find(name);
  return found == macros_.end() ? nullptr : &found->second;
}

bool MacroTable::hasOpenCall(std::string_view line) const {
  StringLiterals literals(line);
  std::size_t i = 0;
  while (i < line.size()) {
    std::size_t end = std::max(line[i] == '"' ? literals.endOf(i) : wordEnd(line, i), i + 1);
    const Macro* const macro = find(line.substr(i, end - i));
    i = end;
    if (macro == nullptr || !macro->isFunctionLike) {
      continue;
    }
    while (end < line.size() && isBlank(line[end])) {
      ++end;
    }
    if (end == line.size() || line[end] != '(') {
      continue;
    }
    std::size_t depth = 0;
    do {
      const char c = line[end];
      depth += c == '(' ? 1U : 0U;
      depth -= c == ')' ? 1U : 0U;
      if (c == '\'') {
        // a quote without a partner hides the rest of the line: the call is a mistake
        end = std::min(line.find('\'', end + 1), line.size());
        if (end == line.size()) {
          return false;
        }
      }
      end = c == '"' ? std::max(literals.endOf(end), end + 1) : end + 1;
    } while (depth > 0 && end < line.size());
    if (depth > 0) {
      return true;
    }
    i = end;
  }
  return false;
}

/// The expansion of one line.
class MacroTable::Expansion {
 public:
  Expansion(MacroTable& table, const std::function<void(const ExpansionProblem&)>& problem)
      : table_(table), problem_(problem) {}

  std::vector<ExpandedPiece> pieces(std::string_view text) {
    std::vector<ExpandedPiece> result;
    StringLiterals literals(text);
    std::size_t copied = 0;
    std::size_t i = 0;
    while (i < text.size()) {
      if (text[i] == '"') {
        i = std::max(literals.endOf(i), i + 1);
        continue;
      }
      const std::size_t end = wordEnd(text, i);
      if (end == i) {
        ++i;
        continue;
      }
      if (isDepthZero()) {
        useBegin_ = i;
        useEnd_ = end;
      }
      const Macro* macro = table_.find(text.substr(i, end - i));
      std::size_t useEnd = end;
      std::optional<std::string> replacement;
      if (macro != nullptr && !isActive(macro)) {
        replacement = use(*macro, text, end, useEnd);
      }
      if (replacement.has_value()) {
        if (copied < i) {
          result.push_back({copied, i, nullptr, {}});
        }
        result.push_back({i, useEnd, macro, std::move(*replacement)});
        copied = useEnd;
      }
      i = useEnd;
      if (hasFailed_) {
        break;
      }
    }
    if (copied < text.size()) {
      result.push_back({copied, text.size(), nullptr, {}});
    }
    return result;
  }

 private:
  [[nodiscard]] bool isDepthZero() const { return active_.empty() && argumentDepth_ == 0; }
  [[nodiscard]] bool isActive(const Macro* macro) const {
    return std::find(active_.begin(), active_.end(), macro) != active_.end();
  }

  void report(std::string message, std::string hint, bool isFatal) {
    if (!hasFailed_) {
      problem_({useBegin_, useEnd_, std::move(message), std::move(hint), isFatal});
    }
    hasFailed_ = hasFailed_ || isFatal;
  }

  void reportDepth(const Macro& macro) {
    report("the macro '" + macro.name + "' is nested deeper than the limit macroDepth (" +
               std::to_string(table_.limits_.maximumMacroDepth) + ")",
           "", true);
  }

  // the replacement of a use whose name ends at `nameEnd`; nothing when it stays as it is
  std::optional<std::string> use(const Macro& macro, std::string_view text, std::size_t nameEnd, std::size_t& useEnd) {
    std::vector<std::string> arguments;
    if (macro.isFunctionLike && !collectArguments(macro, text, nameEnd, useEnd, arguments)) {
      return std::nullopt;
    }
    std::string result = rescan(macro, substitute(macro, arguments));
    // the result may end in the name of a function-like macro whose arguments follow
    while (!hasFailed_) {
      std::size_t begin = result.size();
      while (begin > 0 && isWordPart(result[begin - 1])) {
        --begin;
      }
      const Macro* last = table_.find(std::string_view(result).substr(begin));
      std::size_t end = useEnd;
      if (last == nullptr || !last->isFunctionLike || last == &macro || isActive(last) ||
          !opensArguments(text, useEnd) || !collectArguments(*last, text, useEnd, end, arguments)) {
        break;
      }
      useEnd = end;
      result.resize(begin);
      result += rescan(*last, substitute(*last, arguments));
    }
    return result;
  }

  static bool opensArguments(std::string_view text, std::size_t position) {
    while (position < text.size() && isBlank(text[position])) {
      ++position;
    }
    return position < text.size() && text[position] == '(';
  }

  bool collectArguments(const Macro& macro, std::string_view text, std::size_t position, std::size_t& useEnd,
                        std::vector<std::string>& arguments) {
    if (!opensArguments(text, position)) {
      return false;
    }
    arguments.clear();
    std::size_t i = text.find('(', position) + 1;
    std::size_t argumentBegin = i;
    int depth = 1;
    bool hasOpenQuote = false;
    StringLiterals literals(text);
    while (i < text.size() && depth > 0) {
      const char c = text[i];
      if (c == '"') {
        i = std::max(literals.endOf(i), i + 1);
        continue;
      }
      if (c == '\'') {
        // without a partner on the line it hides the rest of the line
        hasOpenQuote = text.find('\'', i + 1) == std::string_view::npos;
        i = hasOpenQuote ? text.size() : text.find('\'', i + 1) + 1;
        continue;
      }
      depth += c == '(' ? 1 : (c == ')' ? -1 : 0);
      if ((c == ',' && depth == 1) || depth == 0) {
        arguments.emplace_back(trimBlanks(text.substr(argumentBegin, i - argumentBegin)));
        argumentBegin = i + 1;
      }
      ++i;
    }
    if (depth > 0) {
      report("expected ')' while reading the arguments of the macro '" + macro.name + "', found the end of the line",
             hasOpenQuote ? "a ' without a partner hides the ')' behind it: remove it"
                          : "close the call; its arguments may stand on several lines",
             false);
      return false;
    }
    if (macro.parameters.empty() && arguments.size() == 1 && arguments[0].empty()) {
      arguments.clear();
    }
    if (arguments.size() != macro.parameters.size()) {
      report("expected " + std::to_string(macro.parameters.size()) + " arguments while reading the macro '" +
                 macro.name + "', found " + std::to_string(arguments.size()),
             "", false);
      return false;
    }
    useEnd = i;
    // arguments are expanded before they are put in
    if (argumentDepth_ >= table_.limits_.maximumMacroDepth) {
      reportDepth(macro);
      return false;
    }
    ++argumentDepth_;
    for (std::string& argument : arguments) {
      argument = flatten(argument);
    }
    --argumentDepth_;
    return true;
  }

  std::string substitute(const Macro& macro, const std::vector<std::string>& arguments) {
    if (!macro.isFunctionLike) {
      return macro.body;
    }
    const std::string_view body = macro.body;
    StringLiterals literals(body);
    std::string result;
    std::size_t i = 0;
    while (i < body.size() && charge(0, result.size())) {
      std::size_t end = body[i] == '"' ? literals.endOf(i) : wordEnd(body, i);
      end = std::max(end, i + 1);
      const std::string_view word = body.substr(i, end - i);
      const auto parameter = std::find(macro.parameters.begin(), macro.parameters.end(), word);
      if (parameter == macro.parameters.end()) {
        result += word;
      } else {
        result += arguments[static_cast<std::size_t>(parameter - macro.parameters.begin())];
      }
      i = end;
    }
    return result;
  }

  std::string rescan(const Macro& macro, const std::string& text) {
    if (active_.size() >= table_.limits_.maximumMacroDepth) {
      reportDepth(macro);
      return {};
    }
    active_.push_back(&macro);
    std::string result = flatten(text);
    active_.pop_back();
    return result;
  }

  std::string flatten(std::string_view text) {
    std::string result;
    if (!charge(text.size(), 0)) {
      return result;
    }
    for (const ExpandedPiece& piece : pieces(text)) {
      if (piece.macro == nullptr) {
        result += text.substr(piece.begin, piece.end - piece.begin);
      } else {
        result += piece.text;
      }
      if (!charge(0, result.size())) {
        break;
      }
    }
    return result;
  }

  // counts scanned bytes; `pending` bytes are being made. False: over the limit
  bool charge(std::size_t scanned, std::size_t pending) {
    core::pollWork();
    table_.expandedBytes_ += scanned;
    const std::uint64_t limit = table_.limits_.maximumSourceBytes;
    const std::uint64_t bound = kLeastExpansion + kMostExpansion * table_.textBytes_;
    const std::uint64_t bytes = table_.expandedBytes_ + pending;
    if (bytes > limit) {
      report("macros expand to more than the limit sourceBytes (" + std::to_string(limit) + " bytes)", "", true);
    } else if (bytes > bound) {
      report("macros expand to more than " + std::to_string(bound) + " bytes, a hundred times the text of the model",
             "use smaller macros, or a loop or an array in their place", true);
    }
    return !hasFailed_;
  }

  MacroTable& table_;
  const std::function<void(const ExpansionProblem&)>& problem_;
  std::vector<const Macro*> active_;  // macros whose replacement is being scanned
  std::uint32_t argumentDepth_ = 0;
  std::size_t useBegin_ = 0;  // the use in the line that is being expanded
  std::size_t useEnd_ = 0;
  bool hasFailed_ = false;
};

std::vector<ExpandedPiece> MacroTable::expand(std::string_view line,
                                              const std::function<void(const ExpansionProblem&)>& problem) {
  return Expansion(*this, problem).pieces(line);
}

}  // namespace espalier::language
