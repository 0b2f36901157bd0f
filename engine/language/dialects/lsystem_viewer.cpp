#include "engine/language/dialects/lsystem_viewer.h"

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/language/dialects/text_lines.h"
#include "engine/language/dialects/textbook/textbook_statements.h"

namespace espalier::language {
namespace {

constexpr std::array<std::string_view, 9> kCommands{"generations", "scale", "color", "heading", "origin",
                                                    "step",        "angle", "axiom", "prule"};

struct NamedColour {
  std::string_view name;
  files::PaletteColour colour;
};

// the thirteen names with the values of the web colours; the publication gives no values
constexpr std::array kNamedColours = {
    NamedColour{"red", {255, 0, 0}},
    NamedColour{"blue", {0, 0, 255}},
    NamedColour{"green", {0, 128, 0}},
    NamedColour{"lightblue", {173, 216, 230}},
    NamedColour{"darkgreen", {0, 100, 0}},
    NamedColour{"gold", {255, 215, 0}},
    NamedColour{"yellow", {255, 255, 0}},
    NamedColour{"darkblue", {0, 0, 139}},
    NamedColour{"darkred", {139, 0, 0}},
    NamedColour{"gray", {128, 128, 128}},
    NamedColour{"lightgreen", {144, 238, 144}},
    NamedColour{"orange", {255, 165, 0}},
    NamedColour{"purple", {128, 0, 128}},
};
constexpr int kLineColour = 1;
constexpr double kMostIterations = 1e6;

struct Command {
  std::string name;  // in small letters
  TextPiece value;
  TextPiece line;
};

// the place of a remark: a sign at the beginning of a line or behind a blank. In a string of symbols a blank stands
// behind it, too
std::size_t remarkOf(std::string_view code) {
  const std::string word = lowered(code.substr(0, code.find_first_of(" \t:=")));
  const bool hasSymbols = word == "axiom" || word == "prule";
  // the first symbol may be such a sign
  const std::size_t begin = hasSymbols ? code.find_first_not_of(" \t:=", word.size()) + 1 : 0;
  for (std::size_t at = begin; at < code.size(); ++at) {
    const std::size_t length = code.substr(at).starts_with("//") ? 2 : code[at] == '#' || code[at] == ';' ? 1 : 0;
    const std::string_view behind = code.substr(std::min(at + length, code.size()));
    const auto isBlank = [](char c) { return c == ' ' || c == '\t'; };
    // a colour may be #ff0000
    const bool needsBlank = hasSymbols || (at > 0 && code[at] == '#');
    if (length > 0 && (at == 0 || isBlank(code[at - 1])) &&
        (!needsBlank || behind.empty() || isBlank(behind.front()))) {
      return at;
    }
  }
  return code.size();
}

// a line without its remark; nothing for an empty line
std::optional<Command> commandOf(const TextPiece& line) {
  const TextPiece whole = line.trimmed();
  const TextPiece code = whole.to(remarkOf(whole.text)).trimmed();
  if (code.empty()) {
    return std::nullopt;
  }
  const std::size_t end = std::min(code.text.find_first_of(" \t:="), code.text.size());
  TextPiece value = code.from(end).trimmed();
  if (value.text.starts_with(':') || value.text.starts_with('=')) {
    value = value.from(1).trimmed();
  }
  return Command{lowered(code.text.substr(0, end)), value, code};
}

class LsystemViewerReader {
 public:
  LsystemViewerReader(std::string_view text, DialectReport& report) : text_(text), report_(report) {}

  CpfgModel read() {
    for (const TextPiece& line : linesOf(text_)) {
      if (const std::optional<Command> command = commandOf(line)) {
        execute(*command);
      }
    }
    finish();
    return std::move(model_);
  }

 private:
  void execute(const Command& command) {
    const std::string& name = command.name;
    if (name == "prule") {
      return readRule(command);
    }
    if (std::find(kCommands.begin(), kCommands.end(), name) == kCommands.end()) {
      report_.error(command.line.offset, name.size(), "unknown command '" + name.substr(0, 40) + "'",
                    core::suggestName(name, {kCommands.begin(), kCommands.end()}));
      return;
    }
    if (!seen_.insert(name).second) {
      report_.error(command.line.offset, name.size(), "'" + name + "' is given twice", "leave one of the lines");
    }
    if (command.value.empty()) {
      report_.error(command.line.offset, name.size(), "'" + name + "' has no value", "write it behind the command");
    } else if (name == "axiom") {
      checkBrackets(text_, command.value.offset, command.value.offset + command.value.text.size(), "the axiom",
                    report_);
      model_.axiom = modules(command.value);
    } else if (name == "color") {
      readColour(command);
    } else if (name == "origin") {
      readOrigin(command);
    } else {
      readNumberCommand(command);
    }
  }

