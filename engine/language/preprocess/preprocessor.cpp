#include "engine/language/preprocess/preprocessor.h"

#include <algorithm>
#include <deque>
#include <map>

#include "engine/core/work_meter.h"
#include "engine/files/file_name.h"
#include "engine/files/utf8.h"
#include "engine/language/preprocess/directive_expression.h"
#include "engine/language/preprocess/line_reader.h"
#include "engine/language/preprocess/macro_table.h"

namespace espalier::language {
namespace {

/// An open #if.
struct Conditional {
  std::uint32_t offset = 0;
  bool wasActive = true;  // the lines around it are active
  bool hasTaken = false;  // one of its branches was active already
  bool isActive = true;
  bool hasElse = false;
};

class Preprocessor {
 public:
  Preprocessor(const PreprocessInput& input, core::FileProvider& provider)
      : input_(input), provider_(provider), macros_(input.limits) {}

  PreprocessResult run() {
    for (const auto& [name, value] : input_.macros) {
      defineFromCaller(name, value, false);
    }
    for (const auto& [name, value] : input_.overrides) {
      defineFromCaller(name, value, true);
    }
    const std::optional<std::uint32_t> file = open(input_.file);
    if (file.has_value()) {
      processFile(*file, 0);
    } else {
      result_.diagnostics.add({core::Severity::Error,
                               "cannot read the file '" + input_.file + "'",
                               {},
                               "check the name and that the file may be read"});
    }
    if (file.has_value() && !hasStopped_) {
      checkOverrides();
    }
    result_.macros = macros_.names();
    result_.isComplete = file.has_value() && !hasStopped_;
    result_.sourceMap.files.assign(std::make_move_iterator(files_.begin()), std::make_move_iterator(files_.end()));
    return std::move(result_);
  }

 private:
  void defineFromCaller(const std::string& name, const std::string& value, bool isFixed) {
    if (wordEnd(name, 0) != name.size() || name.empty() || !isWordStart(name.front())) {
      result_.diagnostics.add({isFixed ? core::Severity::Error : core::Severity::Warning,
                               "'" + name + "' cannot be defined: it is not a macro name",
                               {},
                               "a name consists of letters, digits, '_' and '$', and does not start with a digit"});
      return;
    }
    Macro macro;
    macro.name = name;
    macro.body = value;
    macro.isFixed = isFixed;
    macros_.define(std::move(macro));
  }

  /// An override that no file names has no effect: a misspelt name.
  void checkOverrides() {
    for (const auto& [name, value] : input_.overrides) {
      const auto isNamed = [&name = name](const files::SourceMap::File& file) { return namesMacro(file.text, name); };
      const bool isFunction = std::any_of(input_.macros.begin(), input_.macros.end(),
                                          [&name = name](const auto& macro) { return macro.first == name; });
      if (wordEnd(name, 0) != name.size() || isFunction || std::any_of(files_.begin(), files_.end(), isNamed)) {
        continue;
      }
      const std::vector<std::string> macros = macroNames();
      const std::vector<std::string_view> names(macros.begin(), macros.end());
      result_.diagnostics.add({core::Severity::Error,
                               "the model does not use the macro '" + name + "', so its value has no effect",
                               {},
                               names.empty() ? "the model has no macros: write '#define " + name + " 1' in it"
                                             : core::suggestName(name, names)});
    }
  }

  static bool namesMacro(std::string_view text, std::string_view name) {
    for (std::size_t at = text.find(name); at != std::string_view::npos; at = text.find(name, at + 1)) {
      const bool beginsWord = at == 0 || !isIdentifierPart(text[at - 1]);
      if (beginsWord && (at + name.size() == text.size() || !isIdentifierPart(text[at + name.size()]))) {
        return true;
      }
    }
    return false;
  }

