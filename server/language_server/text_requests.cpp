// The requests about a whole document: completion, formatting, symbols, semantic tokens, code lenses.

#include <algorithm>
#include <array>
#include <set>
#include <string_view>
#include <utility>

#include "engine/core/work_meter.h"
#include "engine/language/format/formatter.h"
#include "engine/language/preprocess/macro_table.h"
#include "server/language_server/handbook_rows.h"
#include "server/language_server/language_session.h"

namespace espalier::server {
namespace {

using Json = nlohmann::json;
using language::NameKind;
using language::NameUse;

constexpr int kFormattingRefused = -32803;  // RequestFailed of the protocol

/// The words that begin an item or a section.
constexpr std::array<std::string_view, 18> kSectionWords{
    "Lsystem:",      "seed:",   "derivation length:", "maximum depth:", "consider:", "ignore:",        "define:",
    "Axiom:",        "Start:",  "StartEach:",         "EndEach:",       "End:",      "decomposition:", "Module:",
    "homomorphism:", "Syntax:", "warnings",           "endlsystem"};

constexpr std::array kFunctionNames{
#define ESPALIER_FUNCTION(name, text, least, most, isPure, usage, meaning) std::string_view(text),
#define ESPALIER_SPECIAL_FUNCTION(callee, text, usage, meaning) std::string_view(text),
#include "engine/language/function.def"
};

// numbers of CompletionItemKind and SymbolKind
constexpr int kFunctionItem = 3;
constexpr int kVariableItem = 6;
constexpr int kClassItem = 7;
constexpr int kKeywordItem = 14;
constexpr int kConstantItem = 21;
constexpr int kConstantSymbol = 14;
constexpr int kClassSymbol = 5;

enum class TokenType : std::uint8_t { Comment, String, Number, Keyword, Macro, Variable, Parameter, Function, Module };

struct Token {
  std::size_t offset = 0;
  std::size_t length = 0;
  TokenType type = TokenType::Comment;
};

TokenType typeOf(NameKind kind) {
  switch (kind) {
    case NameKind::Macro:
      return TokenType::Macro;
    case NameKind::Parameter:
      return TokenType::Parameter;
    case NameKind::Function:
      return TokenType::Function;
    case NameKind::Module:
      return TokenType::Module;
    default:
      return TokenType::Variable;
  }
}

// the length of a section's word at the beginning of a line; 0: there is none
std::size_t sectionWordLength(std::string_view line) {
  for (const std::string_view word : kSectionWords) {
    const bool isThere =
        line.size() >= word.size() && std::equal(word.begin(), word.end(), line.begin(), [](char a, char b) {
          return (a | 0x20) == (b | 0x20);  // in any letter case
        });
    if (isThere) {
      return word.size();
    }
  }
  return 0;
}

/// The comments, strings, numbers, directives and words of sections of a text, without the places that are taken.
class TextTokens {
 public:
  TextTokens(std::string_view text, std::vector<Token> names) : text_(text), tokens_(std::move(names)) {
    std::sort(tokens_.begin(), tokens_.end(), [](const Token& a, const Token& b) { return a.offset < b.offset; });
    nameCount_ = tokens_.size();
  }

  std::vector<Token> collect() {
    for (std::size_t at = 0; at < text_.size();) {
      core::pollWork();
      at = std::max(next(at), at + 1);
    }
    std::sort(tokens_.begin(), tokens_.end(), [](const Token& a, const Token& b) { return a.offset < b.offset; });
    return std::move(tokens_);
  }

 private:
  // reads what begins at a byte, and returns the byte behind it
  std::size_t next(std::size_t at) {
    while (name_ < nameCount_ && tokens_[name_].offset < at) {
      ++name_;
    }
    if (name_ < nameCount_ && tokens_[name_].offset == at) {
      return at + tokens_[name_].length;
    }
    const std::string_view rest = text_.substr(at);
    if (rest.starts_with("/*")) {
      return add(at, std::min(rest.find("*/", 2), rest.size() - 2) + 2, TokenType::Comment);
    }
    if (rest.starts_with("//")) {
      return add(at, std::min(rest.find('\n'), rest.size()), TokenType::Comment);
    }
    if (rest.front() == '"') {
      return afterQuote(at);
    }
    const bool beginsLine = at == 0 || text_[at - 1] == '\n';
    if (beginsLine && rest.front() == '#') {
      std::size_t end = 1;
      while (end < rest.size() && language::isBlank(rest[end])) {
        ++end;
      }
      return add(at, language::wordEnd(rest, end), TokenType::Keyword);
    }
    if (const std::size_t length = beginsLine ? sectionWordLength(rest) : 0; length > 0) {
      return add(at, length, TokenType::Keyword);
    }
    if (language::isDigit(rest.front()) || (rest.front() == '.' && rest.size() > 1 && language::isDigit(rest[1]))) {
      const std::size_t end = std::min(rest.find_first_not_of("0123456789."), rest.size());
      return add(at, end, TokenType::Number);
    }
    return language::isIdentifierStart(rest.front()) ? at + language::wordEnd(rest, 0) : at + 1;
  }

