#include "engine/language/checks/habit_checks.h"

#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/core/work_meter.h"
#include "engine/language/checks/formal_modules.h"
#include "engine/language/decimal_comma.h"
#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

using Modules = std::vector<ModuleSyntax>;

constexpr std::string_view kRemarkSigns = "#;%";
constexpr std::size_t kShortestHabit = 3;  // letters
constexpr std::size_t kMostQuoted = 80;    // bytes
constexpr std::string_view kDrawnLetters = "FfGg";
constexpr std::string_view kMeasured = "FfGg+-&^/\\";          // a number behind them is a length or an angle
constexpr std::string_view kOneParameter = "FfGg+-&^/\\#!;,";  // the turtle reads one parameter of these

bool isRelation(Operation operation) {
  return operation == Operation::Less || operation == Operation::LessEqual || operation == Operation::Greater ||
         operation == Operation::GreaterEqual;
}

bool isLogical(Operation operation) {
  return isRelation(operation) || operation == Operation::Equal || operation == Operation::NotEqual ||
         operation == Operation::LogicalAnd || operation == Operation::LogicalOr;
}

class HabitChecks {
 public:
  HabitChecks(std::string_view text, const ModelSyntax& model, MessageList& messages)
      : text_(text), model_(model), messages_(messages) {}

  void run() {
    for (const LSystemSyntax& system : model_.systems) {
      for (const ProductionListSyntax* list : {&system.productions, &system.decomposition, &system.homomorphism}) {
        for (const ProductionSyntax& production : list->productions) {
          forFormals(production, [this](const FormalModuleSyntax& module) {
            readTypes_.insert(module.type);
            readSymbols_.insert(model_.symbols.types()[module.type].symbol);
          });
        }
      }
    }
    for (const LSystemSyntax& system : model_.systems) {
      checkLineEnds(system);
      checkModules(system.axiom);
      for (const ProductionListSyntax* list : {&system.productions, &system.decomposition, &system.homomorphism}) {
        for (const ProductionSyntax& production : list->productions) {
          checkModules(production.successor);
          checkChains(production.condition);
        }
      }
    }
  }

 private:
  [[nodiscard]] core::SymbolId symbolOf(const ModuleSyntax& module) const {
    return model_.symbols.types()[module.type].symbol;
  }
  [[nodiscard]] char characterOf(const ModuleSyntax& module) const {
    return model_.symbols[symbolOf(module)].character();
  }
  /// The text of a range on one line, cut when it is long.
  [[nodiscard]] std::string textOf(core::SourceRange range) const {
    std::size_t end = std::min<std::size_t>(range.end, range.begin + kMostQuoted);
    while (end < range.end && (static_cast<unsigned char>(text_[end]) & 0xC0U) == 0x80U) {
      --end;
    }
    return foldBlanks(text_.substr(range.begin, end - range.begin)) + (end < range.end ? "…" : "");
  }
  [[nodiscard]] bool isGap(std::size_t position) const {
    return position >= text_.size() || isBlank(text_[position]) || text_[position] == '\n' || text_[position] == '\r';
  }

  /// Whether the model writes numbers as 1.5. Looked up once.
  [[nodiscard]] bool hasDecimalPoint() {
    if (!hasDecimalPoint_) {
      hasDecimalPoint_ = findDecimalPoint();
    }
    return *hasDecimalPoint_;
  }
  [[nodiscard]] bool findDecimalPoint() const {
    for (std::size_t i = text_.find('.'); i != std::string_view::npos; i = text_.find('.', i + 1)) {
      if (i > 0 && i + 1 < text_.size() && isDigit(text_[i - 1]) && isDigit(text_[i + 1])) {
        return true;
      }
    }
    return false;
  }

  void checkModules(const Modules& modules) {
    core::pollWork();
    for (std::size_t i = 0; i < modules.size(); ++i) {
      if (isRemark(modules, i)) {
        const core::SourceRange range{modules[i].range.begin, modules.back().range.end};
        messages_.warning(range,
                          "'" + textOf(range) + "' is read as modules: the turtle command '" + characterOf(modules[i]) +
                              "' and each letter behind it",
                          "a comment is written as /* ... */ or behind //");
        return;
      }
      checkDecimalComma(modules, i);
      checkNumber(modules, i);
      checkSurfaceName(modules, i);
    }
    checkChoice(modules);
  }