  /// The names in the directives of all files, also of those that a condition leaves out.
  [[nodiscard]] std::vector<std::string> macroNames() const {
    std::vector<std::string> names;
    for (const files::SourceMap::File& file : files_) {
      for (std::size_t at = 0; at < file.text.size();
           at = std::min(file.text.find('\n', at), file.text.size() - 1) + 1) {
        std::string_view line = std::string_view(file.text).substr(at);
        if (!line.starts_with('#')) {
          continue;
        }
        line = trimBlanks(line.substr(1, line.find('\n') - 1));
        const std::size_t end = wordEnd(line, 0);
        const std::string_view directive = line.substr(0, end);
        const std::string_view rest = trimBlanks(line.substr(end));
        const std::string_view name = rest.substr(0, wordEnd(rest, 0));
        const bool isNaming = directive == "define" || directive == "ifdef" || directive == "ifndef";
        if (isNaming && !name.empty() && std::find(names.begin(), names.end(), name) == names.end()) {
          names.emplace_back(name);
        }
      }
    }
    return names;
  }

  // ---- files

  std::optional<std::uint32_t> open(const std::string& name) {
    const auto known = fileIndices_.find(name);
    if (known != fileIndices_.end()) {
      return known->second;
    }
    std::optional<std::string> text = provider_.read(name);
    if (!text.has_value()) {
      return std::nullopt;
    }
    const auto index = static_cast<std::uint32_t>(files_.size());
    files_.push_back({name, files::readableText(*text)});
    fileIndices_.emplace(name, index);
    return index;
  }

  void processFile(std::uint32_t file, std::uint32_t depth) {
    const std::string& text = files_[file].text;
    readBytes_ += text.size();
    macros_.addText(text.size());
    if (readBytes_ > input_.limits.maximumSourceBytes) {
      fatal(file, 0, 1,
            "the files of the model are longer than the limit sourceBytes (" +
                std::to_string(input_.limits.maximumSourceBytes) + " bytes)");
      return;
    }
    openFiles_.push_back(files_[file].name);
    const std::size_t outerConditionals = conditionals_.size();
    LineReader reader(text);
    LogicalLine line;
    while (!hasStopped_ && reader.next(line)) {
      core::pollWork();
      if (!line.startsInComment && line.text.starts_with('#')) {
        directive(file, depth, line, outerConditionals);
      } else if (isActive()) {
        warnAboutRolls(file, line, reader.commentBegin());
        joinCall(reader, line);
        emitLine(file, line);
        if (reader.isInComment()) {
          result_.commentNewlines.push_back(static_cast<std::uint32_t>(result_.text.size() - 1));
        }
      }
    }
    if (reader.isInComment()) {
      result_.hasLostText = true;
      error(file, static_cast<std::uint32_t>(reader.commentBegin()), 2,
            "expected '*/' while reading a comment, found the end of the file",
            "the rest of the file is part of the comment");
    }
    while (conditionals_.size() > outerConditionals) {
      error(file, conditionals_.back().offset, 1,
            "expected #endif while reading this conditional, found the end of the file",
            "every #if, #ifdef and #ifndef ends with #endif");
      conditionals_.pop_back();
    }
    openFiles_.pop_back();
    // the text of the including file starts on a line of its own
    if (!result_.text.empty() && result_.text.back() != '\n') {
      emit('\n', file, static_cast<std::uint32_t>(text.size()), files::SourceMap::kNoExpansion);
    }
  }

  /// Joins the lines behind `line` over which a macro call goes on. A call that does not end, or that a directive
  /// interrupts, is left as it is.
  void joinCall(LineReader& reader, LogicalLine& line) const {
    constexpr int kMostLines = 100;  // of one call
    if (!macros_.hasOpenCall(line.text)) {
      return;
    }
    LineReader ahead = reader;
    LogicalLine joined = line;
    LogicalLine next;
    for (int i = 0; i < kMostLines && ahead.next(next) && !next.text.starts_with('#'); ++i) {
      joined.add(' ', joined.end);
      joined.text += next.text;
      joined.offsets.insert(joined.offsets.end(), next.offsets.begin(), next.offsets.end());
      joined.end = next.end;
      if (!macros_.hasOpenCall(joined.text)) {
        line = std::move(joined);
        reader = ahead;
        return;
      }
    }
  }

  // ---- output

