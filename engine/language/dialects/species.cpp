#include "engine/language/dialects/species.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/language/dialects/text_lines.h"

namespace espalier::language {
namespace {

enum class Label : std::uint8_t { Species, Variables, Constants, Axiom, Rules, Step, Angle, Generations, Draw, Turn };

struct LabelName {
  std::string_view name;  // without its colon
  Label label;
};

constexpr std::array kLabels = {
    LabelName{"Variáveis", Label::Variables},
    LabelName{"Variables", Label::Variables},
    LabelName{"Constantes", Label::Constants},
    LabelName{"Constants", Label::Constants},
    LabelName{"Axioma", Label::Axiom},
    LabelName{"Axiom", Label::Axiom},
    LabelName{"Regras", Label::Rules},
    LabelName{"Rules", Label::Rules},
    LabelName{"Passo", Label::Step},
    LabelName{"Step", Label::Step},
    LabelName{"Ângulo", Label::Angle},
    LabelName{"Angle", Label::Angle},
    LabelName{"Gerações", Label::Generations},
    LabelName{"Generations", Label::Generations},
    LabelName{"Sorteio", Label::Draw},
    LabelName{"Draw", Label::Draw},
    LabelName{"Giro", Label::Turn},
    LabelName{"Turn", Label::Turn},
};
constexpr double kMostGenerations = 1000.0;

// a word in small letters without accents, in both of Unicode's ways of writing them
std::string plainWord(std::string_view word) {
  constexpr std::string_view kBases = "aaaaaaaceeeeiiiidnooooo*ouuuuyts";  // of À to ß, and of à to ÿ
  std::string plain;
  for (std::size_t i = 0; i < word.size(); ++i) {
    const auto byte = static_cast<unsigned char>(word[i]);
    if (byte == 0xC3 && i + 1 < word.size()) {
      plain += kBases[static_cast<unsigned char>(word[++i]) % kBases.size()];
    } else if (byte == 0xCC || byte == 0xCD) {
      ++i;  // an accent of its own
    } else {
      plain += lowered(word[i]);
    }
  }
  return plain;
}

std::optional<Label> speciesLabel(std::string_view word) {
  static const auto kByPlainName = [] {
    std::map<std::string, Label> names;
    for (const LabelName& label : kLabels) {
      names.emplace(plainWord(label.name), label.label);
    }
    return names;
  }();
  const auto found = kByPlainName.find(plainWord(word));
  return found == kByPlainName.end() ? std::nullopt : std::optional(found->second);
}

struct SpeciesStatement {
  Label label = Label::Species;
  TextPiece value;
  TextPiece line;
};

// the value of a line, or of a piece of one, with a label; a line without a label continues the rules before it
std::optional<SpeciesStatement> statementOf(const TextPiece& line) {
  const TextPiece code = line.trimmed();
  const std::size_t blank = std::min(code.text.find_first_of(" \t"), code.text.size());
  // only a word that may be it is made plain: a table has thousands of lines
  const bool isLikely = !code.empty() && std::string_view("EeSs").find(code.text.front()) != std::string_view::npos;
  const std::string first = isLikely ? plainWord(code.text.substr(0, blank)) : std::string{};
  if (blank < code.text.size() && (first == "especie" || first == "species")) {
    TextPiece name = code.from(blank).trimmed();
    name = name.text.ends_with(':') ? name.to(name.text.size() - 1) : name;
    return SpeciesStatement{Label::Species, name, code};
  }
  const std::size_t colon = code.text.find(':');
  if (colon == std::string_view::npos) {
    return std::nullopt;
  }
  const std::optional<Label> label = speciesLabel(code.to(colon).trimmed().text);
  return label ? std::optional(SpeciesStatement{*label, code.from(colon + 1).trimmed(), code}) : std::nullopt;
}

// where a label begins behind a blank; npos: nowhere
std::size_t findLabel(std::string_view code) {
  for (std::size_t i = code.find_first_of(" \t"); i != std::string_view::npos; i = code.find_first_of(" \t", i + 1)) {
    const std::string_view rest = code.substr(i + 1);
    const std::string_view word = rest.substr(0, rest.find_first_of(" \t:"));
    const std::size_t end = rest.find_first_not_of(" \t", word.size());
    if (end != std::string_view::npos && rest[end] == ':' && speciesLabel(word)) {
      return i + 1;
    }
  }
  return std::string_view::npos;
}

// the lines of a text from `begin` on; a line that begins with a label may hold others, as a row of the published table
// does
std::vector<TextPiece> piecesOf(std::string_view text, std::size_t begin = 0) {
  std::vector<TextPiece> pieces;
  for (TextPiece line : linesOf(text.substr(begin), begin)) {
    while (statementOf(line)) {
      const TextPiece code = line.trimmed();
      const std::size_t next = findLabel(code.text);
      if (next == std::string_view::npos) {
        break;
      }
      pieces.push_back(code.to(next));
      line = code.from(next);
    }
    pieces.push_back(line);
  }
  return pieces;
}

struct Range {
  double least = 0.0;
  double most = 0.0;
};

class SpeciesReader {
 public:
  SpeciesReader(std::string_view text, DialectReport& report) : text_(text), report_(report) {}

