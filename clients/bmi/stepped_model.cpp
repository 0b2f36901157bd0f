#include "clients/bmi/stepped_model.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <variant>

#include "clients/bmi/espalier_bmi.h"
#include "engine/core/number_text.h"
#include "engine/language/compiler.h"
#include "engine/language/redefinition.h"
#include "engine/simulation/snapshot_editing.h"
#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "server/remote/control_group.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/gallery.h"
#include "server/remote/models/model_files.h"
#include "server/remote/translation/translate.h"

namespace espalier::bmi {
namespace {

void orThrow(const std::optional<core::SimulationError>& error) {
  if (error) {
    throw BmiError(error->message);
  }
}

std::shared_ptr<const language::Program> orThrow(language::CompileResult result) {
  for (const core::Diagnostic& diagnostic : result.diagnostics.entries()) {
    if (diagnostic.severity == core::Severity::Error) {
      throw BmiError(core::formatDiagnostic(diagnostic));
    }
  }
  if (!result.program) {
    throw BmiError("the model could not be read: check that its file is readable.");
  }
  return std::move(result.program);
}

server::ModelFiles filesOf(const Settings& settings) {
  std::error_code unused;
  const std::string path = settings.isGallery ? server::galleryOfProgram() + "/" + settings.model : settings.model;
  if (!std::filesystem::exists(path, unused)) {
    throw BmiError(settings.isGallery
                       ? "there is no model '" + settings.model + "' in the gallery '" + server::galleryOfProgram() +
                             "'."
                       : "there is no file or folder '" + path + "': 'model' names one beside the configuration.");
  }
  server::FoundModel found = server::findModelFiles(path);
  if (!found) {
    throw BmiError(found.error());
  }
  // a configuration with the name of the model is not its environment
  if (!found->environment.empty() && std::filesystem::equivalent(found->environment, settings.file, unused)) {
    found->environment.clear();
  }
  return std::move(*found);
}

/// The world that a file says, with the table of weather that it names.
turtle::World worldOf(const std::string& file, const std::string& text) {
  server::DiskFileProvider files;
  const auto orFail = [&file](auto read) {
    if (!read) {
      throw BmiError(file + ": " + read.error().message);
    }
    return std::move(*read);
  };
  if (const auto problem = protocol::jsonProblem(text)) {
    throw BmiError(file + ": " + *problem);
  }
  const auto message = protocol::decodeMessage(R"({"jsonrpc":"2.0","method":"file","params":)" + text + "}");
  if (!message) {
    throw BmiError(file + ": " + message.error().error.message);
  }
  protocol::WorldRecord record = orFail(protocol::decodeWorld(message->payload));
  if (!record.weather.empty()) {
    auto table = files.read((std::filesystem::path(file).parent_path() / record.weather).string());
    if (!table) {
      throw BmiError(file + ": there is no table of weather '" + record.weather + "': check 'weather'.");
    }
    if (table->empty()) {  // which would mean no weather
      throw BmiError(file + ": the table of weather '" + record.weather + "' is empty: check 'weather'.");
    }
    record.weather = std::move(*table);
  }
  auto world = server::toWorld(record);
  if (!world) {
    throw BmiError(file + ": " + world.error());
  }
  return std::move(*world);
}

/// The world of a model: that of its folder, with the step of the configuration. A file beside others has none.
turtle::World worldOf(const server::ModelFiles& found, const Settings& settings) {
  turtle::World world;
  if (found.isFolder) {
    const std::string file = (std::filesystem::path(found.model).parent_path() / "world.json").string();
    if (const auto text = server::DiskFileProvider().read(file)) {
      world = worldOf(file, *text);
    }
  }
  world.stepDurationDays = settings.stepDurationDays.value_or(world.stepDurationDays);
  return world;
}

bool hasVariable(const language::Program& program, const std::string& name) {
  const auto& names = program.systems.front().variables;
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string textOf(double value) {
  std::string text;
  core::appendNumber(text, value, core::NumberStyle::Shortest);
  return text;
}

std::string orThrow(simulation::EditedSnapshot edited) {
  if (!edited) {
    throw BmiError(edited.error().message);
  }
  return std::move(*edited);
}

}  // namespace

SteppedModel::SteppedModel(const Settings& settings) {
  const server::ModelFiles found = filesOf(settings);
  server::DiskFileProvider files;
  language::CompileInput input;
  input.modelFile = found.model;
  input.viewFile = found.view;
  input.defines = settings.parameters;
  std::shared_ptr<const language::Program> program = orThrow(language::compile(input, files));
  makeEnvironment_ = [settings, folderFile = found.environment, compatibility = program->compatibility] {
    return makeEnvironmentOf(settings, folderFile, compatibility);
  };
  options_.seed = settings.seed;
  options_.world = worldOf(found, settings);
  options_.hasSeed = true;
  options_.derivationLength = settings.derivationLength;
  options_.threads = server::processorCount();
  simulation_ = simulationOf(std::move(program));
  orThrow(simulation_->rewind());
}

std::unique_ptr<simulation::Simulation> SteppedModel::simulationOf(
    std::shared_ptr<const language::Program> program) const {
  return std::make_unique<simulation::Simulation>(std::move(program), std::vector<turtle::PlantPlacement>(1),
                                                  makeEnvironment_(), options_);
}

void SteppedModel::step() {
  orThrow(simulation_->step());
}

void SteppedModel::set(const std::vector<std::pair<std::string, double>>& values) {
  const auto program = simulation_->programs().front();
  std::vector<std::pair<std::string, double>> variables;
  std::vector<std::pair<std::string, std::string>> definitions;
  for (const auto& [name, value] : values) {
    if (hasVariable(*program, name)) {
      variables.emplace_back(name, value);
    } else if (language::definesName(*program, name)) {
      definitions.emplace_back(name, textOf(value));
    } else {
      throw BmiError("the model has neither a variable nor a #define '" + name + "'.");
    }
  }
  core::StringSink saved;
  simulation_->save(saved);
  std::string snapshot = saved.take();
  if (definitions.empty()) {
    orThrow(simulation_->restore(orThrow(simulation::setVariables(snapshot, simulation_->programs(), variables))));
    return;
  }
  const simulation::Programs programs{orThrow(language::withDefinitions(*program, definitions, options_.limits))};
  snapshot = orThrow(simulation::withPrograms(snapshot, programs));
  if (!variables.empty()) {
    snapshot = orThrow(simulation::setVariables(snapshot, programs, variables));
  }
  auto fresh = simulationOf(programs.front());
  orThrow(fresh->restore(snapshot));
  simulation_ = std::move(fresh);
}

double SteppedModel::output(const std::string& name) const {
  const std::size_t first = name.find(':');
  const std::size_t second = first == std::string::npos ? first : name.find(':', first + 1);
  const std::string kind = name.substr(0, first);
  if (name == "modules") {
    std::size_t modules = 0;
    for (std::size_t plant = 0; plant < simulation_->plantCount(); ++plant) {
      modules += simulation_->string(plant).size();
    }
    return static_cast<double>(modules);
  }
  const bool isCount = kind == "count" && first != std::string::npos && second == std::string::npos;
  std::size_t place = 0;
  if (kind == "sum" && second != std::string::npos) {
    for (std::size_t i = second + 1; i < name.size() && place < 1000; ++i) {
      const bool isDigit = name[i] >= '0' && name[i] <= '9';
      place = isDigit ? 10 * place + static_cast<std::size_t>(name[i] - '0') : 1000;
    }
  }
  const bool isSum = place > 0 && place < 1000;
  if (name != "height" && !isCount && !isSum) {
    throw BmiError("there is no output '" + name + "'. Outputs: modules, height, count:SYMBOL, sum:SYMBOL:PARAMETER.");
  }
  const auto drawn = simulation_->turtleRecords();
  if (!drawn) {
    throw BmiError(drawn.error().message);
  }
  const auto& records = *drawn;
  const std::string symbol = first == std::string::npos ? "" : name.substr(first + 1, second - first - 1);
  double value = 0.0;
  bool isFirst = true;
  for (const turtle::TurtleRecord& record : records) {
    if (name == "height") {
      value = isFirst ? record.position.y : std::max(value, record.position.y);
      isFirst = false;
    } else if (simulation_->symbolNames()[record.symbol] == symbol) {
      value += isCount ? 1.0 : record.parameters.size() >= place ? record.parameters[place - 1] : 0.0;
    }
  }
  return value;
}

}  // namespace espalier::bmi
