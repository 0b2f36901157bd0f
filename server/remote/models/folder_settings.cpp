#include "server/remote/models/folder_settings.h"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

#include "engine/files/data_file.h"

namespace espalier::server {
namespace {

void remark(core::Severity severity, const std::string& file, std::string message, core::DiagnosticList& diagnostics) {
  core::Diagnostic diagnostic;
  diagnostic.severity = severity;
  diagnostic.location.file = file;
  diagnostic.message = std::move(message);
  diagnostics.add(std::move(diagnostic));
}

std::optional<files::AnimationSettings> readAnimation(const std::string& file, core::FileProvider& files,
                                                      core::DiagnosticList& diagnostics) {
  std::optional<std::string> text = files.read(file);
  if (!text) {
    remark(core::Severity::Warning, file,
           "the animation file cannot be read; the derivation length decides which step is last", diagnostics);
    return std::nullopt;
  }
  files::AnimationSettings settings = files::readAnimationFile(files::DataFile(file, *text, diagnostics));
  const bool moves = std::any_of(settings.intervals.begin(), settings.intervals.end(), [](const auto& interval) {
    return interval.motion != files::FrameInterval::Motion::None;
  });
  if (moves) {
    remark(core::Severity::Note, file, "pictures ignore the rotations and scalings of its frame intervals",
           diagnostics);
  }
  return settings;
}

}  // namespace

FolderSettings readFolderSettings(const ModelFiles& model, bool isAnimated, core::FileProvider& files,
                                  core::DiagnosticList& diagnostics) {
  FolderSettings folder;
  files::FolderCommand command;
  command.colours = model.colours;
  command.colourBase = model.colourBase;
  folder.palette = files::readPalette(command, files, diagnostics);

  const bool usesAnimation = isAnimated || model.startsInAnimation;
  if (usesAnimation && model.animation.empty()) {
    remark(core::Severity::Warning, model.model,
           "the model has no animation file; the derivation length decides which step is last", diagnostics);
  } else if (usesAnimation) {
    folder.animation = readAnimation(model.animation, files, diagnostics);
  } else if (model.isFolder && !model.animation.empty()) {
    remark(core::Severity::Note, model.animation,
           "the animation file is not read without --animate or the switch -a; the derivation length decides which "
           "step is last",
           diagnostics);
  }
  return folder;
}

std::optional<std::uint64_t> lastFrameOf(const FolderSettings& folder, std::uint64_t derivationLength) {
  if (!folder.animation) {
    return std::nullopt;
  }
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max());
  const auto length = static_cast<std::int64_t>(std::min(derivationLength, kMost));
  return static_cast<std::uint64_t>(files::finalFrame(*folder.animation, length).derivedSteps);
}

std::optional<std::uint64_t> lastStepOf(const FolderSettings& folder, std::optional<std::uint64_t> steps,
                                        const simulation::Simulation& simulation) {
  return steps ? steps : lastFrameOf(folder, simulation.derivationLength());
}

bool isOver(const simulation::Simulation& simulation, std::optional<std::uint64_t> last) {
  if (!last) {
    return simulation.isFinished();
  }
  // finished before its derivation length: the model called stop()
  return simulation.completedSteps() >= *last ||
         (simulation.isFinished() && simulation.completedSteps() < simulation.derivationLength());
}

}  // namespace espalier::server