  // `A --> AB;` on every line
  void checkLineEnds(const LSystemSyntax& system) {
    const auto endsInSign = [this](const Modules& modules) {
      return modules.size() > 1 && modules.back().parameters.empty() && characterOf(modules.back()) == ';';
    };
    const std::vector<ProductionSyntax>& productions = system.productions.productions;
    const auto productionEndsInSign = [&](const ProductionSyntax& production) {
      return endsInSign(production.successor);
    };
    if (!productions.empty() && endsInSign(system.axiom) && !readTypes_.contains(system.axiom.back().type) &&
        std::ranges::all_of(productions, productionEndsInSign)) {
      messages_.warning(system.axiom.back().range,
                        "this ';' and that of each production are modules, which change the colour",
                        "remove these ';'. If a ';' shall end each production, write 'Syntax: free' before the first "
                        "L-system");
    }
  }

  /// The end of the run of letters without gaps that begins with module `i`. Only the last may have parameters.
  [[nodiscard]] std::size_t wordEnd(const Modules& modules, std::size_t i) const {
    std::size_t end = i;
    while (
        end < modules.size() && isIdentifierStart(characterOf(modules[end])) &&
        (end == i || (modules[end].range.begin == modules[end - 1].range.end && modules[end - 1].parameters.empty()))) {
      ++end;
    }
    return end;
  }

  // a sign between blanks or before a word, and a word in which some letter means nothing
  [[nodiscard]] bool isRemark(const Modules& modules, std::size_t i) const {
    if (kRemarkSigns.find(characterOf(modules[i])) == std::string_view::npos || !modules[i].parameters.empty() ||
        readTypes_.contains(modules[i].type) || modules[i].range.begin == 0 || !isGap(modules[i].range.begin - 1)) {
      return false;
    }
    const std::size_t end = wordEnd(modules, i + 1);
    return end >= i + 1 + kShortestHabit && modules[end - 1].parameters.empty() && isGap(modules[end - 1].range.end) &&
           hasIdleLetter(modules, i + 1, end) && hasSmallLetter(modules, i + 1, end);
  }
  /// Words have small letters; markers that only people read, as in `; F XD`, are mostly capitals.
  [[nodiscard]] bool hasSmallLetter(const Modules& modules, std::size_t begin, std::size_t end) const {
    return std::any_of(modules.begin() + static_cast<std::ptrdiff_t>(begin),
                       modules.begin() + static_cast<std::ptrdiff_t>(end), [this](const ModuleSyntax& module) {
                         const char letter = characterOf(module);
                         return letter >= 'a' && letter <= 'z' && kDrawnLetters.find(letter) == std::string_view::npos;
                       });
  }

  /// Whether one of the letters is neither drawn nor read by a production.
  [[nodiscard]] bool hasIdleLetter(const Modules& modules, std::size_t begin, std::size_t end) const {
    return std::any_of(modules.begin() + static_cast<std::ptrdiff_t>(begin),
                       modules.begin() + static_cast<std::ptrdiff_t>(end), [this](const ModuleSyntax& module) {
                         return !readSymbols_.contains(symbolOf(module)) &&
                                kDrawnLetters.find(characterOf(module)) == std::string_view::npos;
                       });
  }

  // `+45` and `F1.5`
  void checkNumber(const Modules& modules, std::size_t i) {
    if (kMeasured.find(characterOf(modules[i])) == std::string_view::npos) {
      return;
    }
    std::size_t end = i + 1;
    while (end < modules.size() && modules[end].range.begin == modules[end - 1].range.end &&
           modules[end - 1].parameters.empty() && modules[end].parameters.empty() &&
           !readSymbols_.contains(symbolOf(modules[end])) &&
           (isDigit(characterOf(modules[end])) || (characterOf(modules[end]) == '.' && end > i + 1))) {
      ++end;
    }
    // this one is a vertex
    end -= characterOf(modules[end - 1]) == '.' && end > i + 1 ? 1 : 0;
    if (end == i + 1) {
      return;
    }
    const core::SourceRange range{modules[i].range.begin, modules[end - 1].range.end};
    const std::string text = textOf(range);
    if (!reportedNumbers_.insert(text).second) {
      return;
    }
    messages_.warning(range, "'" + text + "' is read as '" + text.substr(0, 1) + "' and a module for each digit",
                      "a value stands in parentheses: " + text.substr(0, 1) + "(" + text.substr(1) + ")");
  }

