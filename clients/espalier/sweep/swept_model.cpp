#include "clients/espalier/sweep/swept_model.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <limits>
#include <new>

#include "engine/core/diagnostic.h"
#include "engine/core/number_text.h"
#include "engine/language/compiler.h"
#include "engine/language/dialects/dialect.h"
#include "engine/language/preprocess/preprocessor.h"

namespace espalier::command {
namespace {

using ParameterKind = SweepParameter::Kind;

// variants that are kept; a plan whose macros differ in every run needs none
constexpr std::size_t kMostVariants = 64;

std::string numberText(double value) {
  std::string text;
  core::appendNumber(text, value, core::NumberStyle::Shortest);
  return text;
}

std::string hexText(std::uint64_t value) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text(16, '0');
  for (std::size_t i = 16; i-- > 0; value >>= 4U) {
    text[i] = kDigits[value & 15U];
  }
  return text;
}

std::vector<std::string> warningsOf(const language::CompileResult& compiled) {
  std::vector<std::string> warnings;
  for (const core::Diagnostic& diagnostic : compiled.diagnostics.entries()) {
    if (diagnostic.severity == core::Severity::Warning) {
      warnings.push_back(core::formatDiagnostic(diagnostic));
    }
  }
  return warnings;
}

/// Discards the files of the model.
class NoFiles final : public core::FileWriter {
 public:
  [[nodiscard]] std::optional<std::string> write(const std::string&, bool, std::string_view) override {
    return std::nullopt;
  }
};

}  // namespace

/// Each file is read once, so that a file that changes during the sweep changes no run.
class SweptModel::Sources final : public core::FileProvider {
 public:
  explicit Sources(core::FileProvider& files) : files_(files) {}

  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    return kept(name, [&] { return files_.read(name); });
  }
  [[nodiscard]] std::optional<std::string> readInside(const std::string& folder, const std::string& name) override {
    return kept("\n" + folder + "\n" + name, [&] { return files_.readInside(folder, name); });
  }

 private:
  template <typename Read>
  std::optional<std::string> kept(const std::string& key, const Read& read) {
    const std::scoped_lock lock(mutex_);
    const auto found = texts_.find(key);
    return found != texts_.end() ? found->second : texts_.emplace(key, read()).first->second;
  }

  core::FileProvider& files_;
  std::mutex mutex_;
  std::map<std::string, std::optional<std::string>> texts_;
};

SweptModel::SweptModel(SweepInput input, core::FileProvider& files)
    : input_(std::move(input)), sources_(std::make_shared<Sources>(files)) {}

language::CompileInput SweptModel::inputFor(std::span<const double> row) const {
  language::CompileInput input = input_.model;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (input_.plan.parameters[i].kind == ParameterKind::Define) {
      input.defines.emplace_back(input_.plan.parameters[i].target, numberText(row[i]));
    }
  }
  return input;
}

Result<std::shared_ptr<const ModelVariant>> SweptModel::compile(std::span<const double> row) const {
  const language::CompileInput input = inputFor(row);
  const language::CompileResult compiled = language::compile(input, *sources_);
  if (!compiled.program) {
    for (const core::Diagnostic& diagnostic : compiled.diagnostics.entries()) {
      if (diagnostic.severity == core::Severity::Error) {
        return problem(core::formatDiagnostic(diagnostic));
      }
    }
    return problem("'" + input.modelFile + "' could not be read: check that it is readable");
  }
  auto measures = first_ ? first_->measures.remade(*compiled.program, input, *sources_)
                         : Measures::make(input_.plan.measures, *compiled.program, input, *sources_);
  if (!measures) {
    return problem(measures.error());
  }
  const std::vector<std::string> warnings = warningsOf(compiled);
  const auto isKnown = [this](const std::string& warning) {
    return std::find(knownWarnings_.begin(), knownWarnings_.end(), warning) != knownWarnings_.end();
  };
  const auto unknown = std::find_if_not(warnings.begin(), warnings.end(), isKnown);
  return std::make_shared<const ModelVariant>(
      ModelVariant{compiled.program, std::move(*measures), unknown == warnings.end() ? std::string() : *unknown});
}

