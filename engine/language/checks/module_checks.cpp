#include "engine/language/checks/module_checks.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "engine/language/checks/formal_modules.h"
#include "engine/language/decimal_comma.h"

namespace espalier::language {
namespace {

constexpr std::string_view kAnswered = "PHLUQFE";  // the turtle fills them; ?E is the environment's
constexpr std::array kAfterAt{
#define ESPALIER_TURTLE_AFTER_AT(command, text, usage, meaning) std::string_view{text},
#include "engine/language/turtle_symbols.def"
};
constexpr std::string_view kTurtleLetters = "FfGgs";  // drawn or filled without a production

class ModuleChecks {
 public:
  ModuleChecks(std::string_view text, const ModelSyntax& model, MessageList& messages)
      : text_(text), model_(model), messages_(messages) {
    for (const LSystemSyntax& system : model.systems) {
      addMade(system.axiom);
      for (const ProductionListSyntax* list : {&system.productions, &system.decomposition, &system.homomorphism}) {
        for (const ProductionSyntax& production : list->productions) {
          addMade(production.successor);
          addRead(production);
        }
      }
    }
  }

  std::vector<std::string> run() {
    checkUnanswered();
    checkUnmadeQueries();
    checkArities();
    return checkCommands();
  }

 private:
  /// A module of an axiom or successor.
  struct Made {
    core::ModuleTypeId type = 0;
    core::SourceRange range;
    bool isQuery = false;    // stands behind a `?` without parameters
    bool isCommand = false;  // stands behind `@` or `~`
  };

  [[nodiscard]] const Symbol& symbolOf(core::ModuleTypeId type) const {
    return model_.symbols[model_.symbols.types()[type].symbol];
  }
  [[nodiscard]] std::uint16_t arityOf(core::ModuleTypeId type) const { return model_.symbols.types()[type].arity; }

  void addMade(const std::vector<ModuleSyntax>& modules) {
    char before = '\0';
    char beforeThat = '\0';
    for (std::size_t i = 0; i + 1 < modules.size(); ++i) {
      if (symbolOf(modules[i].type).character() == '@' && modules[i].parameters.empty()) {
        commands_.push_back({&modules[i], &modules[i + 1], i + 2 < modules.size() ? &modules[i + 2] : nullptr});
      }
    }
    for (const ModuleSyntax& module : modules) {
      made_.push_back({module.type, module.range, before == '?', before == '@' || before == '~' || beforeThat == '@'});
      beforeThat = before;
      before = module.parameters.empty() ? symbolOf(module.type).character() : '\0';
    }
  }

  void addRead(const ProductionSyntax& production) {
    for (const FormalModuleSyntax& module : production.predecessor) {
      rewritten_[model_.symbols.types()[module.type].symbol].insert(arityOf(module.type));
    }
    forFormals(production, [this](const FormalModuleSyntax& module) { read_.insert(module.type); });
  }

  // ---- queries

  void checkUnanswered() {
    std::set<std::string> reported;
    for (const Made& made : made_) {
      const Symbol& symbol = symbolOf(made.type);
      const char letter = symbol.character();
      const bool isLetter = std::isalpha(static_cast<unsigned char>(letter)) != 0;
      if (!made.isQuery || symbol.isQuery || !isLetter || kAnswered.find(letter) != std::string_view::npos ||
          !reported.insert(symbol.name).second) {
        continue;
      }
      const char capital = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
      const bool isNear = kAnswered.find(capital) != std::string_view::npos;
      messages_.warning(made.range, "nobody answers '?" + symbol.name + "': its parameters keep their values",
                        isNear ? std::string("did you mean '?") + capital + "'? The case of the letter counts"
                               : "the turtle fills ?P, ?H, ?L, ?U, ?Q and ?F, the environment ?E and the queries that "
                                 "'Module:' declares");
    }
  }

  void checkUnmadeQueries() {
    for (const Symbol& symbol : model_.symbols.symbols()) {
      const auto isIts = [&](const Made& made) { return made.isQuery && &symbolOf(made.type) == &symbol; };
      if (!symbol.isQuery || std::any_of(made_.begin(), made_.end(), isIts)) {
        continue;
      }
      // the declaration is the first place of the name
      const std::size_t place = text_.find("?" + symbol.name);
      const auto begin = static_cast<std::uint32_t>(place == std::string_view::npos ? 0 : place);
      messages_.warning({begin, begin + static_cast<std::uint32_t>(symbol.name.size()) + 1},
                        "the query ?" + symbol.name + " is declared, and no axiom or successor makes it",
                        "write ?" + symbol.name + "(...) in a successor, with the '?', or remove the declaration");
    }
  }

