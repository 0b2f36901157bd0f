#include "engine/derivation/explanation.h"

#include <algorithm>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/check.h"
#include "engine/core/message_text.h"
#include "engine/core/number_text.h"
#include "engine/derivation/expressions/failure.h"
#include "engine/derivation/rewrite_record.h"
#include "engine/derivation/state/string_text.h"

namespace espalier::derivation {
namespace {

using language::Production;
using language::ProductionList;

// modules shown on either side of the explained module
constexpr std::uint64_t kNeighbours = 8;
// modules of a successor that are shown
constexpr std::uint64_t kShownModules = 200;

std::string number(double value) {
  std::string text;
  core::appendNumber(text, value, core::NumberStyle::Shortest);
  return text;
}

std::string counted(std::uint64_t count, const std::string& name) {
  return std::to_string(count) + " " + name + (count == 1 ? "" : "s");
}

/// Writes the explanation of one ModuleRecord.
class Writer {
 public:
  Writer(const language::Program& program, const PlantState& state, const ModuleRecord& record)
      : program_(program), state_(state), record_(record) {}

  std::string run(const std::optional<core::SimulationError>& failure) {
    writeModule();
    if (record_.fate == ModuleRecord::Fate::CutAway) {
      line("What happened: it was cut away. " + module(record_.cutBy) +
           ", a cut symbol without a production, removed the modules right of it in its branch.");
    } else {
      writeFate();
      writeSearches();
    }
    if (failure) {
      line("");
      line("The step failed: " + failure->message);
    }
    return std::move(text_);
  }

 private:
  void line(const std::string& text) { text_ += text + "\n"; }

  // ---- the module and what became of it

  void writeModule() {
    line("Step " + std::to_string(state_.step + 1) + " reads the string of step " + std::to_string(state_.step) + ", " +
         counted(state_.string.size(), "module") + ", with the replies of the environment.");
    line("Module " + std::to_string(record_.module) + ": " + moduleAt(record_.module));
    const std::uint64_t begin = record_.module > kNeighbours ? record_.module - kNeighbours : 0;
    const std::uint64_t end = std::min(record_.module + kNeighbours + 1, state_.string.size());
    std::string around = begin > 0 ? "... " : "";
    for (std::uint64_t i = begin; i < end; ++i) {
      around += i == record_.module ? " >>" + moduleAt(i) + "<< " : moduleAt(i);
    }
    line("Around it: " + around + (end < state_.string.size() ? " ..." : ""));
    if (program_.systems.size() > 1 && record_.system != nullptr) {
      line("L-system: " + record_.system->name);
    }
    line("");
  }

  void writeFate() {
    const SearchRecord* production = applied(record_.searches);
    switch (record_.fate) {
      case ModuleRecord::Fate::Rewritten:
        line("What happened: " + place(*production->chosen) + " fired" +
             (isDecomposition(*production) ? " (decomposition)." : "."));
        line("  " + production->chosen->text);
        if (record_.consumed > 1) {
          line("Its predecessor is " + counted(record_.consumed, "module") + ", " + std::to_string(record_.first) +
               " to " + std::to_string(record_.first + record_.consumed - 1) + "; this one is number " +
               std::to_string(record_.module - record_.first + 1) + " of them.");
        }
        line("It made: " + shown(record_.result));
        break;
      case ModuleRecord::Fate::Copied:
        line("What happened: no production applies; the module was copied.");
        break;
      case ModuleRecord::Fate::Cut:
        line("What happened: the cut symbol removed itself and the modules right of it in its branch.");
        break;
      default:
        line("What happened: the step failed while this module was rewritten.");
        break;
    }
    const core::ModuleTypeId type = state_.string.types()[record_.module];
    if (record_.fate == ModuleRecord::Fate::Copied && record_.system->homomorphism.mayApplyTo(type)) {
      line("The homomorphism has productions for it; they apply when the string is drawn and leave it as it is.");
    }
  }