  void emit(char c, std::uint32_t file, std::uint32_t offset, std::uint32_t expansion) {
    const auto position = static_cast<std::uint32_t>(result_.text.size());
    if (position >= input_.limits.maximumSourceBytes) {
      fatal(file, offset, 1,
            "the preprocessed text is longer than the limit sourceBytes (" +
                std::to_string(input_.limits.maximumSourceBytes) + " bytes)");
      return;
    }
    std::vector<files::SourceMap::Segment>& segments = result_.sourceMap.segments;
    const bool continues = !segments.empty() && segments.back().file == file &&
                           segments.back().expansion == expansion &&
                           (expansion != files::SourceMap::kNoExpansion ||
                            segments.back().fileOffset + (position - segments.back().outputBegin) == offset);
    if (!continues) {
      segments.push_back({position, file, offset, expansion});
    }
    result_.text.push_back(c);
  }

  void emitLine(std::uint32_t file, const LogicalLine& line) {
    const auto problem = [&](const ExpansionProblem& found) { reportExpansion(file, line, found); };
    for (const ExpandedPiece& piece : macros_.expand(line.text, problem)) {
      if (piece.macro == nullptr) {
        for (std::size_t i = piece.begin; i < piece.end && !hasStopped_; ++i) {
          emit(line.text[i], file, line.offsets[i], files::SourceMap::kNoExpansion);
        }
      } else if (!piece.text.empty()) {
        const std::uint32_t use = line.offsets[piece.begin];
        const auto expansion = static_cast<std::uint32_t>(result_.sourceMap.expansions.size());
        result_.sourceMap.expansions.push_back(
            {piece.macro->name, piece.macro->file, piece.macro->offset, line.offsets[piece.end - 1] + 1 - use});
        for (std::size_t i = 0; i < piece.text.size() && !hasStopped_; ++i) {
          emit(piece.text[i], file, use, expansion);
        }
      }
    }
    if (!hasStopped_) {
      emit('\n', file, line.end, files::SourceMap::kNoExpansion);
    }
  }

  // ---- messages

  static bool isHeaderOfC(std::string_view name) {
    const std::string_view file = name.substr(name.rfind('/') + 1);
    return file == "math.h" || file == "stdio.h" || file == "stdlib.h";
  }

  /// Warns when the comment at `begin` is rather `//` among the modules of the line, as in `S/////F` or `[A]//[A]`.
  void warnAboutRolls(std::uint32_t file, const LogicalLine& line, std::size_t begin) {
    const std::string_view text = files_[file].text;
    if (line.offsets.empty() || begin <= line.offsets.front() || begin >= line.end || text[begin + 1] != '/' ||
        isBlank(text[begin - 1]) ||
        (line.text.find("-->") == std::string::npos && line.text.find("xiom:") == std::string::npos)) {
      return;
    }
    const std::string_view comment = text.substr(begin + 2, line.end - begin - 2);
    const std::string_view rest = comment.substr(std::min(comment.find_first_not_of('/'), comment.size()));
    const bool isModules = comment.starts_with('/') && !rest.empty() && rest.find_first_of(" \t") == std::string::npos;
    const bool isProse = comment.find_first_of(" \t") != std::string_view::npos;
    if (isModules || (!isProse && comment.find_first_of("[]") != std::string_view::npos)) {
      add(core::Severity::Warning, file, static_cast<std::uint32_t>(begin), line.end - begin,
          "'//' begins a comment, so the rest of this line is not read",
          "put a blank between two roll symbols, as in / / /, or write one roll with its angle, as in /(90)");
    }
  }

  void add(core::Severity severity, std::uint32_t file, std::uint32_t offset, std::size_t length, std::string message,
           std::string hint) {
    // finding a place takes a walk through its file; beyond its limit the list only counts
    const std::size_t count =
        severity == core::Severity::Error ? result_.diagnostics.errorCount() : result_.diagnostics.warningCount();
    if (count >= core::DiagnosticList::kLimit) {
      result_.diagnostics.add({severity, {}, {}, {}});
      return;
    }
    result_.diagnostics.add({severity, std::move(message),
                             files::locateInFile(files_[file], offset, static_cast<std::uint32_t>(length)),
                             std::move(hint)});
  }
  void error(std::uint32_t file, std::uint32_t offset, std::size_t length, std::string message, std::string hint) {
    add(core::Severity::Error, file, offset, length, std::move(message), std::move(hint));
  }
  void fatal(std::uint32_t file, std::uint32_t offset, std::size_t length, std::string message, std::string hint = {}) {
    if (!hasStopped_) {
      error(file, offset, length, std::move(message), std::move(hint));
    }
    hasStopped_ = true;
  }
  void reportExpansion(std::uint32_t file, const LogicalLine& line, const ExpansionProblem& found) {
    const std::uint32_t begin = line.offsetOf(found.begin);
    const std::size_t length = found.end - found.begin;
    if (found.isFatal) {
      fatal(file, begin, length, found.message, found.hint);
    } else {
      error(file, begin, length, found.message, found.hint);
    }
  }

