#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "engine/core/check.h"
#include "engine/core/number_text.h"
#include "engine/turtle/export/text/mtg.h"
#include "engine/turtle/export/text/string_walk.h"
#include "engine/turtle/export/text_output.h"

namespace espalier::turtle {

namespace {

bool isEntity(std::string_view symbol) {
  return !symbol.empty() && isLetter(symbol.front());
}

// classes of an MTG are letters only
std::string classOf(std::string_view symbol) {
  std::string letters;
  std::copy_if(symbol.begin(), symbol.end(), std::back_inserter(letters), isLetter);
  return letters;
}

/// The facts that the writer needs before the first line.
struct MtgPlan {
  std::set<std::string> classes;  // of the entities that are modules
  std::string plantClass;
  std::string axisClass;
  std::string anchorClass;
  std::size_t deepest = 0;         // open brackets
  std::size_t parameterCount = 0;  // most of an entity
};

// the first letter of `wanted` that no module is called
std::string freeClass(const MtgPlan& plan, std::string_view wanted) {
  for (const char letter : wanted) {
    const std::string name(1, letter);
    if (!plan.classes.contains(name) && name != plan.plantClass && name != plan.axisClass) {
      return name;
    }
  }
  std::string name = "Free";
  while (plan.classes.contains(name) || name == plan.plantClass || name == plan.axisClass) {
    name += 'x';
  }
  return name;
}

// looks at the strings once; an error sentence when their brackets do not match
std::optional<std::string> plan(const ExportInput& input, MtgPlan& result) {
  for (std::size_t plant = 0; plant < input.strings.size(); ++plant) {
    std::vector<std::size_t> open;
    const language::Program& program = input.programOf(plant);
    const auto types = input.strings[plant]->types();
    for (std::size_t i = 0; i < types.size(); ++i) {
      if (types[i] == program.openBranch) {
        open.push_back(i);
        result.deepest = std::max(result.deepest, open.size());
      } else if (types[i] == program.closeBranch) {
        if (open.empty()) {
          return "module " + std::to_string(i) + " of plant " + std::to_string(plant) +
                 " closes a branch that none opened; an MTG has whole branches only";
        }
        open.pop_back();
      } else if (const std::string_view symbol = program.nameOf(types[i]); isEntity(symbol)) {
        result.classes.insert(classOf(symbol));
        result.parameterCount = std::max<std::size_t>(result.parameterCount, program.arity[types[i]]);
      }
    }
    if (!open.empty()) {
      return "the branch that module " + std::to_string(open.back()) + " of plant " + std::to_string(plant) +
             " opens is never closed; an MTG has whole branches only";
    }
  }
  result.plantClass = freeClass(result, "PQRSTUVWXY");
  result.axisClass = freeClass(result, "ABCDEFGHIJ");
  result.anchorClass = freeClass(result, "ZYXWVUTSRQ");
  return std::nullopt;
}

class MtgWriter {
 public:
  MtgWriter(const MtgPlan& plan, std::optional<std::uint64_t> step, core::ByteSink& sink)
      : plan_(plan), out_(sink), featureColumn_(plan.deepest + 2), step_(step) {}

  void writeHead();
  void add(const VisitedModule& module);
  void finishPlant();
  void writeEnd() {
    out_ << kMtgEnd << '\n';
    out_.flush();
  }

 private:
  void writeEntity(const std::string& entityClass, const VisitedModule* module);
  [[nodiscard]] std::string escaped(std::string_view text) const;

  /// An axis that is being written.
  struct Axis {
    bool hasEntity = false;
    std::uint64_t module = kNoModule;  // of its last entity with a module
    std::optional<core::Vec3> place;   // where its last entity ends; nothing: not known
  };
  static constexpr std::uint64_t kNoModule = ~std::uint64_t{0};

