#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "clients/espalier/model_files.h"
#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/files/animation_file.h"
#include "engine/files/colour_files.h"
#include "engine/simulation/simulation.h"

namespace espalier::command {

/// What a model folder says beside its model: the colours of pictures, and which step is the last.
struct FolderSettings {
  files::Palette palette;                             // empty: the folder has no colours
  std::optional<files::AnimationSettings> animation;  // nothing: the derivation length decides
};

/// Reads the colour and animation files of a model. The animation file counts when the folder's command has the switch
/// -a or `isAnimated`; one that a folder has and does not count is named. What cannot be used is in `diagnostics` with
/// its consequence.
[[nodiscard]] FolderSettings readFolderSettings(const ModelFiles& model, bool isAnimated, core::FileProvider& files,
                                                core::DiagnosticList& diagnostics);

/// The step to go to: `steps` when given, else the last frame of the animation; nothing: to the derivation length. The
/// simulation is at step 0 or later.
[[nodiscard]] std::optional<std::uint64_t> lastStepOf(const FolderSettings& folder, std::optional<std::uint64_t> steps,
                                                      const simulation::Simulation& simulation);

/// Whether a run to `last` (nothing: to the derivation length) is over: it is there, or the model has stopped itself.
[[nodiscard]] bool isOver(const simulation::Simulation& simulation, std::optional<std::uint64_t> last);

}  // namespace espalier::command