  // Each line is searched once for its end, and once for a string that has none: where one quote has no partner, those
  // behind it have none either.
  std::size_t afterQuote(std::size_t at) {
    if (at >= lineEnd_) {
      lineEnd_ = std::min(text_.find('\n', at), text_.size());
      isQuoteOpen_ = false;
    }
    if (isQuoteOpen_) {
      return at + 1;
    }
    const std::size_t end = language::stringLiteralEnd(text_.substr(at, lineEnd_ - at), 0);
    isQuoteOpen_ = end == 0;
    return isQuoteOpen_ ? at + 1 : add(at, end, TokenType::String);
  }

  std::size_t add(std::size_t offset, std::size_t length, TokenType type) {
    tokens_.push_back({offset, length, type});
    return offset + length;
  }

  std::string_view text_;
  std::vector<Token> tokens_;  // the names first
  std::size_t nameCount_ = 0;
  std::size_t name_ = 0;      // the first that does not lie before the place that is read
  std::size_t lineEnd_ = 0;   // of the last line that had a quote
  bool isQuoteOpen_ = false;  // that line has a quote without a partner
};

/// The lines of a text without their ends.
std::vector<std::string_view> linesOf(std::string_view text) {
  std::vector<std::string_view> lines;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = text.substr(begin, end - begin);
    if (line.ends_with('\r')) {
      line.remove_suffix(1);
    }
    lines.push_back(line);
    begin = end + 1;
  }
  return lines;
}

/// The line of the text as it is now where the run's line stands: the nearest equal one. Nothing: it was edited.
std::optional<std::size_t> presentLine(const std::vector<std::string_view>& lines, const core::SourceLocation& place) {
  const std::size_t before = std::max<std::size_t>(place.line, 1) - 1;
  for (std::size_t away = 0; away < lines.size() + before; ++away) {
    core::pollWork();
    for (const std::size_t line : {before - std::min(away, before), before + away}) {
      if (line < lines.size() && lines[line] == place.lineText) {
        return line;
      }
    }
  }
  return std::nullopt;
}

std::string lensTitle(const RunCounts& run, const RunCounts::Production& production) {
  const auto counted = [](std::uint64_t count, const std::string& unit) {
    return std::to_string(count) + " " + unit + (count == 1 ? "" : "s");
  };
  std::string title = production.total == 0
                          ? "never applied in " + counted(run.step - run.since, "step")
                          : "applied " + counted(production.total, "time") + ", " + std::to_string(production.last) +
                                " in step " + std::to_string(run.step);
  return run.since == 0 ? title : title + ", counted since step " + std::to_string(run.since);
}

Json itemOf(const std::string& label, int kind, std::optional<std::string> documentation = std::nullopt) {
  Json item{{"label", label}, {"kind", kind}};
  if (documentation) {
    item["documentation"] = {{"kind", "markdown"}, {"value", *documentation}};
  }
  return item;
}

}  // namespace

Json semanticTokenTypes() {
  return {"comment", "string", "number", "keyword", "macro", "variable", "parameter", "function", "class"};
}

Json LanguageSession::completion(const Json& parameters) {
  const auto place = placeOf(parameters);
  Json items = Json::array();
  if (!place) {
    return items;
  }
  // the production at the place is the one whose parameters stand last before it
  std::optional<std::uint32_t> production;
  for (const NameUse& use : place->analysis->names) {
    if (use.kind == NameKind::Parameter && use.file == place->file && use.offset < place->offset) {
      production = use.scope;
    }
  }
  std::set<std::string> known;
  for (const NameUse& use : place->analysis->names) {
    core::pollWork();
    const bool isHere = use.kind != NameKind::Parameter || use.scope == production;
    const bool isWanted = use.kind != NameKind::Unknown && use.kind != NameKind::Function &&
                          (use.kind != NameKind::Module || use.isDeclared);
    if (isHere && isWanted && known.insert(use.name).second) {
      const int kind = use.kind == NameKind::Macro    ? kConstantItem
                       : use.kind == NameKind::Module ? kClassItem
                                                      : kVariableItem;
      items.push_back(itemOf(use.name, kind));
    }
  }
  for (const std::string_view name : kFunctionNames) {
    items.push_back(itemOf(std::string(name), kFunctionItem, handbookFunction(name)));
  }
  for (const std::string_view word : kSectionWords) {
    items.push_back(itemOf(std::string(word), kKeywordItem));
  }
  return items;
}