  // ---- directives

  [[nodiscard]] bool isActive() const { return conditionals_.empty() || conditionals_.back().isActive; }

  void directive(std::uint32_t file, std::uint32_t depth, const LogicalLine& line, std::size_t outerConditionals) {
    std::size_t begin = 1;
    while (begin < line.text.size() && isBlank(line.text[begin])) {
      ++begin;
    }
    const std::size_t end = wordEnd(line.text, begin);
    const std::string name = line.text.substr(begin, end - begin);
    if (name == "if" || name == "ifdef" || name == "ifndef") {
      openConditional(file, line, name, end);
    } else if (name == "elif" || name == "else" || name == "endif") {
      if (conditionals_.size() == outerConditionals) {
        error(file, line.offsetOf(0), end, "#" + name + " without #if", "");
      } else {
        continueConditional(file, line, name, end);
      }
    } else if (!isActive()) {
      return;
    } else if (name == "define") {
      define(file, line, end);
    } else if (name == "undef") {
      undefine(file, line, end);
    } else if (name == "include") {
      include(file, depth, line, end);
    } else if (name == "error" || name == "warning") {
      add(name == "error" ? core::Severity::Error : core::Severity::Warning, file, line.offsetOf(0), end,
          "#" + name + " " + std::string(trimBlanks(std::string_view(line.text).substr(end))), "");
    } else if (name.empty() ? !isNullDirective(line, begin) : !isIgnoredDirective(name)) {
      unknownDirective(file, line, name, std::max(end, begin + 1));
    }
  }

  static bool isNullDirective(const LogicalLine& line, std::size_t begin) { return begin >= line.text.size(); }

  // #line, # 12 "file", #pragma and #ident have no effect
  static bool isIgnoredDirective(const std::string& name) {
    return name == "line" || name == "pragma" || name == "ident" || isDigit(name.front());
  }