  CpfgModel read(const std::string& entry, std::size_t begin) {
    offset_ = begin;
    bool isInside = false;
    bool isInRules = false;
    for (const TextPiece& line : piecesOf(text_, begin)) {
      const TextPiece code = line.trimmed();
      const std::optional<SpeciesStatement> statement = statementOf(line);
      if (statement && statement->label == Label::Species) {
        if (isInside && !entry.empty()) {
          break;
        }
        isInside = entry.empty() || statement->line.offset == begin;
        isInRules = false;
      } else if (isInside || entry.empty()) {
        if (statement) {
          isInRules = statement->label == Label::Rules;
          execute(*statement);
        } else if (!code.empty() && !code.text.starts_with('#')) {
          isInRules ? readRules(code) : refuse(code);
        }
      }
    }
    finish();
    return std::move(model_);
  }

 private:
  struct Rule {
    char variable = 0;
    std::size_t offset = 0;
    TextPiece successor;
  };

  void refuse(const TextPiece& code) {
    std::vector<std::string_view> names;
    for (const LabelName& label : kLabels) {
      names.push_back(label.name);
    }
    const std::string word(code.text.substr(0, code.text.find(':')));
    report_.error(code.offset, code.text.size(), "expected a label of a species, found '" + word.substr(0, 40) + "'",
                  core::suggestName(word, names));
  }

  void execute(const SpeciesStatement& statement) {
    const TextPiece& value = statement.value;
    switch (statement.label) {
      case Label::Variables:
        for (const char c : value.text) {
          if (std::isalpha(static_cast<unsigned char>(c)) != 0) {
            variables_.insert(c);
          }
        }
        return;
      case Label::Axiom:
        checkBrackets(text_, value.offset, value.offset + value.text.size(), "the axiom", report_);
        axiom_ = value;
        return;
      case Label::Rules:
        return readRules(value);
      case Label::Step:
        step_ = range(value, 0.0, 1e6, step_);
        return;
      case Label::Angle:
        angle_ = range(value, 0.0, 360.0, angle_);
        return;
      case Label::Turn:
        turn_ = range(value, -360.0, 360.0, {}).most;
        return;
      case Label::Generations: {
        generations_ = range(value, 0.0, kMostGenerations, generations_);
        if (generations_.least != std::floor(generations_.least) ||
            generations_.most != std::floor(generations_.most)) {
          report_.error(value.offset, value.text.size(), "a number of generations is a whole number",
                        "write it as 4 or 4..6");
        }
        return;
      }
      case Label::Draw:
        return readDraw(value);
      default:
        return;
    }
  }

  void readDraw(const TextPiece& value) {
    const std::string word = plainWord(value.text);
    const bool isModule = word == "modulo" || word == "module";
    if (!isModule && word != "geracao" && word != "generation") {
      report_.error(value.offset, value.text.size(),
                    "expected how rules are drawn, found '" + std::string(value.text.substr(0, 40)) + "'",
                    "'geração' (generation): one rule for the whole string; 'módulo' (module): one for each module");
    }
    drawsByModule_ = isModule;
  }

  // `4`, or `4,5` with a comma
  static std::optional<double> number(const TextPiece& value) {
    std::string plain(value.trimmed().text);
    std::replace(plain.begin(), plain.end(), ',', '.');
    return core::parseNumber(plain);
  }