  void readNumberCommand(const Command& command) {
    const std::optional<double> number = fraction(command.value.text);
    const std::string& name = command.name;
    const auto refuse = [&](const std::string& expected, const std::string& hint) {
      report_.error(command.value.offset, command.value.text.size(),
                    "expected " + expected + " while reading '" + name + "', found '" +
                        std::string(command.value.text.substr(0, 40)) + "'",
                    hint);
    };
    if (!number) {
      return refuse("a number", "write it with a point, or as a fraction such as 1/3");
    }
    if (name == "generations") {
      if (*number < 0.0 || *number != std::floor(*number) || *number > kMostIterations) {
        return refuse("a whole number from 0 to 1000000", "it says how often the axiom is rewritten");
      }
      model_.derivationLength = static_cast<std::uint64_t>(*number);
    } else if (name == "scale") {
      if (!(*number > 0.0)) {
        return refuse("a number above 0", "the step length of the next generation is multiplied by it");
      }
      scale_ = *number;
    } else if (name == "step") {
      if (!(*number > 0.0)) {
        return refuse("a number above 0", "it is the length of a step of generation 0");
      }
      step_ = *number;
    } else if (name == "heading") {
      model_.headingDegrees = *number;
    } else {
      model_.angleDegrees = *number;
    }
  }

  void readColour(const Command& command) {
    const std::string name = lowered(command.value.text);
    const auto found = std::find_if(kNamedColours.begin(), kNamedColours.end(),
                                    [&](const NamedColour& colour) { return colour.name == name; });
    if (found == kNamedColours.end()) {
      std::vector<std::string_view> names;
      for (const NamedColour& colour : kNamedColours) {
        names.push_back(colour.name);
      }
      report_.error(command.value.offset, command.value.text.size(), "unknown color '" + name.substr(0, 40) + "'",
                    core::suggestName(name, names));
      return;
    }
    model_.palette[kLineColour] = found->colour;
  }

  void readOrigin(const Command& command) {
    std::string plain(command.value.text);
    std::replace_if(
        plain.begin(), plain.end(), [](char c) { return c == '(' || c == ')' || c == ',' || c == '\t'; }, ' ');
    std::vector<double> numbers;
    for (std::size_t at = plain.find_first_not_of(' '); at != std::string::npos && at < plain.size();
         at = plain.find_first_not_of(' ', at)) {
      const std::size_t end = std::min(plain.find(' ', at), plain.size());
      if (const auto number = fraction(std::string_view(plain).substr(at, end - at))) {
        numbers.push_back(*number);
      } else {
        numbers.clear();
        break;
      }
      at = end;
    }
    if (numbers.size() != 2) {
      report_.error(
          command.value.offset, command.value.text.size(),
          "expected a point while reading 'origin', found '" + std::string(command.value.text.substr(0, 40)) + "'",
          "write it as (x, y)");
      return;
    }
    model_.position = {numbers[0], numbers[1], 0.0};
  }

  void readRule(const Command& command) {
    const std::string_view value = command.value.text;
    const std::size_t length = value.empty() ? 0 : std::min(characterLength(value.front()), value.size());
    TextPiece rest = command.value.from(length).trimmed();
    std::size_t arrow = 0;
    for (const std::string_view sign : {"-->", "->", "→", "="}) {
      if (arrow == 0 && rest.text.starts_with(sign)) {
        arrow = sign.size();
      }
    }
    if (length == 0 || arrow == 0) {
      report_.error(command.line.offset, command.line.text.size(),
                    "expected a rule such as 'F -> F+F' while reading 'prule'",
                    "one symbol, '->' (or '→' or '='), and its successor");
      return;
    }
    const char symbol = value.front();
    if (!isSymbol(symbol) || symbol == '[' || symbol == ']') {
      report_.error(command.value.offset, length,
                    "the character '" + std::string(value.substr(0, length)) + "' cannot be rewritten",
                    "give the rule a letter");
      return;
    }
    if (!rewritten_.insert(symbol).second) {
      report_.error(command.value.offset, length, std::string("there is a rule for '") + symbol + "' already",
                    "each symbol has one rule in a deterministic L-system");
      return;
    }
    const TextPiece successor = rest.from(arrow).trimmed();
    checkBrackets(text_, successor.offset, successor.offset + successor.text.size(),
                  std::string("the rule of ") + symbol, report_);
    used_.insert(symbol);
    MappedText production;
    production.copy(value.substr(0, 1), command.value.offset).make(" --> ", command.value.offset);
    const MappedText modulesOfRule = modules(successor);
    production.add(modulesOfRule.empty() ? MappedText("*", rest.offset) : modulesOfRule);
    model_.productions.push_back(std::move(production));
  }