  void unknownDirective(std::uint32_t file, const LogicalLine& line, const std::string& name, std::size_t length) {
    static const std::vector<std::string_view> kNames{"define", "undef", "include", "if",    "ifdef", "ifndef",
                                                      "elif",   "else",  "endif",   "error", "line",  "pragma"};
    std::string small(name);
    std::ranges::transform(small, small.begin(),
                           [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    const std::string_view near = core::nearestName(small, kNames);
    error(file, line.offsetOf(0), length,
          "expected a directive after '#', found '" + line.text.substr(1, std::max<std::size_t>(length, 2) - 1) + "'",
          !name.empty() && !near.empty() ? "did you mean '#" + std::string(near) + "'?"
          : !name.empty() && line.text.find("-->") == std::string::npos
              ? "a comment is written as /* ... */ or behind //"
              : "a '#' in column 1 starts a directive; for the symbol '#' put something before it, as in "
                "'* < #(w) --> *'");
  }

  void openConditional(std::uint32_t file, const LogicalLine& line, const std::string& name, std::size_t end) {
    Conditional conditional;
    conditional.offset = line.offsetOf(0);
    conditional.wasActive = isActive();
    bool isTaken = false;
    if (conditional.wasActive) {
      isTaken = name == "if" ? condition(file, line, end) : isDefinedName(file, line, name, end) == (name == "ifdef");
    }
    conditional.isActive = conditional.wasActive && isTaken;
    conditional.hasTaken = conditional.isActive;
    conditionals_.push_back(conditional);
  }

  void continueConditional(std::uint32_t file, const LogicalLine& line, const std::string& name, std::size_t end) {
    Conditional& conditional = conditionals_.back();
    if (name == "endif") {
      conditionals_.pop_back();
      return;
    }
    if (conditional.hasElse) {
      error(file, line.offsetOf(0), end, "#" + name + " after #else", "");
      return;
    }
    conditional.hasElse = name == "else";
    const bool mayTake = conditional.wasActive && !conditional.hasTaken;
    conditional.isActive = mayTake && (name == "else" || condition(file, line, end));
    conditional.hasTaken = conditional.hasTaken || conditional.isActive;
  }

  // the macro name after a directive; empty with an error when there is none
  std::string readName(std::uint32_t file, const LogicalLine& line, const std::string& directive,
                       std::size_t& position) {
    while (position < line.text.size() && isBlank(line.text[position])) {
      ++position;
    }
    const std::size_t begin = position;
    position = wordEnd(line.text, begin);
    if (position == begin || !isWordStart(line.text[begin])) {
      const bool isAtEnd = begin >= line.text.size();
      error(file, line.offsetOf(begin), 1,
            "expected a name while reading #" + directive + ", found " +
                (isAtEnd ? std::string("the end of the line") : "'" + line.text.substr(begin, 1) + "'"),
            "");
      return {};
    }
    return line.text.substr(begin, position - begin);
  }

  bool isDefinedName(std::uint32_t file, const LogicalLine& line, const std::string& directive, std::size_t position) {
    return macros_.find(readName(file, line, directive, position)) != nullptr;
  }

  bool condition(std::uint32_t file, const LogicalLine& line, std::size_t begin) {
    // `defined` looks at names before they are expanded
    std::string text;
    std::size_t i = begin;
    while (i < line.text.size()) {
      const std::size_t end = std::max(wordEnd(line.text, i), i + 1);
      if (std::string_view(line.text).substr(i, end - i) == "defined") {
        i = end;
        while (i < line.text.size() && (isBlank(line.text[i]) || line.text[i] == '(')) {
          ++i;
        }
        const bool hasParenthesis = line.text.find('(', end) < i;
        const std::string name = readName(file, line, "if defined", i);
        while (hasParenthesis && i < line.text.size() && line.text[i - 1] != ')') {
          ++i;
        }
        text += macros_.find(name) != nullptr ? " 1 " : " 0 ";
      } else {
        text.append(line.text, i, end - i);
        i = end;
      }
    }
    std::string expanded;
    for (const ExpandedPiece& piece : macros_.expand(text, [&](const ExpansionProblem& found) {
           reportExpansion(file, line, {begin, line.text.size(), found.message, found.hint, found.isFatal});
         })) {
      expanded += piece.macro == nullptr ? text.substr(piece.begin, piece.end - piece.begin) : piece.text;
    }
    DirectiveProblem problem;
    const std::optional<std::int64_t> value =
        evaluateDirective(expanded, input_.limits.maximumExpressionDepth, problem);
    if (!value.has_value()) {
      const std::size_t first = line.text.find_first_not_of(" \t", begin);
      error(file, line.offsetOf(first), first == std::string::npos ? 1 : line.text.size() - first, problem.message, "");
    }
    return value.value_or(0) != 0;
  }

  void define(std::uint32_t file, const LogicalLine& line, std::size_t position) {
    Macro macro;
    macro.name = readName(file, line, "define", position);
    if (macro.name.empty()) {
      return;
    }
    macro.file = file;
    macro.offset = line.offsetOf(position - macro.name.size());
    const std::size_t nameLength = macro.name.size();
    if (position < line.text.size() && line.text[position] == '(' && !readParameters(file, line, position, macro)) {
      return;
    }
    macro.body = trimBlanks(std::string_view(line.text).substr(position));
    // a different second definition is probably a mistake
    const Macro* old = macros_.find(macro.name);
    if (old != nullptr && !old->isFixed && old->file != files::SourceMap::kNoExpansion &&
        (old->body != macro.body || old->parameters != macro.parameters)) {
      const core::SourceLocation first = files::locateInFile(files_[old->file], old->offset, 1);
      add(core::Severity::Warning, file, macro.offset, nameLength,
          "the macro '" + macro.name + "' is defined again; from here on this definition counts",
          "first defined at " + first.file + ":" + std::to_string(first.line) +
              "; if this is intended, write #undef before the new definition");
    }
    macros_.define(std::move(macro));
  }

  bool readParameters(std::uint32_t file, const LogicalLine& line, std::size_t& position, Macro& macro) {
    macro.isFunctionLike = true;
    ++position;
    const std::size_t close = line.text.find(')', position);
    if (close == std::string::npos) {
      error(file, line.offsetOf(position - 1), 1,
            "expected ')' while reading the parameters of the macro '" + macro.name + "', found the end of the line",
            "");
      return false;
    }
    if (trimBlanks(std::string_view(line.text).substr(position, close - position)).empty()) {
      position = close + 1;
      return true;
    }
    while (position <= close) {
      const std::size_t end = std::min(line.text.find(',', position), close);
      const std::string name(trimBlanks(std::string_view(line.text).substr(position, end - position)));
      if (name.empty() || !isWordStart(name.front()) || wordEnd(name, 0) != name.size()) {
        error(file, line.offsetOf(position), end - position,
              "expected a parameter name while reading the macro '" + macro.name + "', found '" + name + "'", "");
        return false;
      }
      if (std::find(macro.parameters.begin(), macro.parameters.end(), name) != macro.parameters.end()) {
        error(file, line.offsetOf(position), end - position,
              "the macro '" + macro.name + "' has two parameters named '" + name + "'", "");
        return false;
      }
      macro.parameters.push_back(name);
      position = end + 1;
    }
    return true;
  }

  void undefine(std::uint32_t file, const LogicalLine& line, std::size_t position) {
    macros_.undefine(readName(file, line, "undef", position));
  }

  void include(std::uint32_t file, std::uint32_t depth, const LogicalLine& line, std::size_t position) {
    std::string rest(trimBlanks(std::string_view(line.text).substr(position)));
    const std::size_t first = std::min(line.text.find_first_not_of(" \t", position), line.text.size());
    const bool hasBrackets = rest.starts_with('<');
    const std::size_t close = rest.size() > 1 ? rest.find(hasBrackets ? '>' : '"', 1) : std::string::npos;
    if ((!hasBrackets && !rest.starts_with('"')) || close == std::string::npos) {
      error(file, line.offsetOf(first), std::max<std::size_t>(rest.size(), 1),
            "expected \"file\" or <file> while reading #include, found " +
                (rest.empty() ? std::string("the end of the line") : "'" + rest + "'"),
            rest.starts_with("\xE2\x80") ? "write the straight quote of the keyboard, '\"'"
            : rest.starts_with('"') || hasBrackets || rest.empty()
                ? ""
                : "write the name of the file in quotes: #include \"" + rest + "\"");
      return;
    }
    const std::string name = files::nameBeside(files_[file].name, rest.substr(1, close - 1));
    if (depth + 1 > input_.limits.maximumIncludeDepth) {
      fatal(file, line.offsetOf(first), close + 1,
            "files are included deeper than the limit includeDepth (" +
                std::to_string(input_.limits.maximumIncludeDepth) + ")",
            std::find(openFiles_.begin(), openFiles_.end(), name) != openFiles_.end()
                ? "'" + name + "' includes itself, directly or through another file"
                : "");
      return;
    }
    const std::optional<std::uint32_t> included = open(name);
    if (!included.has_value()) {
      error(file, line.offsetOf(first), close + 1, "cannot read the included file '" + name + "'",
            isHeaderOfC(name) ? "the functions of the language need no file: remove this line"
                              : "an included file is looked for beside the file that includes it");
      return;
    }
    processFile(*included, depth + 1);
  }

  const PreprocessInput& input_;
  core::FileProvider& provider_;
  MacroTable macros_;
  PreprocessResult result_;
  std::deque<files::SourceMap::File> files_;  // stable addresses while files are being read
  std::map<std::string, std::uint32_t> fileIndices_;
  std::vector<Conditional> conditionals_;
  std::vector<std::string> openFiles_;  // being read, each included by the one before
  std::uint64_t readBytes_ = 0;
  bool hasStopped_ = false;  // a limit was reached
};

}  // namespace

PreprocessResult preprocess(const PreprocessInput& input, core::FileProvider& files) {
  return Preprocessor(input, files).run();
}

}  // namespace espalier::language
