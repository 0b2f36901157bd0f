#include "clients/espalier/sweep/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "clients/espalier/sweep/shape_measures.h"
#include "clients/espalier/sweep/tree_measures.h"
#include "engine/core/diagnostic.h"

namespace espalier::command {
namespace {

using MeasureKind = MeasureDefinition::Kind;

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

bool isOverModules(MeasureKind kind) {
  return kind <= MeasureKind::Quantile;
}

// the statistic of a kind; `values` are in the order of the string, so that sums have one order
double statistic(const MeasureDefinition& measure, std::vector<double>& values) {
  const auto count = static_cast<double>(values.size());
  double sum = 0.0;
  for (const double value : values) {
    sum += value;
  }
  if (measure.kind == MeasureKind::Sum) {
    return sum;
  }
  if (values.empty() || (measure.kind == MeasureKind::Deviation && values.size() < 2)) {
    return kNoValue;
  }
  switch (measure.kind) {
    case MeasureKind::Mean:
      return sum / count;
    case MeasureKind::Minimum:
      return *std::min_element(values.begin(), values.end());
    case MeasureKind::Maximum:
      return *std::max_element(values.begin(), values.end());
    case MeasureKind::Deviation: {
      double squares = 0.0;
      for (const double value : values) {
        squares += (value - sum / count) * (value - sum / count);
      }
      return std::sqrt(squares / (count - 1.0));
    }
    default: {
      std::sort(values.begin(), values.end());
      const double place = measure.probability * (count - 1.0);
      const auto below = static_cast<std::size_t>(place);
      const std::size_t above = std::min(below + 1, values.size() - 1);
      return values[below] + (values[above] - values[below]) * (place - static_cast<double>(below));
    }
  }
}

std::size_t placeOf(const std::string& name, const std::vector<std::string_view>& names) {
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::vector<std::string> columnsOf(const MeasureDefinition& measure) {
  std::vector<std::string> names;
  if (measure.steps.empty()) {
    names.push_back(measure.name);
  }
  for (const std::uint64_t step : measure.steps) {
    names.push_back(measure.steps.size() == 1 ? measure.name : measure.name + "_" + std::to_string(step));
  }
  if (measure.kind != MeasureKind::Profile) {
    return names;
  }
  std::vector<std::string> bins;
  for (const std::string& name : names) {
    for (std::uint64_t bin = 1; bin <= measure.bins; ++bin) {
      bins.push_back(name + "_" + std::to_string(bin));
    }
  }
  return bins;
}

}  // namespace

/// A measure of the present step, and where its values go.
struct Measures::Wanted {
  const Measure* measure;
  std::size_t column;
  std::vector<double> values{};  // of the modules
};

Result<Measures> Measures::make(const std::vector<MeasureDefinition>& definitions, const language::Program& program,
                                const language::CompileInput& input, core::FileProvider& files) {
  Measures made;
  made.definitions_ = definitions;
  std::string problems;
  const auto complain = [&problems](const std::string& place, const std::string& sentence) {
    problems += (problems.empty() ? "" : "\n") + place + ": " + sentence;
  };
  std::vector<ModuleExpression> expressions;
  for (const MeasureDefinition& definition : definitions) {
    const std::string place = "measures." + definition.name;
    Measure measure{.definition = definition, .firstColumn = made.columns_.size(), .types = {}, .expression = kNone};
    for (const std::string& name : columnsOf(definition)) {
      made.columns_.push_back(name);
    }
    if (isOverModules(definition.kind) || !definition.of.empty()) {
      Result<ModulePattern> pattern = ModulePattern::read(definition.of);
      const std::string wrong = pattern ? pattern->problemIn(program) : pattern.error();
      if (!wrong.empty()) {
        complain(place, wrong);
        continue;
      }
      measure.types = pattern->typesOf(program);
      if (isOverModules(definition.kind) && (definition.kind != MeasureKind::Count || !definition.where.empty())) {
        measure.expression = expressions.size();
        expressions.push_back({place, *pattern, definition.expression, definition.where});
      }
    }
    const std::vector<std::string>& variables = program.systems.front().variables;
    switch (definition.kind) {
      case MeasureKind::Variable:
        measure.name = placeOf(definition.what, {variables.begin(), variables.end()});
        if (measure.name == variables.size()) {
          complain(place, "the model has no variable '" + definition.what + "'. " +
                              core::suggestName(definition.what, {variables.begin(), variables.end()}));
        }
        break;
      case MeasureKind::Plant:
        measure.name = placeOf(definition.what, shapeMeasureNames());
        break;
      case MeasureKind::Profile:
        measure.name = placeOf(definition.what, profileNames());
        break;
      case MeasureKind::Mtg:
        measure.name = placeOf(definition.what, treeMeasureNames());
        break;
      default:
        break;
    }
    made.measures_.push_back(std::move(measure));
  }
  if (!problems.empty()) {
    return problem(std::move(problems));
  }
  Result<ModuleExpressions> compiled = ModuleExpressions::compile(std::move(expressions), program, input, files);
  if (!compiled) {
    return problem(compiled.error());
  }
  made.expressions_ = std::make_shared<const ModuleExpressions>(std::move(*compiled));
  return made;
}

Result<Measures> Measures::remade(const language::Program& program, const language::CompileInput& input,
                                  core::FileProvider& files) const {
  if (expressions_->dependsOnMacros()) {
    return make(definitions_, program, input, files);
  }
  // only the numbers of the module types differ; a type that this Program does not have is of no module
  Measures made = *this;
  for (Measure& measure : made.measures_) {
    if (!measure.types.empty()) {
      measure.types = ModulePattern::read(measure.definition.of)->typesOf(program);
    }
    if (measure.definition.kind == MeasureKind::Variable) {
      const std::vector<std::string>& variables = program.systems.front().variables;
      measure.name = placeOf(measure.definition.what, {variables.begin(), variables.end()});
    }
  }
  return made;
}

bool Measures::areTakenAt(std::uint64_t step) const {
  return std::any_of(measures_.begin(), measures_.end(), [step](const Measure& measure) {
    const auto& steps = measure.definition.steps;
    return std::find(steps.begin(), steps.end(), step) != steps.end();
  });
}

std::optional<std::pair<std::string, std::uint64_t>> Measures::takenAfter(std::uint64_t last) const {
  for (const Measure& measure : measures_) {
    for (const std::uint64_t step : measure.definition.steps) {
      if (step > last) {
        return std::pair(measure.definition.name, step);
      }
    }
  }
  return std::nullopt;
}

void Measures::takeModules(const simulation::Simulation& simulation, const std::vector<Wanted>& wanted,
                           std::vector<double>& values) const {
  std::vector<Wanted> open;
  bool readsExpressions = false;
  for (const Wanted& one : wanted) {
    if (isOverModules(one.measure->definition.kind)) {
      open.push_back(one);
      readsExpressions = readsExpressions || one.measure->expression != kNone;
    }
  }
  if (open.empty()) {
    return;
  }
  const language::Program& program = simulation.program();
  const derivation::ModuleString& string = simulation.string();
  std::optional<ModuleExpressions::Reader> reader;
  if (readsExpressions) {
    reader.emplace(*expressions_, program, simulation.plantState(), simulation.options().messages);
  }
  std::vector<double> counts(open.size());
  std::size_t offset = 0;
  for (const core::ModuleTypeId type : string.types()) {
    const std::span<const double> parameters = string.parameters().subspan(offset, program.arity[type]);
    offset += program.arity[type];
    for (std::size_t i = 0; i < open.size(); ++i) {
      const Measure& measure = *open[i].measure;
      if (!measure.types[type]) {
        continue;
      }
      if (measure.expression == kNone) {
        counts[i] += 1.0;
      } else if (const auto value = reader->value(measure.expression, parameters)) {
        open[i].values.push_back(*value);
      }
    }
  }
  for (std::size_t i = 0; i < open.size(); ++i) {
    const MeasureDefinition& definition = open[i].measure->definition;
    values[open[i].column] = definition.kind != MeasureKind::Count  ? statistic(definition, open[i].values)
                             : open[i].measure->expression == kNone ? counts[i]
                                                                    : static_cast<double>(open[i].values.size());
  }
}

std::optional<core::SimulationError> Measures::take(const simulation::Simulation& simulation, bool isLast,
                                                    std::vector<double>& values) const {
  std::vector<Wanted> wanted;
  bool isDrawn = false;
  for (const Measure& measure : measures_) {
    const auto& steps = measure.definition.steps;
    for (std::size_t i = 0; i < steps.size(); ++i) {
      if (steps[i] == simulation.completedSteps()) {
        wanted.push_back({&measure, measure.firstColumn + i * measure.definition.width()});
      }
    }
    if (steps.empty() && isLast) {
      wanted.push_back({&measure, measure.firstColumn});
    }
  }
  for (const Wanted& one : wanted) {
    isDrawn = isDrawn || one.measure->definition.kind == MeasureKind::Plant ||
              one.measure->definition.kind == MeasureKind::Profile;
  }
  try {
    takeModules(simulation, wanted, values);
    std::optional<ShapeMeasures> shape;
    if (isDrawn) {
      auto scene = simulation.scene();
      if (!scene) {
        return std::move(scene.error());
      }
      shape.emplace(std::move(*scene), simulation.view());
    }
    for (const Wanted& one : wanted) {
      const MeasureDefinition& definition = one.measure->definition;
      double& value = values[one.column];
      if (definition.kind == MeasureKind::Plant) {
        value = shape->value(one.measure->name);
      } else if (definition.kind == MeasureKind::Profile) {
        const std::vector<double> bins =
            shape->profile(one.measure->name, definition.isAlongRadius, definition.bins, definition.to);
        std::copy(bins.begin(), bins.end(), values.begin() + static_cast<std::ptrdiff_t>(one.column));
      } else if (definition.kind == MeasureKind::Mtg) {
        value = TreeMeasures(simulation.program(), simulation.string(), one.measure->types)
                    .value(one.measure->name, definition.order);
      } else if (definition.kind == MeasureKind::Variable) {
        const std::vector<double>& variables = simulation.plantState().instances.front().variables;
        value = one.measure->name < variables.size() ? variables[one.measure->name] : kNoValue;
      }
    }
  } catch (const core::SimulationFailure& failure) {
    return failure.error();
  }
  return std::nullopt;
}

}  // namespace espalier::command
