#include "engine/simulation/snapshot_editing.h"

#include <algorithm>
#include <cmath>

#include "engine/core/diagnostic.h"
#include "engine/core/work_meter.h"
#include "engine/simulation/snapshot_content.h"

namespace espalier::simulation {
namespace {

tl::unexpected<core::SimulationError> modelError(std::string message) {
  core::SimulationError error;
  error.code = core::SimulationErrorCode::Model;
  error.message = std::move(message);
  return tl::unexpected(std::move(error));
}

std::string bytesOf(const SnapshotContent& content) {
  core::StringSink sink;
  writeSnapshot(content, sink);
  return sink.take();
}

/// Finds module types by name and arity as the snapshot numbers them.
class Types {
 public:
  explicit Types(const SnapshotModel& model) : model_(&model) {}

  [[nodiscard]] std::uint16_t arity(core::ModuleTypeId type) const { return model_->types[type].second; }
  [[nodiscard]] bool isOpening(core::ModuleTypeId type) const { return isNamed(type, "["); }
  [[nodiscard]] bool isClosing(core::ModuleTypeId type) const { return isNamed(type, "]"); }
  [[nodiscard]] std::size_t count() const { return model_->types.size(); }
  [[nodiscard]] core::ModuleTypeId find(const EditedModule& module) const {
    for (std::size_t i = 0; i < model_->types.size(); ++i) {
      if (model_->types[i].first == module.symbol && model_->types[i].second == module.parameters.size()) {
        return static_cast<core::ModuleTypeId>(i);
      }
    }
    return core::kNoModuleType;
  }
  /// All types as people write them.
  [[nodiscard]] std::string list() const {
    std::string text;
    for (const auto& [name, arity] : model_->types) {
      text += (text.empty() ? "" : ", ") + name;
      text += arity == 0 ? "" : " with " + std::to_string(arity) + (arity == 1 ? " parameter" : " parameters");
    }
    return text;
  }

 private:
  [[nodiscard]] bool isNamed(core::ModuleTypeId type, std::string_view name) const {
    return model_->types[type].first == name && model_->types[type].second == 0;
  }

  const SnapshotModel* model_;
};

/// The first module behind the part that is pruned at `begin`.
std::uint64_t endOfPruned(std::span<const core::ModuleTypeId> string, const Types& types, std::uint64_t begin) {
  const bool isBranch = types.isOpening(string[begin]);
  std::uint64_t depth = 0;
  for (std::uint64_t i = begin; i < string.size(); ++i) {
    if (types.isOpening(string[i])) {
      ++depth;
    } else if (types.isClosing(string[i])) {
      if (depth == 0) {
        return i;  // of the branch that the pruned part is in: it stays
      }
      if (--depth == 0 && isBranch) {
        return i + 1;
      }
    }
  }
  return string.size();
}

/// The reason why the modules cannot be put in, or an empty text. Fills `chosen` with their types.
std::string problemOf(const std::vector<EditedModule>& modules, const Types& types,
                      std::vector<core::ModuleTypeId>& chosen) {
  std::uint64_t depth = 0;
  for (const EditedModule& module : modules) {
    core::pollWork();
    const core::ModuleTypeId type = types.find(module);
    if (type == core::kNoModuleType) {
      return "The model has no module '" + module.symbol + "' with " + std::to_string(module.parameters.size()) +
             " parameters. It has " + types.list() + ".";
    }
    if (module.symbol == "?" && !module.parameters.empty()) {
      return "A call of a sub-L-system cannot be put in: its variables would be missing.";
    }
    if (std::any_of(module.parameters.begin(), module.parameters.end(), [](double x) { return !std::isfinite(x); })) {
      return "A parameter of '" + module.symbol + "' is NaN or infinite. Give finite numbers.";
    }
    if (types.isClosing(type) && depth-- == 0) {
      return "The modules close a branch that they do not open. Give as many '[' as ']', each '[' first.";
    }
    depth += types.isOpening(type) ? 1U : 0U;
    chosen.push_back(type);
  }
  return depth == 0 ? "" : "The modules open a branch that they do not close. Give as many ']' as '['.";
}

/// Reads a snapshot whose strings may be changed.
tl::expected<SnapshotContent, core::SimulationError> readForEditing(std::string_view snapshot) {
  auto read = readSnapshot(snapshot, false);
  if (read && (read->hasReplies || read->isAnswered)) {
    return modelError(
        "The environment has answered already for a step that could not be completed. Make that step first, or go "
        "back to a snapshot.");
  }
  return read;
}

}  // namespace

EditedSnapshot editString(std::string_view snapshot, const StringEdit& edit) {
  auto read = readForEditing(snapshot);
  if (!read) {
    return tl::unexpected(std::move(read.error()));
  }
  SnapshotContent& content = *read;
  if (edit.plant >= content.plants.size()) {
    return modelError("There is no plant " + std::to_string(edit.plant) + "; there are " +
                      std::to_string(content.plants.size()) + ", numbered from 0.");
  }
  const Plant& member = content.members[edit.plant];
  if (!member.isAlive()) {
    return modelError("Plant " + std::to_string(edit.plant) + " is dead since step " +
                      std::to_string(member.deathStep) + ".");
  }
  const Types types(content.models[member.origin.model]);
  derivation::PlantState& plant = content.plants[edit.plant];
  if (plant.instances.size() > 1) {
    return modelError("A model with sub-L-systems cannot be edited: their variables are counted along the string.");
  }
  const std::span<const core::ModuleTypeId> old = plant.string.types();
  const bool isInserting = edit.kind == StringEdit::Kind::Insert;
  if (edit.module > old.size() || (!isInserting && edit.module == old.size())) {
    return modelError("There is no module " + std::to_string(edit.module) + "; the string has " +
                      std::to_string(old.size()) + ", numbered from 0.");
  }
  if (std::any_of(old.begin(), old.end(), [&](core::ModuleTypeId type) { return type >= types.count(); })) {
    return tl::unexpected(snapshotError("The snapshot is damaged: a module has no type."));
  }
  std::vector<core::ModuleTypeId> chosen;
  if (std::string problem = problemOf(edit.modules, types, chosen); !problem.empty()) {
    return modelError(std::move(problem));
  }
  std::uint64_t end = edit.module;
  if (edit.kind == StringEdit::Kind::Prune) {
    if (types.isClosing(old[edit.module])) {
      return modelError("Module " + std::to_string(edit.module) + " is the end of a branch. Prune one before it.");
    }
    end = endOfPruned(old, types, edit.module);
  } else if (edit.kind == StringEdit::Kind::Replace) {
    if (types.isOpening(old[edit.module]) || types.isClosing(old[edit.module])) {
      return modelError("Module " + std::to_string(edit.module) + " is a bracket and cannot be replaced. Prune it.");
    }
    ++end;
  }

  // the parameters before and behind the change
  std::uint64_t before = 0;
  std::uint64_t removed = 0;
  for (std::uint64_t i = 0; i < end; ++i) {
    (i < edit.module ? before : removed) += types.arity(old[i]);
  }
  const std::span<const double> parameters = plant.string.parameters();
  if (before + removed > parameters.size()) {
    return tl::unexpected(snapshotError("The snapshot is damaged: parameters are missing."));
  }
  derivation::ModuleString changed;
  changed.appendAll(old.first(edit.module), parameters.first(before));
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    core::pollWork();
    changed.append(chosen[i], edit.modules[i].parameters);
  }
  changed.appendAll(old.subspan(end), parameters.subspan(before + removed));
  plant.string.swap(changed);
  return bytesOf(content);
}