  const MtgPlan& plan_;
  TextOutput out_;
  std::size_t featureColumn_;
  std::vector<Axis> axes_;             // from the trunk to the axis at hand; empty: no plant yet
  std::string pending_;                // text since the last entity
  std::optional<TurtleRecord> state_;  // the last one known
  std::uint32_t plant_ = 0;
  std::uint64_t entityCount_ = 0;  // of the plant
  std::uint64_t axisCount_ = 0;    // of the plant
  std::optional<std::uint64_t> step_;
};

void MtgWriter::writeHead() {
  out_ << "CODE:\tFORM-A\n"
       << kMtgPromise
       << "\n\nCLASSES:\nSYMBOL\tSCALE\tDECOMPOSITION\tINDEXATION\tDEFINITION\n$\t0\tFREE\tFREE\tIMPLICIT\n"
       << plan_.plantClass << "\t1\tFREE\tFREE\tIMPLICIT\n"
       << plan_.axisClass << "\t2\tFREE\tFREE\tIMPLICIT\n";
  std::vector<std::string> classes(plan_.classes.begin(), plan_.classes.end());
  classes.push_back(plan_.anchorClass);
  for (const std::string& name : classes) {
    out_ << name << "\t3\tFREE\tFREE\tIMPLICIT\n";
  }
  out_ << "\nDESCRIPTION:\nLEFT\tRIGHT\tRELTYPE\tMAX\n" << plan_.axisClass << '\t' << plan_.axisClass << "\t+\t?\n";
  for (const std::string& left : classes) {
    for (const std::string& right : classes) {
      out_ << left << '\t' << right << "\t+\t?\n" << left << '\t' << right << "\t<\t?\n";
    }
  }
  out_ << "\nFEATURES:\nNAME\tTYPE\nText\tSTRING\nModule\tINT\n";
  std::string names = "Text\tModule";
  const auto add = [&](const std::string& name, std::string_view type) {
    out_ << name << '\t' << type << '\n';
    names += "\t" + name;
  };
  for (const char* const name : {"XX", "YY", "ZZ", "HX", "HY", "HZ", "Diameter"}) {
    add(name, "REAL");
  }
  add("Color", "INT");
  add("Order", "INT");
  add("Length", "REAL");
  add("Parent", "INT");
  add("Time", "INT");
  for (std::size_t i = 1; i <= plan_.parameterCount; ++i) {
    add("P" + std::to_string(i), "REAL");
  }
  out_ << "\nMTG:\nENTITY-CODE" << std::string(featureColumn_, '\t') << names << '\n';
}

std::string MtgWriter::escaped(std::string_view text) const {
  std::string result;
  for (const char c : text) {
    if (c == '#') {
      result += "\\x23";
    } else if (c == '\\') {
      result += "\\x5c";
    } else {
      result += c;
    }
  }
  return result;
}

void MtgWriter::writeEntity(const std::string& entityClass, const VisitedModule* module) {
  const std::size_t column = axes_.size();
  out_ << std::string(column, '\t');
  Axis& axis = axes_.back();
  if (axis.hasEntity) {
    out_ << "^<";
  } else {
    // the first entity of an axis stands behind the axis; that of the trunk has a line with the plant
    if (axes_.size() > 1) {
      out_ << '+' << plan_.axisClass << std::to_string(++axisCount_);
    }
    out_ << '/';
  }
  out_ << entityClass << std::to_string(++entityCount_) << std::string(featureColumn_ - column, '\t')
       << escaped(pending_) << '\t';
  axis.hasEntity = true;
  pending_.clear();
  if (module != nullptr) {
    out_ << std::to_string(module->index);
  }
  std::string numbers;
  const auto add = [&numbers](double value) {
    numbers.push_back('\t');
    core::appendNumber(numbers, value, core::NumberStyle::Shortest);
  };
  if (state_) {
    const core::Vec3& p = state_->position;
    const core::Vec3& h = state_->frame.heading;
    for (const double value : {p.x, p.y, p.z, h.x, h.y, h.z, state_->width}) {
      add(value);
    }
    numbers += "\t" + std::to_string(state_->colour);
  } else {
    numbers.append(8, '\t');
  }
  numbers += "\t" + std::to_string(axes_.size() - 1) + "\t";
  if (state_) {
    if (axis.place) {
      core::appendNumber(numbers, core::length(state_->position - *axis.place), core::NumberStyle::Shortest);
    }
    axis.place = state_->position;
  }
  numbers += "\t" + (axis.module == kNoModule ? std::string() : std::to_string(axis.module)) + "\t" +
             (step_ ? std::to_string(*step_) : std::string());
  if (module != nullptr) {
    axis.module = module->index;
  }
  if (module != nullptr) {
    for (const double parameter : module->parameters) {
      add(parameter);
    }
  }
  out_ << numbers << '\n';
}

void MtgWriter::add(const VisitedModule& module) {
  if (axes_.empty() || module.plant != plant_) {
    finishPlant();
    plant_ = module.plant;
    axisCount_ = 1;
    out_ << '/' << plan_.plantClass << std::to_string(plant_ + 1) << '/' << plan_.axisClass << "1\n";
    axes_.assign(1, {});
    entityCount_ = 0;
    state_.reset();
  }
  if (module.state != nullptr) {
    state_ = *module.state;
    if (!axes_.back().place && !isEntity(module.symbol)) {
      axes_.back().place = state_->position;
    }
  }
  const bool isPlain = module.parameters.empty();
  if (isPlain && (module.symbol == "[" || module.symbol == "]")) {
    // a branch joins an entity, and has one
    if (!pending_.empty() || !axes_.back().hasEntity) {
      writeEntity(plan_.anchorClass, nullptr);
    }
    if (module.symbol == "[") {
      // a branch begins where its axis has come to
      axes_.push_back({.hasEntity = false, .module = axes_.back().module, .place = axes_.back().place});
    } else {
      axes_.pop_back();
    }
    return;
  }
  appendModule(pending_, module.symbol, module.parameters, core::Compatibility::Espalier);
  if (isEntity(module.symbol)) {
    writeEntity(classOf(module.symbol), &module);
  }
}

void MtgWriter::finishPlant() {
  if (!axes_.empty() && (!pending_.empty() || !axes_.back().hasEntity)) {
    writeEntity(plan_.anchorClass, nullptr);
  }
  axes_.clear();
}

}  // namespace

std::optional<std::string> writeMtg(const ExportInput& input, const ExportTarget& target) {
  ESPALIER_CHECK(input.program != nullptr);
  MtgPlan known;
  if (auto problem = plan(input, known)) {
    return problem;
  }
  MtgWriter writer(known, input.step, target.sink);
  writer.writeHead();
  const auto problem =
      walkStrings(input, target.progress, [&writer](const VisitedModule& module) { writer.add(module); });
  writer.finishPlant();
  if (!problem) {
    writer.writeEnd();
  }
  return problem;
}

}  // namespace espalier::turtle
