#include "engine/language/dialects/translation.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <utility>

#include "engine/core/elementary.h"
#include "engine/core/number_text.h"

namespace espalier::language {
namespace {

// the commands of the cpfg turtle without a parameter
constexpr std::string_view kTurtleSymbols = "FGfg+-&^/\\|;,#!{.}~$%_@?";
// the turns by the angle increment
constexpr std::string_view kTurns = "+-&^/\\";

std::string triple(double x, double y, double z) {
  return cpfgNumber(x) + "," + cpfgNumber(y) + "," + cpfgNumber(z);
}

// cosine and sine, exactly 0 and 1 at right angles
std::pair<double, double> direction(double degrees) {
  const auto clean = [](double value) {
    const double nearest = std::round(value);
    return std::abs(value - nearest) < 1e-15 ? nearest : value;
  };
  const double radians = degrees * std::numbers::pi / 180.0;
  return {clean(core::cos(radians)), clean(core::sin(radians))};
}

void addLine(MappedText& text, const MappedText& line) {
  text.add(line);
  // a backslash at the end of a line would join the next one
  const bool isJoining = std::string_view(line.text()).ends_with('\\');
  text.make(isJoining ? " \n" : "\n", line.runs().empty() ? 0 : line.runs().back().foreignOffset);
}

// whether modules have the turn without a parameter; the arrow of productions and operators in parentheses are no turns
bool hasTurn(std::string_view text, char turn) {
  int depth = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text.substr(at).starts_with("-->")) {
      at += 2;
    } else if (text[at] == '(' || text[at] == ')') {
      depth += text[at] == '(' ? 1 : -1;
    } else if (depth == 0 && text[at] == turn && (at + 1 == text.size() || text[at + 1] != '(')) {
      return true;
    }
  }
  return false;
}

// modules that bring the turtle to its start
std::string startModules(const CpfgModel& model) {
  std::string modules;
  if (model.position != core::Vec3{}) {
    modules += "@M(" + triple(model.position.x, model.position.y, model.position.z) + ")";
  }
  if (model.headingDegrees != 90.0) {
    modules += "+(" + cpfgNumber(model.headingDegrees - 90.0) + ")";
  }
  return modules;
}

}  // namespace

std::string cpfgNumber(double value) {
  std::string text;
  core::appendNumber(text, value, core::NumberStyle::Shortest);
  return text;
}

void MappedText::append(std::string_view text, std::size_t foreignOffset, bool isCopied) {
  if (!text.empty()) {
    runs_.push_back({static_cast<std::uint32_t>(text_.size()), static_cast<std::uint32_t>(foreignOffset), isCopied});
    text_ += text;
  }
}

MappedText& MappedText::copy(std::string_view foreign, std::size_t foreignOffset) {
  append(foreign, foreignOffset, true);
  return *this;
}

MappedText& MappedText::make(std::string_view made, std::size_t foreignOffset) {
  append(made, foreignOffset, false);
  return *this;
}

MappedText& MappedText::add(const MappedText& other) {
  const auto shift = static_cast<std::uint32_t>(text_.size());
  for (Run run : other.runs_) {
    run.begin += shift;
    runs_.push_back(run);
  }
  text_ += other.text_;
  return *this;
}

void DialectReport::add(core::Severity severity, std::size_t offset, std::size_t length, std::string message,
                        std::string hint) {
  core::Diagnostic diagnostic;
  diagnostic.severity = severity;
  // finding a place takes a walk through the file, and the list keeps only its limit of each severity
  const std::size_t count = severity == core::Severity::Error ? diagnostics_.errorCount() : diagnostics_.warningCount();
  if (count >= core::DiagnosticList::kLimit) {
    diagnostics_.add(std::move(diagnostic));
    return;
  }
  diagnostic.message = std::move(message);
  diagnostic.hint = std::move(hint);
  diagnostic.location = files::locateInFile(file_, static_cast<std::uint32_t>(offset),
                                            static_cast<std::uint32_t>(std::max<std::size_t>(1, length)));
  diagnostics_.add(std::move(diagnostic));
}

void DialectReport::error(std::size_t offset, std::size_t length, std::string message, std::string hint) {
  add(core::Severity::Error, offset, length, std::move(message), std::move(hint));
}

void DialectReport::warn(std::size_t offset, std::size_t length, std::string message, std::string hint) {
  add(core::Severity::Warning, offset, length, std::move(message), std::move(hint));
}