  // ---- numbers of parameters

  void checkArities() {
    std::set<core::ModuleTypeId> makes;
    for (const Made& made : made_) {
      makes.insert(made.type);
    }
    std::set<core::ModuleTypeId> reported;
    for (const Made& made : made_) {
      const core::SymbolId symbol = model_.symbols.types()[made.type].symbol;
      const char character = symbolOf(made.type).character();
      const auto rewritten = rewritten_.find(symbol);
      const bool isLetter = std::isalpha(static_cast<unsigned char>(character)) != 0;
      // a letter without parameters is often the finished form of one with parameters, and the other way round
      if (rewritten == rewritten_.end() || arityOf(made.type) == 0 || rewritten->second.contains(0) || !isLetter ||
          kTurtleLetters.find(character) != std::string_view::npos || made.isQuery || made.isCommand ||
          read_.contains(made.type) || reported.contains(made.type)) {
        continue;
      }
      // when no production of the symbol can match, each of them has a message of its own
      const bool isAnyMade = std::any_of(makes.begin(), makes.end(), [&](core::ModuleTypeId type) {
        return model_.symbols.types()[type].symbol == symbol && rewritten->second.contains(arityOf(type));
      });
      if (!isAnyMade) {
        continue;
      }
      reported.insert(made.type);
      std::string counts;
      for (const std::uint16_t arity : rewritten->second) {
        counts += (counts.empty() ? "" : " or ") + (arity == 0 ? std::string("no") : std::to_string(arity));
      }
      const bool isOne = rewritten->second == std::set<std::uint16_t>{1};
      std::string comma =
          arityOf(made.type) > *rewritten->second.rbegin() ? decimalCommaHint(text_, made.range) : std::string();
      messages_.warning(
          made.range,
          "no production rewrites '" + foldBlanks(text_.substr(made.range.begin, made.range.end - made.range.begin)) +
              "': the productions of " + std::string(1, character) + " have " + counts +
              (isOne ? " parameter" : " parameters"),
          comma.empty() ? "a production matches only modules with exactly as many parameters" : std::move(comma));
    }
  }

  // ---- commands of the turtle

  std::vector<std::string> checkCommands() {
    std::set<std::string> reported;
    for (const auto& [at, first, second] : commands_) {
      const std::string name = symbolOf(first->type).name;
      const std::string pair = name + (second == nullptr ? std::string() : symbolOf(second->type).name);
      const auto isKnown = [](const std::string& text) { return std::ranges::find(kAfterAt, text) != kAfterAt.end(); };
      const bool beginsPairs = std::ranges::any_of(
          kAfterAt, [&](std::string_view text) { return text.size() == 2 && text.front() == name.front(); });
      const bool isPair = second != nullptr && first->parameters.empty() && beginsPairs;
      // what a production rewrites may become a command
      if (isKnown(name) || isKnown(pair) || read_.contains(at->type) || read_.contains(first->type) ||
          !reported.insert(isPair ? pair : name).second) {
        continue;
      }
      messages_.warning({at->range.begin, isPair ? second->range.end : first->range.end},
                        "the turtle has no command '@" + (isPair ? pair : name) +
                            "': it interprets the symbols after the '@' on their own",
                        "`espalier reference symbols` lists the commands");
    }
    return {reported.begin(), reported.end()};
  }

  /// A `@` and what stands behind it.
  struct Command {
    const ModuleSyntax* at;
    const ModuleSyntax* first;
    const ModuleSyntax* second;  // null: nothing
  };

  std::string_view text_;
  const ModelSyntax& model_;
  MessageList& messages_;
  std::vector<Made> made_;
  std::vector<Command> commands_;
  std::map<core::SymbolId, std::set<std::uint16_t>> rewritten_;  // numbers of parameters of predecessors
  std::set<core::ModuleTypeId> read_;                            // in a predecessor or context
};

}  // namespace

std::vector<std::string> checkModules(std::string_view text, const ModelSyntax& model, MessageList& messages) {
  return ModuleChecks(text, model, messages).run();
}

}  // namespace espalier::language