  // `4..8` or `5`
  Range range(const TextPiece& value, double least, double most, Range fallback) {
    const std::size_t dots = value.text.find("..");
    const auto first = number(value.to(dots));
    const auto last = dots == std::string_view::npos ? first : number(value.from(dots + 2));
    if (!first || !last || *first < least || *last > most || *first > *last) {
      report_.error(value.offset, value.text.size(),
                    "expected a range from " + cpfgNumber(least) + " to " + cpfgNumber(most) + ", found '" +
                        std::string(value.text.substr(0, 40)) + "'",
                    "write it as 4 or 4..6");
      return fallback;
    }
    return {*first, *last};
  }

  // rules separated by commas; a comma in a rule is not a symbol
  void readRules(const TextPiece& value) {
    for (std::size_t begin = 0; begin <= value.text.size();) {
      const std::size_t end = std::min(value.text.find(',', begin), value.text.size());
      const TextPiece rule = TextPiece{value.text.substr(begin, end - begin), value.offset + begin}.trimmed();
      begin = end + 1;
      if (rule.empty()) {
        continue;
      }
      const std::size_t arrow = std::min(rule.text.find("->"), rule.text.find("→"));
      if (arrow == std::string_view::npos || rule.to(arrow).trimmed().text.size() != 1) {
        report_.error(rule.offset, rule.text.size(),
                      "expected a rule such as 'F -> F[+F]F', found '" + std::string(rule.text.substr(0, 40)) + "'",
                      "one variable, '->' and its successor; rules are separated by commas");
        continue;
      }
      const std::size_t length = rule.text[arrow] == '-' ? 2 : std::string_view("→").size();
      const TextPiece successor = rule.from(arrow + length).trimmed();
      checkBrackets(text_, successor.offset, successor.offset + successor.text.size(), "the rule", report_);
      rules_.push_back({rule.text.front(), rule.offset, successor});
    }
  }

  MappedText modules(const TextPiece& piece) {
    MappedText result;
    for (std::size_t i = 0; i < piece.text.size(); ++i) {
      const char c = piece.text[i];
      const bool isKnown = std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                           std::string_view("+-[]").find(c) != std::string_view::npos;
      if (c != ' ' && !isKnown) {
        report_.error(piece.offset + i, characterLength(c),
                      "the character '" + std::string(piece.text.substr(i, characterLength(c))) +
                          "' is not a symbol of a species",
                      "symbols are letters, digits, + - [ ]");
        i += characterLength(c) - 1;
      } else if (c != ' ') {
        result.copy(piece.text.substr(i, 1), piece.offset + i);
        used_.insert(c);
      }
    }
    return result;
  }

  // as printed, species 3 to 5 begin with X and rewrite only F: the rules that make X become rules of X
  void correctRules() {
    const bool grows = std::any_of(rules_.begin(), rules_.end(), [&](const Rule& rule) {
      return axiom_.text.find(rule.variable) != std::string_view::npos;
    });
    if (grows || rules_.empty() || axiom_.text.size() != 1) {
      return;
    }
    const char start = axiom_.text.front();
    bool isCorrected = false;
    for (Rule& rule : rules_) {
      if (rule.successor.text.find(start) != std::string_view::npos) {
        rule.variable = start;
        isCorrected = true;
      }
    }
    if (isCorrected) {
      report_.warn(
          axiom_.offset, 1,
          std::string("no rule rewrites the axiom ") + start + ": the rules that contain it are read as its own",
          std::string("write '") + start + " -> ...' for them");
    }
  }

  void addRules() {
    std::map<char, std::vector<const Rule*>> byVariable;
    std::vector<char> order;
    for (const Rule& rule : rules_) {
      if (byVariable[rule.variable].empty()) {
        order.push_back(rule.variable);
      }
      byVariable[rule.variable].push_back(&rule);
    }
    std::string draws;
    for (const char variable : order) {
      const auto& rules = byVariable[variable];
      const std::string choice = std::string("rule") + variable;
      if (rules.size() > 1 && !drawsByModule_) {
        draws += " " + choice + " = floor(ran(" + std::to_string(rules.size()) + "));";
      }
      for (std::size_t i = 0; i < rules.size(); ++i) {
        MappedText production;
        production.make(std::string(1, variable), rules[i]->offset);
        if (rules.size() > 1 && !drawsByModule_) {
          production.make(" : " + choice + " == " + std::to_string(i), rules[i]->offset);
        }
        const MappedText successor = modules(rules[i]->successor);
        production.make(" --> ", rules[i]->offset)
            .add(successor.empty() ? MappedText("*", rules[i]->offset) : successor);
        if (rules.size() > 1 && drawsByModule_) {
          production.make(" : 1", rules[i]->offset);
          model_.isStochastic = true;
        }
        model_.productions.push_back(std::move(production));
      }
    }
    if (!draws.empty()) {
      model_.items.emplace_back("StartEach: {" + draws + " }", offset_);
    }
  }