std::optional<std::string> SweptModel::findParameters(const language::Program& program) {
  const std::vector<std::string> macros =
      language::preprocess({.file = language::splitEntry(input_.model.modelFile, *sources_).file,
                            .macros = {},
                            .overrides = input_.model.defines,
                            .limits = input_.model.limits},
                           *sources_)
          .macros;
  const std::vector<std::string>& variables = program.systems.front().variables;
  const auto contains = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  std::string problems;
  for (SweepParameter& parameter : input_.plan.parameters) {
    const bool isUnknown = parameter.kind == ParameterKind::Unknown;
    const bool isMacro = contains(macros, parameter.target);
    const bool isVariable = contains(variables, parameter.target);
    if (isUnknown && parameter.target.starts_with('/')) {
      parameter.kind = ParameterKind::Environment;
    } else if (isUnknown && (isMacro || isVariable)) {
      parameter.kind = isMacro ? ParameterKind::Define : ParameterKind::Variable;
    } else if (isUnknown || (parameter.kind == ParameterKind::Define && !isMacro) ||
               (parameter.kind == ParameterKind::Variable && !isVariable)) {
      std::vector<std::string_view> names;
      if (parameter.kind != ParameterKind::Variable) {
        names.insert(names.end(), macros.begin(), macros.end());
      }
      if (parameter.kind != ParameterKind::Define) {
        names.insert(names.end(), variables.begin(), variables.end());
      }
      const std::string what = isUnknown                                 ? "#define and no variable"
                               : parameter.kind == ParameterKind::Define ? "#define"
                                                                         : "variable";
      problems += (problems.empty() ? "" : "\n") + ("parameters." + parameter.name) + ": the model has no " + what +
                  " '" + parameter.target + "'. " +
                  (names.empty() ? "It has none: write the number that changes as a #define"
                                 : core::suggestName(parameter.target, names));
    }
  }
  return problems.empty() ? std::nullopt : std::optional(problems);
}

// a measure after the last step that the model has; parameters that are macros may change the number of steps
std::optional<std::string> SweptModel::findLateMeasures() const {
  const Plan& plan = input_.plan;
  const bool isLengthKnown =
      !plan.steps && std::none_of(plan.parameters.begin(), plan.parameters.end(), [](const SweepParameter& parameter) {
        return parameter.kind == ParameterKind::Define;
      });
  const std::uint64_t length = first_->program->derivationLength;
  const auto late = isLengthKnown ? first_->measures.takenAfter(length) : std::nullopt;
  if (!late) {
    return std::nullopt;
  }
  return "measures." + late->first + ".at: there is no step " + std::to_string(late->second) +
         ": the derivation length of the model is " + std::to_string(length) +
         ". Give a step up to that, or more steps with the plan's member 'steps'";
}

Result<std::unique_ptr<SweptModel>> SweptModel::make(SweepInput input, std::span<const double> firstRow,
                                                     core::FileProvider& files) {
  std::unique_ptr<SweptModel> model(new SweptModel(std::move(input), files));
  // without the parameters: their names are found in the model
  const language::CompileResult plain = language::compile(model->input_.model, *model->sources_);
  if (!plain.program) {
    return problem(model->compile({}).error());
  }
  model->knownWarnings_ = warningsOf(plain);
  if (const auto mistake = model->findParameters(*plain.program)) {
    return problem(*mistake);
  }
  if (const auto mistake = SweptEnvironment(model->input_.configuration, model->input_.environmentMaker)
                               .check(model->input_.plan.parameters)) {
    return problem(*mistake);
  }
  Result<std::shared_ptr<const ModelVariant>> first = model->compile(firstRow);
  if (!first) {
    return problem(first.error());
  }
  model->first_ = *first;
  model->identity_ = std::string(ESPALIER_VERSION) + " " + hexText(plain.program->hash) + " " +
                     model->input_.configuration + (model->input_.worldText.empty() ? "" : " ") +
                     model->input_.worldText;
  if (const auto slots = model->variableSlots(*model->first_->program); !slots) {
    return problem(slots.error());
  }
  if (const auto mistake = model->findLateMeasures()) {
    return problem(*mistake);
  }
  return model;
}

Result<std::vector<std::size_t>> SweptModel::variableSlots(const language::Program& program) const {
  std::vector<std::size_t> slots;
  for (const SweepParameter& parameter : input_.plan.parameters) {
    if (parameter.kind == ParameterKind::Variable) {
      const auto& variables = program.systems.front().variables;
      const auto found = std::find(variables.begin(), variables.end(), parameter.target);
      if (found == variables.end()) {
        return problem("the model has no variable '" + parameter.target + "' with these values of its #define");
      }
      slots.push_back(static_cast<std::size_t>(found - variables.begin()));
    }
  }
  return slots;
}

Result<std::shared_ptr<const ModelVariant>> SweptModel::variantFor(std::span<const double> row) {
  std::vector<double> key;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (input_.plan.parameters[i].kind == ParameterKind::Define) {
      key.push_back(row[i]);
    }
  }
  if (key.empty()) {
    return first_;
  }
  {
    const std::scoped_lock lock(mutex_);
    const auto found =
        std::find_if(variants_.begin(), variants_.end(), [&](const auto& entry) { return entry.first == key; });
    if (found != variants_.end()) {
      variants_.splice(variants_.begin(), variants_, found);
      return found->second;
    }
  }
  Result<std::shared_ptr<const ModelVariant>> made = compile(row);
  if (made) {
    const std::scoped_lock lock(mutex_);
    variants_.emplace_front(std::move(key), *made);
    if (variants_.size() > kMostVariants) {
      variants_.pop_back();
    }
  }
  return made;
}

ModelRunner::ModelRunner(SweptModel& model)
    : model_(model), environment_(model.input().configuration, model.input().environmentMaker) {}