  static bool isSymbol(char c) {
    return c > ' ' && c < 127 && std::string_view("<>:*%?$()@~\"'").find(c) == std::string_view::npos;
  }

  MappedText modules(const TextPiece& piece) {
    MappedText result;
    for (std::size_t at = 0; at < piece.text.size();) {
      const char c = piece.text[at];
      const std::size_t length = std::min(characterLength(c), piece.text.size() - at);
      if (c == ' ' || c == '\t') {
        // blanks have no meaning
      } else if (!isSymbol(c)) {
        report_.error(piece.offset + at, length,
                      "the character '" + std::string(piece.text.substr(at, length)) + "' cannot be a symbol here",
                      "use a letter instead");
      } else {
        // two slashes in a row would begin a comment
        result.make(std::string_view(result.text()).ends_with('/') ? " " : "", piece.offset + at);
        result.copy(piece.text.substr(at, 1), piece.offset + at);
        used_.insert(c);
      }
      at += length;
    }
    return result;
  }

  // a number, or two with a slash
  static std::optional<double> fraction(std::string_view text) {
    while (!text.empty() && (text.back() == ' ' || text.ends_with("°"))) {
      text.remove_suffix(text.back() == ' ' ? 1 : std::string_view("°").size());
    }
    const std::size_t slash = text.find('/');
    if (slash == std::string_view::npos) {
      return core::parseNumber(text);
    }
    const auto above = core::parseNumber(text.substr(0, slash));
    const auto below = core::parseNumber(text.substr(slash + 1));
    return above && below && *below != 0.0 ? std::optional(*above / *below) : std::nullopt;
  }

  void finish() {
    if (model_.axiom.empty() && seen_.count("axiom") == 0) {
      report_.error(0, 1, "the model has no axiom", "write the first string behind the word axiom");
    }
    if (seen_.count("angle") == 0 && (used_.count('+') > 0 || used_.count('-') > 0)) {
      report_.error(0, 1, "the model turns with + or - and has no angle", "'angle 60' turns by 60 degrees");
    }
    if (seen_.count("generations") == 0) {
      model_.derivationLength = 0;
    }
    if (seen_.count("heading") == 0) {
      model_.headingDegrees = 0.0;
    }
    // the step of generation n is step * scale^n
    const std::string length = cpfgNumber(step_) + (scale_ == 1.0 ? "" : "*" + cpfgNumber(scale_) + "^Q");
    model_.drawing.emplace_back("F --> F(" + length + ")", 0);
    model_.drawing.emplace_back("f --> f(" + length + ")", 0);
    silence(used_, "Ff+-", model_);
    model_.colour = kLineColour;
    model_.palette.try_emplace(kLineColour, kNamedColours.front().colour);
    model_.palette[0] = {255, 255, 255};
    model_.lost.emplace_back("the color of the lines (put a colour map beside the model)");
  }

  std::string_view text_;
  DialectReport& report_;
  CpfgModel model_;
  double step_ = 1.0;
  double scale_ = 1.0;
  std::set<std::string> seen_;
  std::set<char> used_;
  std::set<char> rewritten_;
};

}  // namespace

bool recognisesLsystemViewer(std::string_view text) {
  std::set<std::string> seen;
  bool hasOtherRule = false;
  for (const TextPiece& line : linesOf(text)) {
    if (const std::optional<Command> command = commandOf(line)) {
      seen.insert(command->name);
      // arrows and `F=F+F` without `prule` are textbook notation
      const std::string_view code = command->line.text;
      const bool isCommand = std::find(kCommands.begin(), kCommands.end(), command->name) != kCommands.end();
      hasOtherRule = hasOtherRule || arrowOf(code) || code.find("–>") != std::string_view::npos ||
                     code.find("−>") != std::string_view::npos ||
                     (!isCommand && command->name.size() == 1 && code.find('=') != std::string_view::npos) ||
                     command->name == "rule" || command->name == "rules" || command->name == "productions";
    }
  }
  const auto has = [&](const char* name) { return seen.count(name) > 0; };
  return has("prule") || (!hasOtherRule && (has("generations") || (has("axiom") && (has("angle") || has("step")))));
}

CpfgModel translateLsystemViewer(std::string_view text, const std::string& /*entry*/, DialectReport& report) {
  return LsystemViewerReader(text, report).read();
}

}  // namespace espalier::language