  static const SearchRecord* applied(const std::vector<SearchRecord>& searches) {
    const auto found = std::find_if(searches.begin(), searches.end(),
                                    [](const SearchRecord& search) { return search.chosen != nullptr; });
    return found == searches.end() ? nullptr : &*found;
  }

  [[nodiscard]] bool isDecomposition(const SearchRecord& search) const {
    return search.list == &record_.system->decomposition;
  }

  // ---- searches

  void writeSearches() {
    const core::ModuleTypeId type = state_.string.types()[record_.first];
    const bool hasProductionSearch =
        std::any_of(record_.searches.begin(), record_.searches.end(),
                    [this](const SearchRecord& search) { return !isDecomposition(search); });
    if (!hasProductionSearch) {
      SearchRecord none;
      none.list = &record_.system->productions;
      none.type = type;
      writeSearch(none, "Productions");
    }
    for (const SearchRecord& search : record_.searches) {
      std::string title = "Productions";
      if (isDecomposition(search)) {
        title = "Decomposition of " + text(search.type, search.parameters);
        if (search.depth > 0) {
          title += ", made by " + counted(search.depth, "decomposition");
        }
      }
      writeSearch(search, title);
    }
  }

  void writeSearch(const SearchRecord& search, const std::string& title) {
    line("");
    if (search.isAtMaximumDepth) {
      line(title + ": not tried, the maximum depth is " + std::to_string(search.list->maximumDepth));
      return;
    }
    // those of the same symbol, in the order of the file
    std::vector<const Production*> related;
    for (const Production& production : search.list->productions) {
      if (program_.symbolOf[production.predecessor.front().type] == program_.symbolOf[search.type]) {
        related.push_back(&production);
      }
    }
    if (related.empty()) {
      line(title + ": none begins with '" + std::string(program_.nameOf(search.type)) + "'");
      return;
    }
    line(title + (isDecomposition(search) ? ": productions" : "") + " that begin with '" +
         std::string(program_.nameOf(search.type)) + "', in the order of the file:");
    for (const Production* production : related) {
      line("  " + place(*production) + ": " + production->text);
      writeCandidate(search, *production);
    }
    writeChoice(search);
  }

  void writeCandidate(const SearchRecord& search, const Production& production) {
    const auto found =
        std::find_if(search.candidates.begin(), search.candidates.end(),
                     [&](const CandidateRecord& candidate) { return candidate.production == &production; });
    if (found == search.candidates.end()) {
      const std::size_t arity = program_.arity[production.predecessor.front().type];
      const std::size_t has = program_.arity[search.type];
      line(arity != has
               ? "    failed: it wants " + counted(arity, "parameter") + ", the module has " + std::to_string(has)
               : "    not tried: an earlier production applied");
      return;
    }
    const CandidateRecord& candidate = *found;
    writeLooks("right", production.rightContext, candidate.rightLooks);
    writeLooks("left", production.leftContext, candidate.leftLooks);
    const std::string values = valuesText(candidate);
    switch (candidate.result) {
      case CandidateRecord::Result::Predecessor:
        writePredecessorFailure(search, candidate);
        break;
      case CandidateRecord::Result::RightContext:
        line("    failed: the right context does not match");
        break;
      case CandidateRecord::Result::LeftContext:
        line("    failed: the left context does not match");
        break;
      case CandidateRecord::Result::ProducedContext:
        line("    failed: a new context (<< or >>) does not match the string being produced");
        break;
      case CandidateRecord::Result::Condition:
        line("    failed: the condition '" + sourceText(program_, production.condition->range) + "' is 0" + values);
        break;
      case CandidateRecord::Result::Matched: {
        std::string verdict = search.chosen == &production ? "applied" : "applies too";
        if (candidate.condition) {
          verdict += ": the condition '" + sourceText(program_, production.condition->range) + "' is " +
                     number(*candidate.condition);
        }
        line("    " + verdict + values);
        if (search.isStochastic && candidate.weight) {
          line("    weight " + weightText(production, *candidate.weight));
        }
        if (search.chosen == &production && isDecomposition(search)) {
          line("    made: " + shown(search.made));
        } else if (search.chosen == &production && isDecomposedLater(search)) {
          line("    made, before its decomposition: " + shown(search.made));
        }
        break;
      }
    }
  }

