#include "engine/simulation/snapshot_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "engine/core/work_meter.h"
#include "engine/derivation/system_tables.h"

namespace espalier::simulation {
namespace {

using core::isFinite;

// steps are also numbers of the language, which are exact up to here
constexpr std::uint64_t kMostSteps = std::uint64_t{1} << 53U;
// as on the wire and on the command line
constexpr std::uint32_t kMostIterations = 10'000;
// a plant and its model have a shift of up to 1'000'000 each
constexpr std::int32_t kLargestColourShift = 2'000'000;
constexpr int kLargestColourBlock = 1'000'000;

template <typename Values>
bool areFinite(const Values& values) {
  return std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

bool isColourBlock(int block) {
  return std::abs(static_cast<std::int64_t>(block)) <= kLargestColourBlock;
}

std::string count(std::uint64_t number, const std::string& what) {
  return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

std::string problemOfMember(const Plant& member, std::uint64_t completedSteps) {
  const turtle::PlantPlacement& placement = member.origin.placement;
  if (!isFinite(placement.position) || !isFinite(placement.frame.heading) || !isFinite(placement.frame.left) ||
      !isFinite(placement.frame.up)) {
    return "its place is not finite";
  }
  if (std::abs(static_cast<std::int64_t>(member.origin.colourShift)) > kLargestColourShift) {
    return "its colour shift is beyond " + std::to_string(kLargestColourShift);
  }
  if (member.birthStep > completedSteps) {
    return "it is born after the last completed step";
  }
  if (!member.isAlive() && (member.deathStep <= member.birthStep || member.deathStep > completedSteps)) {
    return "it dies before its birth or after the last completed step";
  }
  return {};
}

std::string problemOfColours(const files::Palette& palette) {
  bool isRight = isColourBlock(palette.base);
  for (const auto& [block, colours] : palette.maps) {
    isRight = isRight && isColourBlock(block);
  }
  for (const auto& [block, materials] : palette.materials) {
    isRight = isRight && isColourBlock(block);
    for (const files::Material& material : materials) {
      isRight = isRight && areFinite(material.ambient) && areFinite(material.diffuse) && areFinite(material.emission) &&
                areFinite(material.specular) && std::isfinite(material.opacity) && std::isfinite(material.shininess);
    }
  }
  return isRight ? "" : "a colour is not finite, or its block does not exist";
}

std::string problemOfReplies(const turtle::ReplyBatch& replies) {
  if (replies.values.size() != replies.isSet.size()) {
    return "there are " + count(replies.values.size(), "reply value") + " and " + count(replies.isSet.size(), "mark") +
           " of which are set";
  }
  for (std::size_t k = 0; k < replies.values.size(); ++k) {
    if (replies.isSet[k] > 1 || (replies.isSet[k] == 1 && !std::isfinite(replies.values[k]))) {
      return "reply value " + std::to_string(k) + " is not a finite number";
    }
  }
  return {};
}

/// A plant that is dead keeps nothing but its counters.
std::string problemOfDead(const derivation::PlantState& plant) {
  const bool isEmpty = plant.string.size() == 0 && plant.string.parameterCount() == 0 && plant.statics.empty() &&
                       plant.instances.empty() && plant.files.open.empty() && plant.files.kept.empty();
  return isEmpty ? "" : "it is dead and has a string or variables";
}

/// Turns the types into the Program's.
std::string adoptString(derivation::PlantState& plant, const std::vector<core::ModuleTypeId>& typeOf,
                        const language::Program& program) {
  std::uint64_t parameterCount = 0;
  std::uint64_t module = 0;
  for (core::ModuleTypeId& type : plant.string.typeBuffer().span()) {
    if (type >= typeOf.size() || typeOf[type] == core::kNoModuleType) {
      return "module " + std::to_string(module) + " is of a type that the model does not have";
    }
    type = typeOf[type];
    parameterCount += program.arity[type];
    ++module;
  }
  if (parameterCount != plant.string.parameterCount()) {
    return "its modules have " + count(parameterCount, "parameter") + " and the snapshot holds " +
           std::to_string(plant.string.parameterCount());
  }
  // the compatible modes calculate with infinities and NaN, Espalier's own mode never stores one
  if (program.compatibility == core::Compatibility::Espalier && !areFinite(plant.string.parameters())) {
    return "a parameter is not a finite number";
  }
  return {};
}

std::string problemOfInstance(const derivation::InstanceState& instance, const language::Program& program) {
  if (instance.system >= program.systems.size()) {
    return "is of L-system " + std::to_string(instance.system) + ", and the model has " +
           std::to_string(program.systems.size());
  }
  const language::LSystem& system = program.systems[instance.system];
  if (instance.variables.size() != system.variables.size()) {
    return "has " + count(instance.variables.size(), "variable") + ", and its L-system has " +
           std::to_string(system.variables.size());
  }
  if (instance.elements.size() != system.arrayElementCount) {
    return "has " + count(instance.elements.size(), "array element") + ", and its L-system has " +
           std::to_string(system.arrayElementCount);
  }
  return {};
}

/// The L-systems whose variables go with a string: the main one, then one for each call of a sub-L-system in it.
/// Nothing for a call of an L-system that does not exist.
std::vector<std::optional<std::uint32_t>> systemsOf(const derivation::ModuleString& string,
                                                    const language::Program& program) {
  std::vector<std::optional<std::uint32_t>> systems{0};
  if (!program.hasSubSystems) {
    return systems;
  }
  std::size_t offset = 0;
  for (const core::ModuleTypeId type : string.types()) {
    if (derivation::isCall(program, type)) {
      const double label = std::trunc(string.parameters()[offset]);
      const auto found = std::find_if(program.systems.begin(), program.systems.end(), [label](const auto& system) {
        return static_cast<double>(system.label) == label;
      });
      const bool isKnown = found != program.systems.end();
      systems.push_back(isKnown ? std::optional(static_cast<std::uint32_t>(found - program.systems.begin()))
                                : std::nullopt);
    }
    offset += program.arity[type];
  }
  return systems;
}

std::string problemOfVariables(const derivation::PlantState& plant, const language::Program& program) {
  if (plant.statics.size() != program.staticCount) {
    return "it has " + count(plant.statics.size(), "production-local variable") + " and the model has " +
           std::to_string(program.staticCount);
  }
  const auto systems = systemsOf(plant.string, program);
  if (plant.instances.size() != systems.size()) {
    return "its string calls " + count(systems.size() - 1, "sub-L-system") + " and the snapshot holds " +
           count(plant.instances.size(), "set") + " of variables, one of them the main L-system's";
  }
  for (std::size_t i = 0; i < systems.size(); ++i) {
    if (std::string problem = problemOfInstance(plant.instances[i], program); !problem.empty()) {
      return "its set of variables " + std::to_string(i) + " " + problem;
    }
    if (plant.instances[i].system != systems[i]) {
      return "its set of variables " + std::to_string(i) + " is not of the L-system that the string calls";
    }
  }
  return {};
}

std::string problemOfFiles(const derivation::FileState& files, const language::Program& program,
                           const core::Limits& limits) {
  if (files.open.size() > limits.maximumOpenFiles) {
    return "it has " + count(files.open.size(), "open file") + ", more than " +
           std::to_string(limits.maximumOpenFiles) + " (limit openFiles)";
  }
  for (const derivation::OpenFile& file : files.open) {
    if (file.file >= program.files.size()) {
      return "it has opened a file that the model does not name";
    }
    const language::ModelFile& named = program.files[file.file];
    if (named.isRefused || (file.mode.canRead && !named.isRead) || (file.mode.canWrite && !named.isWritten)) {
      return "it has opened the file '" + named.name + "' as the model never does";
    }
    // a file that is only written has no content here that the position could miss
    const std::uint64_t end = named.isRead ? limits.maximumFileBytes : kMostSteps;
    if (file.position > end) {
      return "its position in the file '" + named.name + "' is beyond the end of any file";
    }
  }
  for (const derivation::KeptFile& file : files.kept) {
    if (file.file >= program.files.size() || !program.files[file.file].isRead || !program.files[file.file].isWritten) {
      return "it keeps the content of a file that the model does not both write and read";
    }
    if (file.text.size() > limits.maximumFileBytes) {
      return "the content of the file '" + program.files[file.file].name + "' has more than " +
             std::to_string(limits.maximumFileBytes) + " bytes (limit fileBytes)";
    }
  }
  return {};
}

std::string problemOfSteps(const derivation::PlantState& plant, const Plant& member, std::uint64_t completedSteps) {
  return plant.step > completedSteps - member.birthStep ? "it has made more steps than the simulation" : "";
}

/// All of one plant; the string first, because the calls in it say which variables there are.
std::string adoptPlant(derivation::PlantState& plant, const Plant& member, std::uint64_t completedSteps,
                       const std::vector<core::ModuleTypeId>& typeOf, const language::Program& program,
                       const core::Limits& limits) {
  if (!member.isAlive()) {
    return problemOfDead(plant);
  }
  std::string problem = problemOfSteps(plant, member, completedSteps);
  if (problem.empty()) {
    problem = adoptString(plant, typeOf, program);
  }
  if (problem.empty()) {
    problem = problemOfVariables(plant, program);
  }
  if (problem.empty()) {
    problem = problemOfFiles(plant.files, program, limits);
  }
  return problem;
}

/// The Program's types by the snapshot's: another build may number them otherwise.
std::vector<core::ModuleTypeId> typesIn(const language::Program& program, const SnapshotModel& model) {
  std::vector<core::ModuleTypeId> types;
  for (const auto& [name, arity] : model.types) {
    types.push_back(program.findType(name, arity));
  }
  return types;
}

}  // namespace

std::string problemOfRun(const SnapshotContent& content) {
  if (content.completedSteps > kMostSteps) {
    return "no run has " + std::to_string(content.completedSteps) + " steps";
  }
  if (content.members.empty()) {
    return "it has no plant";
  }
  for (std::size_t plant = 0; plant < content.members.size(); ++plant) {
    if (std::string problem = problemOfMember(content.members[plant], content.completedSteps); !problem.empty()) {
      return "plant " + std::to_string(plant) + ": " + problem;
    }
  }
  const SeedRules& seeds = content.seeds;
  const bool isAreaRight = !seeds.area || (isFinite((*seeds.area)[0]) && isFinite((*seeds.area)[1]));
  if (!isAreaRight || !std::isfinite(seeds.ground) || !std::isfinite(seeds.spacing) || seeds.spacing < 0.0) {
    return "the rules for seeds are not finite, or their spacing is below 0";
  }
  const Coupling& coupling = content.coupling;
  if (coupling.iterations < 1 || coupling.iterations > kMostIterations || !std::isfinite(coupling.tolerance) ||
      coupling.tolerance < 0.0) {
    return "the coupling needs 1 to " + std::to_string(kMostIterations) + " iterations and a tolerance of at least 0";
  }
  if (std::string problem = problemOfColours(content.palette); !problem.empty()) {
    return problem;
  }
  return problemOfReplies(content.replies);
}

std::string adoptPrograms(SnapshotContent& content, const Programs& programs, const core::Limits& limits) {
  if (content.models.size() != programs.size()) {
    return "The snapshot has " + count(content.models.size(), "model") + " and the simulation " +
           std::to_string(programs.size()) + ". Resume it without naming a model, or with the files it was made with.";
  }
  std::vector<std::vector<core::ModuleTypeId>> typesOf;
  for (std::size_t model = 0; model < programs.size(); ++model) {
    const language::Program& program = *programs[model];
    if (content.models[model].programHash != program.hash || content.compatibility != program.compatibility) {
      return "The snapshot was made with another model, other definitions or in another mode than '" +
             program.modelFile + "'. Resume it without naming a model, or with the files it was made with.";
    }
    typesOf.push_back(typesIn(program, content.models[model]));
  }
  for (std::size_t i = 0; i < content.plants.size(); ++i) {
    core::pollWork();
    const Plant& member = content.members[i];
    const std::string problem = adoptPlant(content.plants[i], member, content.completedSteps,
                                           typesOf[member.origin.model], *programs[member.origin.model], limits);
    if (!problem.empty()) {
      return "The snapshot does not fit its model: plant " + std::to_string(i) + ": " + problem +
             ". Use an intact copy, or the Espalier that made it.";
    }
  }
  return {};
}

std::optional<core::SimulationError> sizeErrorOf(const SnapshotContent& content, const core::Limits& limits) {
  std::uint64_t modules = 0;
  std::uint64_t bytes = 0;
  for (const derivation::PlantState& plant : content.plants) {
    modules += plant.string.size();
    bytes += plant.string.bytes();
  }
  std::string what;
  if (modules > limits.maximumModules) {
    what = std::to_string(limits.maximumModules) + " modules together (limit modules)";
  } else if (bytes > limits.maximumStringBytes) {
    what = std::to_string(limits.maximumStringBytes) + " bytes together (limit stringBytes)";
  } else {
    return std::nullopt;
  }
  return core::SimulationError{
      .code = core::SimulationErrorCode::LimitExceeded,
      .message = "The strings of the new state have more than " + what + ". Use a smaller state, or raise the limit."};
}

}  // namespace espalier::simulation