EditedSnapshot setVariables(std::string_view snapshot, const Programs& programs,
                            const std::vector<std::pair<std::string, double>>& values) {
  auto read = readForEditing(snapshot);
  if (!read) {
    return tl::unexpected(std::move(read.error()));
  }
  SnapshotContent& content = *read;
  // a variable of several models is changed in the plants of all of them
  for (const auto& [name, value] : values) {
    if (!std::isfinite(value)) {
      return modelError("The value of '" + name + "' is NaN or infinite. Give a finite number.");
    }
    std::vector<std::string_view> known;
    bool isFound = false;
    for (std::size_t model = 0; model < programs.size() && model < content.models.size(); ++model) {
      const std::vector<std::string>& names = programs[model]->systems.front().variables;
      known.insert(known.end(), names.begin(), names.end());
      const auto found = std::find(names.begin(), names.end(), name);
      if (found == names.end()) {
        continue;
      }
      isFound = true;
      const auto slot = static_cast<std::size_t>(found - names.begin());
      for (std::size_t i = 0; i < content.plants.size(); ++i) {
        if (content.members[i].origin.model != model || !content.members[i].isAlive()) {
          continue;
        }
        derivation::PlantState& plant = content.plants[i];
        if (plant.instances.empty() || slot >= plant.instances.front().variables.size()) {
          return tl::unexpected(snapshotError("The snapshot does not fit the model: it has other variables."));
        }
        plant.instances.front().variables[slot] = value;
      }
    }
    if (!isFound) {
      return modelError("The model has no variable '" + name + "'. " + core::suggestName(name, known));
    }
  }
  return bytesOf(content);
}

EditedSnapshot withPrograms(std::string_view snapshot, const Programs& programs) {
  auto read = readForEditing(snapshot);
  if (!read) {
    return tl::unexpected(std::move(read.error()));
  }
  SnapshotContent& content = *read;
  for (std::size_t model = 0; model < programs.size() && model < content.models.size(); ++model) {
    content.models[model].programHash = programs[model]->hash;
    content.models[model].defines = programs[model]->defines;
  }
  return bytesOf(content);
}

}  // namespace espalier::simulation