// the Program with the macros and start values of a row; an error sentence, or nothing
std::optional<std::string> ModelRunner::prepareVariant(std::span<const double> row) {
  Result<std::shared_ptr<const ModelVariant>> variant = model_.variantFor(row);
  if (!variant) {
    return variant.error();
  }
  std::vector<double> values;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (model_.plan().parameters[i].kind == ParameterKind::Variable) {
      values.push_back(row[i]);
    }
  }
  if (variant_ != *variant) {
    simulation_.reset();
    startValues_.reset();
    variant_ = *variant;
    warning_ = variant_->warning;
    if (!values.empty()) {
      const Result<std::vector<std::size_t>> slots = model_.variableSlots(*variant_->program);
      if (!slots) {
        variant_.reset();
        return slots.error();
      }
      startValues_.emplace(*variant_->program, *slots);
    }
  }
  if (startValues_) {
    startValues_->set(values);
  }
  return std::nullopt;
}

// the environment with the settings of a row; an error sentence, or nothing
std::optional<std::string> ModelRunner::prepareEnvironment(std::span<const double> row) {
  std::vector<std::pair<std::string, double>> settings;
  for (std::size_t i = 0; i < row.size(); ++i) {
    if (model_.plan().parameters[i].kind == ParameterKind::Environment) {
      settings.emplace_back(model_.plan().parameters[i].target, row[i]);
    }
  }
  const Result<bool> isAnother = environment_.prepare(settings);
  if (!isAnother) {
    return isAnother.error();
  }
  if (*isAnother) {
    simulation_.reset();
  }
  return std::nullopt;
}

// a simulation for a row, whatever its seed
std::optional<std::string> ModelRunner::prepare(std::span<const double> row) {
  if (auto mistake = prepareVariant(row)) {
    return mistake;
  }
  if (auto mistake = prepareEnvironment(row)) {
    return mistake;
  }
  if (!simulation_) {
    simulation::SimulationOptions options;
    options.name = "sweep";
    options.derivationLength = model_.plan().steps;
    options.limits = model_.input().model.limits;
    options.palette = model_.input().palette;
    options.world = model_.input().world;
    options.fileWriter = std::make_shared<NoFiles>();
    options.messages = [this](core::MessageKind kind, std::string_view text) {
      if (kind == core::MessageKind::Warning && warning_.empty()) {
        warning_ = text;
      }
    };
    simulation_ = std::make_unique<simulation::Simulation>(startValues_ ? startValues_->program() : variant_->program,
                                                           std::vector<turtle::PlantPlacement>(1), environment_.lend(),
                                                           std::move(options));
  }
  return std::nullopt;
}

// grows the plant of the prepared simulation and takes its measures; the sentence about a failure, or nothing
std::string ModelRunner::grow(std::uint64_t seed, std::uint64_t run, const PlantVisitor& visit,
                              std::vector<double>& values) {
  simulation::Simulation& simulation = *simulation_;
  const Measures& measures = variant_->measures;
  std::optional<core::SimulationError> failure = simulation.rewind(seed);
  while (!failure) {
    const bool isLast = simulation.isFinished();
    if (isLast || measures.areTakenAt(simulation.completedSteps())) {
      failure = model_.plan().isAnswered ? simulation.answer() : std::nullopt;
      if (!failure) {
        failure = measures.take(simulation, isLast, values);
      }
    }
    if (isLast || failure) {
      break;
    }
    failure = simulation.step();
  }
  const auto late = measures.takenAfter(simulation.completedSteps());
  if (!failure && late && warning_.empty()) {
    warning_ = "measures." + late->first + ".at: the run has ended with step " +
               std::to_string(simulation.completedSteps()) + ", so that there is no value of step " +
               std::to_string(late->second);
  }
  if (failure) {
    return (failure->message.starts_with("step ") ? "" : "step " + std::to_string(failure->step) + ": ") +
           failure->message;
  }
  return visit ? visit(simulation, run).value_or("") : "";
}

RunOutcome ModelRunner::run(std::span<const double> row, std::uint64_t seed, std::uint64_t run,
                            const PlantVisitor& visit) {
  const auto begin = std::chrono::steady_clock::now();
  constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
  RunOutcome outcome;
  outcome.values.assign(model_.measureColumns().size(), kNotMeasured);
  warning_.clear();
  try {
    const std::optional<std::string> mistake = prepare(row);
    outcome.error = mistake ? *mistake : grow(seed, run, visit, outcome.values);
  } catch (const std::bad_alloc&) {
    outcome.error = "there is not enough memory: use fewer workers, or a limit of the plan";
  } catch (const std::exception& error) {
    outcome.error = std::string("this is a bug of Espalier, please report it: ") + error.what();
  }
  if (!outcome.error.empty()) {
    // its memory may be large
    simulation_.reset();
    outcome.values.assign(outcome.values.size(), kNotMeasured);
  }
  outcome.warning = std::move(warning_);
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return outcome;
}

}  // namespace espalier::command