  // `~leaf(2)`
  void checkSurfaceName(const Modules& modules, std::size_t i) {
    if (characterOf(modules[i]) != '~' || !modules[i].parameters.empty()) {
      return;
    }
    const std::size_t end = wordEnd(modules, i + 1);
    if (end < i + 1 + kShortestHabit || !hasIdleLetter(modules, i + 2, end)) {
      return;
    }
    const core::SourceRange range{modules[i].range.begin, modules[end - 1].range.end};
    const std::string letter(1, characterOf(modules[i + 1]));
    messages_.warning(
        range,
        "'" + textOf(range) + "' is read as the surface '~" + letter + "' and a module for each letter behind it",
        "the name of a surface has one letter, as in ~" + letter + "(2)");
  }

  void checkChoice(const Modules& modules) {
    for (std::size_t i = 0; i < modules.size();) {
      const std::size_t end = std::max(wordEnd(modules, i), i + 1);
      std::string word;
      for (std::size_t k = i; k < end; ++k) {
        word += characterOf(modules[k]);
      }
      const std::vector<ExpressionIndex>& parameters = modules[end - 1].parameters;
      const bool isIf =
          word == "if" && parameters.size() == 1 && isLogical(model_.expressions[parameters.front()].operation);
      const bool isElse = word == "else" && isGap(modules[end - 1].range.end);
      if (isIf || (isElse && parameters.empty())) {
        const core::SourceRange range{modules[i].range.begin, modules[end - 1].range.end};
        messages_.warning(range, "'" + textOf(range) + "' is read as modules: a successor cannot choose",
                          "write a production for each case, as A(n) : n < 3 --> F and below it A(n) --> B: the first "
                          "that matches applies");
        return;
      }
      i = end;
    }
  }

  void checkDecimalComma(const Modules& modules, std::size_t i) {
    const ModuleSyntax& module = modules[i];
    const char before = i > 0 && modules[i - 1].parameters.empty() ? characterOf(modules[i - 1]) : '\0';
    if (module.parameters.size() != 2 || kOneParameter.find(characterOf(module)) == std::string_view::npos ||
        before == '@' || before == '~' || before == '?' || readTypes_.contains(module.type)) {
      return;
    }
    // an author who writes decimal points means two values
    if (std::string hint = decimalCommaHint(text_, module.range); !hint.empty() && !hasDecimalPoint()) {
      messages_.warning(module.range,
                        "the turtle reads one parameter of '" + std::string(1, characterOf(module)) + "', and '" +
                            textOf(module.range) + "' has 2",
                        std::move(hint));
    }
  }

  // `0 < n < 2`; parentheses around the first comparison belong to its range
  void checkChains(ExpressionIndex condition) {
    if (condition == kNoExpression) {
      return;
    }
    for (ExpressionIndex i = firstNode(model_, condition); i <= condition; ++i) {
      core::pollWork();
      const ExpressionNode& node = model_.expressions[i];
      if (node.kind != ExpressionKind::Binary || !isRelation(node.operation)) {
        continue;
      }
      const ExpressionNode& left = model_.expressions[node.children.front()];
      if (left.kind != ExpressionKind::Binary || !isRelation(left.operation) ||
          left.range.begin < model_.expressions[left.children.front()].range.begin) {
        continue;
      }
      const core::SourceRange middle = model_.expressions[left.children.back()].range;
      const core::SourceRange second{middle.begin, node.range.end};
      messages_.warning(node.range,
                        "'" + textOf(node.range) + "' compares the result of '" + textOf(left.range) +
                            "', which is 0 or 1, with '" + textOf(model_.expressions[node.children.back()].range) + "'",
                        "write " + textOf(left.range) + " && " + textOf(second));
    }
  }

  std::string_view text_;
  const ModelSyntax& model_;
  MessageList& messages_;
  std::optional<bool> hasDecimalPoint_;
  std::set<std::string> reportedNumbers_;
  std::set<core::ModuleTypeId> readTypes_;  // in a predecessor or context
  std::set<core::SymbolId> readSymbols_;    // the same, with any number of parameters
};

}  // namespace

void checkHabits(std::string_view text, const ModelSyntax& model, MessageList& messages) {
  HabitChecks(text, model, messages).run();
}

}  // namespace espalier::language