Json LanguageSession::formatting(const Json& parameters, std::optional<Failure>& failure) {
  const OpenDocument* document = documents_.find(parameters.at("textDocument").at("uri").get<std::string>());
  if (document == nullptr || !isModelFile(document->path) || analysisOf(document->path)->isForeign) {
    failure = Failure{kFormattingRefused, "only models of cpfg (.l) can be laid out"};
    return nullptr;
  }
  language::CompileInput input;
  input.modelFile = document->path;
  const language::FormatResult result = language::format(input, documents_);
  if (!result.isCompiled) {
    failure = Failure{kFormattingRefused, "the model has errors: correct them, then lay it out"};
    return nullptr;
  }
  Json edits = Json::array();
  if (result.text != document->text) {
    edits.push_back(
        {{"range", rangeOf(LineIndex(document->text), 0, document->text.size())}, {"newText", result.text}});
  }
  return edits;
}

Json LanguageSession::symbols(const Json& parameters) {
  const auto place = placeOf(parameters);
  Json symbols = Json::array();
  if (!place) {
    return symbols;
  }
  const std::string& text = place->text();
  const auto add = [&](const std::string& name, int kind, std::size_t offset, std::size_t length) {
    const std::size_t lineEnd = std::min(text.find('\n', offset), text.size());
    symbols.push_back({{"name", name},
                       {"kind", kind},
                       {"range", rangeOf(place->lines(), offset, lineEnd - offset)},
                       {"selectionRange", rangeOf(place->lines(), offset, length)}});
  };
  for (const language::MacroDefinition& macro : place->analysis->macros) {
    if (macro.file == place->file) {
      add(macro.name, kConstantSymbol, macro.offset, macro.name.size());
    }
  }
  std::size_t lineEnd = 0;  // of the production before
  for (const NameUse& use : place->analysis->names) {
    const bool isProduction = use.kind == NameKind::Module && use.isDefinition && !use.isExpanded;
    if (isProduction && use.file == place->file && use.offset >= lineEnd) {
      lineEnd = std::min(text.find('\n', use.offset), text.size());
      const std::string line = text.substr(use.offset, lineEnd - use.offset);
      std::string head = line.substr(0, std::min({line.find("-->"), line.find("-o>"), line.size()}));
      head.erase(head.find_last_not_of(" \t\r") + 1);
      add(head, kClassSymbol, use.offset, use.length);
    }
  }
  return symbols;
}

Json LanguageSession::codeLenses(const Json& parameters, const OpenRun& openRun) {
  const OpenDocument* document = documents_.find(parameters.at("textDocument").at("uri").get<std::string>());
  Json lenses = Json::array();
  const std::optional<RunCounts> run = document != nullptr && openRun ? openRun() : std::nullopt;
  if (!run || run->step == run->since) {
    return lenses;
  }
  // a run knows the files of its model by their names alone
  const auto nameOf = [](const std::string& path) { return path.substr(path.find_last_of('/') + 1); };
  const std::vector<std::string_view> lines = linesOf(document->text);
  for (const RunCounts::Production& production : run->productions) {
    const bool isHere = nameOf(production.place.file) == nameOf(document->path);
    const auto line = isHere ? presentLine(lines, production.place) : std::nullopt;
    if (line) {
      const std::string text(lines[*line]);
      const auto end = static_cast<std::uint32_t>(text.size());
      const std::uint32_t begin = std::min(std::max(production.place.column, 1U) - 1, end);
      lenses.push_back({{"range",
                         {{"start", {{"line", *line}, {"character", columnAt(text, begin, unit_)}}},
                          {"end", {{"line", *line}, {"character", columnAt(text, end, unit_)}}}}},
                        {"command", {{"title", lensTitle(*run, production)}, {"command", ""}}}});
    }
  }
  return lenses;
}

Json LanguageSession::semanticTokens(const Json& parameters) {
  const auto place = placeOf(parameters);
  if (!place) {
    return {{"data", Json::array()}};
  }
  const std::string& text = place->text();
  std::vector<Token> names;
  for (const NameUse& use : place->analysis->names) {
    const bool isFree = names.empty() || names.back().offset + names.back().length <= use.offset;
    if (use.file == place->file && !use.isExpanded && isFree) {
      names.push_back({use.offset, use.length, typeOf(use.kind)});
    }
  }
  Json data = Json::array();
  EditorPosition before;
  for (const Token& token : TextTokens(text, std::move(names)).collect()) {
    core::pollWork();
    // a comment over several lines is a token for each line
    const std::string_view whole = std::string_view(text).substr(token.offset, token.length);
    for (std::size_t begin = 0; begin < whole.size();) {
      const std::size_t end = std::min(whole.find('\n', begin), whole.size());
      const EditorPosition first = place->lines().positionAt(token.offset + begin, unit_);
      const std::uint32_t behind = place->lines().positionAt(token.offset + end, unit_).column;
      if (behind > first.column) {
        const std::uint32_t column = first.line == before.line ? first.column - before.column : first.column;
        data.insert(data.end(),
                    {first.line - before.line, column, behind - first.column, static_cast<int>(token.type), 0});
        before = first;
      }
      begin = end + 1;
    }
  }
  return {{"data", std::move(data)}};
}

}  // namespace espalier::server
