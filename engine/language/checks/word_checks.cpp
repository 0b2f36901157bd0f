#include "engine/language/checks/word_checks.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace espalier::language {
namespace {

struct Letter {
  char character = '\0';  // '\0': a declared name
  bool hasParameters = false;
  core::SourceRange range;
  std::vector<std::string> names;  // formal parameters
};

/// A run of letters that looks like one name: a capital and at least two small letters without a gap, or at least four
/// small letters.
struct Word {
  std::string text;
  core::SourceRange range;
  bool hasParameters = false;
  bool isQuery = false;                 // stands behind '?'
  bool isPredecessor = false;           // is the whole predecessor of a production
  std::vector<std::string> parameters;  // names, of a predecessor
  std::size_t count = 1;
};

class WordFinder {
 public:
  explicit WordFinder(const ModelSyntax& model) : model_(model) {
    for (const LSystemSyntax& system : model.systems) {
      addModules(system.axiom);
      for (const ProductionListSyntax* list : {&system.productions, &system.decomposition, &system.homomorphism}) {
        for (const ProductionSyntax& production : list->productions) {
          if (!production.isLabelled) {
            addFormals(production.predecessor);
          }
          addModules(production.successor);
        }
      }
    }
  }

  /// The words that look like names, each once.
  [[nodiscard]] std::vector<Word> names() const {
    std::vector<Word> result;
    std::copy_if(words_.begin(), words_.end(), std::back_inserter(result), [&](const Word& word) {
      // a letter with its own productions is a module, and a row of moves is not a word
      const bool hasModules =
          std::any_of(word.text.begin(), word.text.end(), [&](char c) { return single_.contains(c); });
      const bool isMoves = word.text.find_first_not_of("fg", 1) == std::string::npos;
      const bool isSmall = word.text.front() >= 'a';
      return !hasModules && !isMoves &&
             (isSmall ? word.isPredecessor : word.hasParameters || (word.isPredecessor && word.count > 1));
    });
    return result;
  }

 private:
  [[nodiscard]] char characterOf(core::ModuleTypeId type) const {
    return model_.symbols[model_.symbols.types()[type].symbol].character();
  }
  void addModules(const std::vector<ModuleSyntax>& modules) {
    std::vector<Letter> letters;
    for (const ModuleSyntax& module : modules) {
      letters.push_back({characterOf(module.type), !module.parameters.empty(), module.range, {}});
    }
    addLetters(letters, false);
  }
  void addFormals(const std::vector<FormalModuleSyntax>& modules) {
    std::vector<Letter> letters;
    for (const FormalModuleSyntax& module : modules) {
      Letter& letter =
          letters.emplace_back(Letter{characterOf(module.type), !module.parameters.empty(), module.range, {}});
      for (const NameSyntax& parameter : module.parameters) {
        letter.names.push_back(parameter.text);
      }
    }
    if (letters.size() == 1) {
      single_.insert(letters.front().character);
    }
    addLetters(letters, true);
  }

  void addLetters(const std::vector<Letter>& letters, bool isPredecessor) {
    std::size_t i = 0;
    while (i < letters.size()) {
      const std::size_t begin = i;
      const bool isCapital = letters[i].character >= 'A' && letters[i].character <= 'Z' && !letters[i].hasParameters;
      const bool isSmall = letters[i].character >= 'a' && letters[i].character <= 'z' && !letters[i].hasParameters;
      const bool isCommand = begin > 0 && letters[begin - 1].character == '@';
      ++i;
      while ((isCapital || isSmall) && i < letters.size() && letters[i].character >= 'a' &&
             letters[i].character <= 'z' && letters[i].range.begin == letters[i - 1].range.end &&
             !letters[i - 1].hasParameters) {
        ++i;
      }
      const bool isQuery = begin > 0 && letters[begin - 1].character == '?' && !letters[begin - 1].hasParameters;
      if (i - begin >= (isSmall ? 4U : isQuery ? 2U : 3U) && !isCommand) {
        add(letters, begin, i, isPredecessor && i - begin == letters.size(), isQuery);
      }
    }
  }

  void add(const std::vector<Letter>& letters, std::size_t begin, std::size_t end, bool isPredecessor, bool isQuery) {
    Word word;
    word.isQuery = isQuery;
    for (std::size_t i = begin; i < end; ++i) {
      word.text.push_back(letters[i].character);
    }
    const auto known =
        std::find_if(words_.begin(), words_.end(), [&](const Word& other) { return other.text == word.text; });
    if (known != words_.end()) {
      ++known->count;
      known->hasParameters = known->hasParameters || letters[end - 1].hasParameters;
      known->isPredecessor = known->isPredecessor || isPredecessor;
      known->isQuery = known->isQuery || isQuery;
      if (known->parameters.empty()) {
        known->parameters = letters[end - 1].names;
      }
      return;
    }
    word.range = {letters[begin].range.begin, letters[end - 1].range.end};
    word.hasParameters = letters[end - 1].hasParameters;
    word.isPredecessor = isPredecessor;
    word.parameters = letters[end - 1].names;
    words_.push_back(std::move(word));
  }

  const ModelSyntax& model_;
  std::vector<Word> words_;
  std::set<char> single_;  // characters that are whole predecessors
};

std::string declarationOf(const Word& word) {
  std::string text = (word.isQuery ? "?" : "") + word.text;
  for (std::size_t i = 0; i < word.parameters.size(); ++i) {
    text += (i == 0 ? "(" : ", ") + word.parameters[i];
  }
  return text + (word.parameters.empty() ? (word.hasParameters ? (word.isQuery ? "(v)" : "(x)") : "") : ")");
}

}  // namespace

bool checkWords(std::string_view text, const ModelSyntax& model, MessageList& messages) {
  const std::vector<Word> words = WordFinder(model).names();
  if (words.empty()) {
    return false;
  }
  std::vector<std::string_view> declared;
  for (const Symbol& symbol : model.symbols.symbols()) {
    if (symbol.isDeclared) {
      declared.push_back(symbol.name);
    }
  }
  // one message for all new words, with the declaration that makes them names
  std::string declaration;
  for (const Word& word : words) {
    if (core::nearestName(word.text, declared).empty()) {
      declaration += (declaration.empty() ? "" : ", ") + declarationOf(word);
    }
  }
  bool isFirst = true;
  for (const Word& word : words) {
    const std::string_view near = core::nearestName(word.text, declared);
    if (near.empty() && !isFirst) {
      continue;
    }
    isFirst = isFirst && !near.empty();
    std::string letters;
    for (std::size_t i = 0; i + 1 < word.text.size(); ++i) {
      letters += std::string(i == 0 ? "" : ", ") + word.text[i];
    }
    // the last letter has the parameters
    const std::string_view last =
        text.substr(word.range.begin + word.text.size() - 1, word.range.end - word.range.begin - word.text.size() + 1);
    messages.warning(word.range,
                     "'" + word.text + "' is read as " + std::to_string(word.text.size()) + " modules: " + letters +
                         " and " + foldBlanks(last),
                     near.empty() ? "to make it a name, write a line before the L-system: 'Module: " + declaration + "'"
                                  : "did you mean '" + std::string(near) + "'?");
  }
  return true;
}

}  // namespace espalier::language
