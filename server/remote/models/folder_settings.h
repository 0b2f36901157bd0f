#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/files/animation_file.h"
#include "engine/files/colour_files.h"
#include "engine/simulation/simulation.h"
#include "server/remote/models/model_files.h"

namespace espalier::server {

/// The settings of a model folder beside its model: the colours of pictures, and the last step. The command line and
/// the server both take it from here.
struct FolderSettings {
  files::Palette palette;                             // empty: the folder has no colours
  std::optional<files::AnimationSettings> animation;  // nothing: the derivation length decides
};

/// Reads the colour and animation files of a model. The animation file is used when the command of the folder has the
/// switch -a, or with `isAnimated`. `diagnostics` names every file that is not used, with the consequence.
[[nodiscard]] FolderSettings readFolderSettings(const ModelFiles& model, bool isAnimated, core::FileProvider& files,
                                                core::DiagnosticList& diagnostics);

/// The step of the last frame of the animation, of a model with so many steps; nothing: there is no animation.
[[nodiscard]] std::optional<std::uint64_t> lastFrameOf(const FolderSettings& folder, std::uint64_t derivationLength);

/// The last step of a run: `steps` when given, else the last frame of the animation; nothing: the derivation length.
/// The simulation is at step 0 or later.
[[nodiscard]] std::optional<std::uint64_t> lastStepOf(const FolderSettings& folder, std::optional<std::uint64_t> steps,
                                                      const simulation::Simulation& simulation);

/// Whether a run up to step `last` (nothing: the derivation length) is over: the step is complete, or the model has
/// stopped.
[[nodiscard]] bool isOver(const simulation::Simulation& simulation, std::optional<std::uint64_t> last);

}  // namespace espalier::server