  [[nodiscard]] std::string weightText(const Production& production, double weight) const {
    if (!production.probability) {
      return number(weight) + " (none is given)";
    }
    const std::string source = sourceText(program_, production.probability->range);
    return source == number(weight) ? source : source + " = " + number(weight);
  }

  [[nodiscard]] bool isDecomposedLater(const SearchRecord& search) const { return &search != &record_.searches.back(); }

  void writeChoice(const SearchRecord& search) {
    if (!search.isStochastic || search.chosen == nullptr) {
      return;
    }
    double sum = 0.0;
    for (const CandidateRecord& candidate : search.candidates) {
      sum += candidate.weight.value_or(0.0);
    }
    line(search.draw ? "  choice: the draw " + number(*search.draw) + " times the sum of weights " + number(sum) +
                           " is " + number(*search.draw * sum) + ", which selects " + place(*search.chosen)
                     : "  choice: only one production applies, so nothing is drawn");
  }

  void writePredecessorFailure(const SearchRecord& search, const CandidateRecord& candidate) {
    const std::size_t position = candidate.predecessorModule;
    std::string text = "    failed: module " + std::to_string(position + 1) + " of its predecessor is " +
                       formalText(candidate.production->predecessor[position]);
    const std::uint64_t index = record_.first + position;
    if (search.depth == 0) {
      text += index < state_.string.size() ? ", the string has " + module(index) : ", the string ends before";
    }
    line(text);
  }

  void writeLooks(const std::string& side, const std::vector<language::ContextElement>& context,
                  const std::vector<ContextLook>& looks) {
    for (std::size_t i = 0; i < looks.size(); ++i) {
      const ContextLook& look = looks[i];
      std::string text = "    " + side + " context: wants ";
      text += context[i].kind == language::ContextElement::Kind::SkipToBranchEnd ? std::string("the end of the branch")
                                                                                 : formalText(context[i].module);
      switch (look.result) {
        case ContextLook::Result::Matched:
          text += ", saw " + module(look.module);
          break;
        case ContextLook::Result::OtherModule:
          text += ", saw " + module(look.module);
          if (program_.symbolOf[look.type] == program_.symbolOf[context[i].module.type]) {
            text += ": another number of parameters";
          }
          break;
        case ContextLook::Result::StringEnd:
          text += side == "left" ? ", reached the beginning of the string" : ", reached the end of the string";
          break;
        case ContextLook::Result::LoneBracket:
          text += ", reached a bracket without partner";
          break;
      }
      line(text);
    }
  }

  // ---- names and values

  /// " with l = 1.5, n = 2": the formal parameters, then the variables of the condition.
  std::string valuesText(const CandidateRecord& candidate) const {
    std::vector<std::pair<std::string, double>> values;
    if (!candidate.formals.empty()) {
      const Production& production = *candidate.production;
      const auto addElements = [&](const std::vector<language::ContextElement>& context) {
        // nearest first in memory, the text reads from left to right
        for (const language::ContextElement& element : context) {
          addFormals(element.module, candidate.formals, values);
        }
      };
      for (const language::FormalModule& module : production.predecessor) {
        addFormals(module, candidate.formals, values);
      }
      addElements(production.leftContext);
      addElements(production.rightContext);
      addElements(production.newLeftContext);
      addElements(production.newRightContext);
    }
    values.insert(values.end(), candidate.variables.begin(), candidate.variables.end());
    std::string text;
    for (const auto& [name, value] : values) {
      text += (text.empty() ? " with " : ", ") + name + " = " + number(value);
    }
    return text;
  }