void DialectReport::note(std::size_t offset, std::size_t length, std::string message, std::string hint) {
  add(core::Severity::Note, offset, length, std::move(message), std::move(hint));
}

MappedText modelText(const CpfgModel& model, bool isAlone) {
  MappedText text("Lsystem: 1\nderivation length: " + std::to_string(model.derivationLength) + "\n", 0);
  if (isAlone && model.isStochastic) {
    text.make("seed: 1\n", 0);
  }
  for (const MappedText& item : model.items) {
    addLine(text, item);
  }
  text.make("Axiom: " + (isAlone ? startModules(model) : std::string{}), 0);
  addLine(text, model.axiom);
  // a model needs a production; this one changes nothing
  if (model.productions.empty()) {
    text.make("F --> F\n", 0);
  }
  for (const MappedText& production : model.productions) {
    addLine(text, production);
  }
  if (!model.decomposition.empty()) {
    text.make("decomposition no warnings\nmaximum depth: " + std::to_string(model.decompositionDepth) + "\n", 0);
    for (const MappedText& production : model.decomposition) {
      addLine(text, production);
    }
  }
  // only the turns that can occur: the others would be productions that never match
  std::string turns;
  if (isAlone && model.turnsByAngle) {
    std::string modules = text.text();
    for (const MappedText& production : model.drawing) {
      modules += production.text() + '\n';
    }
    const auto isDrawn = [&model](char turn) {
      return std::any_of(model.drawing.begin(), model.drawing.end(), [turn](const MappedText& production) {
        return production.text().starts_with(turn + std::string(" --> "));
      });
    };
    std::copy_if(kTurns.begin(), kTurns.end(), std::back_inserter(turns),
                 [&](char turn) { return hasTurn(modules, turn) && !isDrawn(turn); });
  }
  const bool writesOwn = !isAlone && !model.ownDrawing.empty();
  if (!model.drawing.empty() || writesOwn || !turns.empty()) {
    text.make("homomorphism no warnings\n", 0);
    if (model.drawingDepth != 1) {
      text.make("maximum depth: " + std::to_string(model.drawingDepth) + "\n", 0);
    }
    for (const MappedText& production : model.drawing) {
      addLine(text, production);
    }
    for (const MappedText& production : writesOwn ? model.ownDrawing : std::vector<MappedText>{}) {
      addLine(text, production);
    }
  }
  for (const char turn : turns) {
    text.make(std::string(1, turn) + " --> " + turn + "(" + cpfgNumber(model.angleDegrees) + ")\n", 0);
  }
  text.make("endlsystem\n", 0);
  return text;
}

std::string viewText(const CpfgModel& model) {
  std::string text = "angle increment: " + cpfgNumber(model.angleDegrees) + "\n";
  if (model.headingDegrees != 90.0) {
    const auto [x, y] = direction(model.headingDegrees);
    text += "initial heading: " + triple(x, y, 0.0) + "\n";
  }
  if (model.position != core::Vec3{}) {
    text += "initial position: " + triple(model.position.x, model.position.y, model.position.z) + "\n";
  }
  if (model.colour != 128) {
    text += "initial color: " + std::to_string(model.colour) + "\n";
  }
  for (const auto& [index, colour] : model.palette) {
    text += "color map entry: " + std::to_string(index) + " " + triple(colour.red, colour.green, colour.blue) + "\n";
  }
  for (const std::string& command : model.viewCommands) {
    text += command + "\n";
  }
  return text;
}

void checkBrackets(std::string_view foreign, std::size_t begin, std::size_t end, const std::string& where,
                   DialectReport& report) {
  std::vector<std::size_t> open;
  for (std::size_t at = begin; at < end; ++at) {
    if (foreign[at] == '[') {
      open.push_back(at);
    } else if (foreign[at] == ']' && open.empty()) {
      report.error(at, 1, "']' closes no bracket in " + where, "each ']' goes back to the '[' before it");
    } else if (foreign[at] == ']') {
      open.pop_back();
    }
  }
  for (const std::size_t at : open) {
    report.error(at, 1, "the bracket '[' is never closed in " + where,
                 "a ']' goes back to where the turtle was at '['");
  }
}

void silence(const std::set<char>& symbols, std::string_view meaningful, CpfgModel& model) {
  for (const char symbol : symbols) {
    if (kTurtleSymbols.find(symbol) != std::string_view::npos && meaningful.find(symbol) == std::string_view::npos) {
      model.drawing.emplace_back(std::string(1, symbol) + " --> *", 0);
    }
  }
}

}  // namespace espalier::language