  // a number drawn between two bounds, or the only number
  static std::string drawn(const Range& range, bool isWhole) {
    const double span = range.most - range.least + (isWhole ? 1.0 : 0.0);
    if (range.most == range.least) {
      return cpfgNumber(range.least);
    }
    const std::string value = "ran(" + cpfgNumber(span) + ")";
    return cpfgNumber(range.least) + " + " + (isWhole ? "floor(" + value + ")" : value);
  }

  void finish() {
    if (axiom_.empty()) {
      report_.error(offset_, 1, "the species has no axiom", "write 'Axioma: F'");
    }
    if (rules_.empty()) {
      report_.error(offset_, 1, "the species has no rules", "write 'Regras: F -> F[+F]F'");
    }
    correctRules();
    model_.axiom = modules(axiom_);
    model_.derivationLength = static_cast<std::uint64_t>(generations_.most);
    model_.items.emplace_back("Start: { step = " + drawn(step_, false) + "; angle = " + drawn(angle_, false) +
                                  "; generations = " + drawn(generations_, true) + "; }",
                              offset_);
    addRules();
    if (generations_.least < generations_.most) {
      model_.items.emplace_back("EndEach: { if (Q >= generations) { stop(2); } }", offset_);
    }
    for (const char variable : variables_) {
      if (used_.count(variable) == 0) {
        report_.warn(offset_, 1, std::string("the variable ") + variable + " is not used", "leave it out");
      }
    }
    const auto draw = [&](const std::string& production) { model_.drawing.emplace_back(production, offset_); };
    draw("F --> F(step)");
    // seen from the front, + turns with the clock
    draw("+ --> -(angle)");
    draw("- --> +(angle)");
    if (turn_ != 0.0) {
      // a macro, so that a run can set the turn to 0
      model_.items.emplace_back("#define GIRO " + cpfgNumber(turn_), offset_);
      draw("[ --> [/(GIRO)");
    }
    silence(used_, "F+-", model_);
    model_.turnsByAngle = false;
  }

  std::string_view text_;
  DialectReport& report_;
  CpfgModel model_;
  std::size_t offset_ = 0;
  std::set<char> variables_;
  std::set<char> used_;
  TextPiece axiom_;
  std::vector<Rule> rules_;
  Range step_{1.0, 1.0};
  Range angle_{25.0, 25.0};
  Range generations_{4.0, 4.0};
  double turn_ = 0.0;
  bool drawsByModule_ = false;
};

}  // namespace

bool recognisesSpecies(std::string_view text) {
  bool hasSpecies = false;
  bool hasRules = false;
  for (const TextPiece& line : piecesOf(text)) {
    if (const std::optional<SpeciesStatement> statement = statementOf(line)) {
      hasSpecies = hasSpecies || statement->label == Label::Species;
      hasRules = hasRules || statement->label == Label::Rules;
    }
  }
  return hasSpecies && hasRules;
}

std::vector<DialectEntry> speciesEntries(std::string_view text) {
  std::vector<DialectEntry> entries;
  std::map<std::string, std::size_t> counts;
  for (const TextPiece& line : piecesOf(text)) {
    const std::optional<SpeciesStatement> statement = statementOf(line);
    if (statement && statement->label == Label::Species) {
      // the second of equal names is NAME-2
      const std::string name(statement->value.text);
      const std::size_t count = ++counts[lowered(name)];
      entries.push_back({name + (count > 1 ? "-" + std::to_string(count) : ""), statement->line.offset});
    }
  }
  return entries;
}

CpfgModel translateSpecies(std::string_view text, const std::string& entry, DialectReport& report) {
  std::size_t begin = 0;
  for (const DialectEntry& found : speciesEntries(text)) {
    begin = found.name == entry ? found.offset : begin;
  }
  return SpeciesReader(text, report).read(entry, begin);
}

}  // namespace espalier::language