  /// The names are in the model's text: `A(l, w)`.
  void addFormals(const language::FormalModule& module, const std::vector<double>& formals,
                  std::vector<std::pair<std::string, double>>& values) const {
    const std::string text = formalText(module);
    std::size_t begin = text.find('(');
    for (std::size_t i = 0; i < program_.arity[module.type] && begin != std::string::npos; ++i) {
      const std::size_t end = text.find_first_of(",)", begin + 1);
      const std::string_view name = std::string_view(text).substr(begin + 1, end - begin - 1);
      const std::size_t first = name.find_first_not_of(" _");
      const std::size_t last = name.find_last_not_of(' ');
      if (first != std::string_view::npos && module.firstSlot + i < formals.size()) {
        values.emplace_back(name.substr(first, last - first + 1), formals[module.firstSlot + i]);
      }
      begin = end;
    }
  }

  [[nodiscard]] std::string formalText(const language::FormalModule& module) const {
    return sourceText(program_, module.range);
  }

  [[nodiscard]] std::string place(const Production& production) const {
    return core::placeText(program_.sourceMap.locate(production.range));
  }

  // ---- modules

  [[nodiscard]] std::string text(core::ModuleTypeId type, std::span<const double> parameters) const {
    ModuleString string;
    string.append(type, parameters);
    return toText(program_, string, core::NumberStyle::Shortest);
  }

  [[nodiscard]] std::string moduleAt(std::uint64_t index) const {
    const std::span<const core::ModuleTypeId> types = state_.string.types();
    std::uint64_t offset = 0;
    for (std::uint64_t i = 0; i < index; ++i) {
      offset += program_.arity[types[i]];
    }
    return text(types[index], state_.string.parameters().subspan(offset, program_.arity[types[index]]));
  }

  [[nodiscard]] std::string module(std::uint64_t index) const {
    return moduleAt(index) + " (module " + std::to_string(index) + ")";
  }

  [[nodiscard]] std::string shown(const ModuleString& string) const {
    if (string.empty()) {
      return "nothing";
    }
    const std::uint64_t count = std::min(string.size(), kShownModules);
    std::uint64_t parameters = 0;
    for (std::uint64_t i = 0; i < count; ++i) {
      parameters += program_.arity[string.types()[i]];
    }
    ModuleString part;
    part.appendAll(string.types().first(count), string.parameters().first(parameters));
    std::string text = toText(program_, part, core::NumberStyle::Shortest);
    if (count < string.size()) {
      text += " ... and " + std::to_string(string.size() - count) + " more";
    }
    return text;
  }

  const language::Program& program_;
  const PlantState& state_;
  const ModuleRecord& record_;
  std::string text_;
};

}  // namespace

tl::expected<std::string, core::SimulationError> explain(const language::Program& program, DerivationOptions options,
                                                         const PlantState& state, std::uint64_t module) {
  if (module >= state.string.size()) {
    core::SimulationError error;
    error.code = core::SimulationErrorCode::Model;
    error.step = state.step + 1;
    error.plant = options.plant;
    error.module = module;
    error.message = "there is no module " + std::to_string(module) + " in the string of step " +
                    std::to_string(state.step) + ": " +
                    (state.string.empty() ? std::string("it is empty")
                                          : "it has " + counted(state.string.size(), "module") + ", numbered 0 to " +
                                                std::to_string(state.string.size() - 1));
    return tl::unexpected(std::move(error));
  }
  options.messages = nullptr;
  Derivation derivation(program, std::move(options));
  PlantState copy = state;
  ModuleRecord record;
  record.module = module;
  std::optional<core::SimulationError> failure;
  try {
    derivation.deriveRecorded(copy, record);
  } catch (const core::SimulationFailure& caught) {
    failure = caught.error();
  }
  if (record.fate == ModuleRecord::Fate::NotReached && failure) {
    return tl::unexpected(*std::move(failure));
  }
  ESPALIER_CHECK(record.fate != ModuleRecord::Fate::NotReached);
  return Writer(program, state, record).run(failure);
}

}  // namespace espalier::derivation
