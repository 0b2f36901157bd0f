#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "engine/core/streams.h"
#include "engine/core/vec3.h"
#include "engine/derivation/state/module_string.h"
#include "engine/files/colour_files.h"
#include "engine/files/view_settings.h"
#include "engine/language/program.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

struct PictureOptions;

/// Receives the turtle's state after each module of a string (InterpretationOutput::onModule).
using ModuleVisitor = std::function<void(const TurtleRecord&, std::uint64_t first)>;

struct RsmlLabels;  // text/rsml.h

/// A scene and its strings to export. Everything referred to must outlive the export.
struct ExportInput {
  const Scene& scene;
  const files::ViewSettings& view;             // surfaces, contours, camera: of the model that drew the scene
  const files::Palette* palette = nullptr;     // a model folder's colours; null or empty: Espalier's own
  std::span<const TurtleRecord> records = {};  // of the same interpretation
  double detail = 1.0;   // factor of the sides and subdivisions of meshes: a half is a coarser level of detail
  unsigned threads = 1;  // that make meshes: nothing in a file depends on them
  // glb: equal organs of a plant, and copies of a scene, are one node (EXT_mesh_gpu_instancing)
  bool usesInstancing = false;
  bool isBackground = false;                // of a fitted picture: it takes no part in the extent
  const PictureOptions* picture = nullptr;  // for pictures; null: the defaults. Its palette is not looked at
  std::optional<std::uint64_t> step = {};   // of the strings, for messages
  std::string_view lengthUnit = {};         // of all lengths; empty: unknown
  double stepDurationDays = 1.0;
  const RsmlLabels* rsml = nullptr;                               // of lines that come from a file of roots; null: none
  const language::Program* program = nullptr;                     // of the strings
  std::span<const language::Program* const> programs = {};        // of each string; empty: all are of `program`
  std::span<const derivation::ModuleString* const> strings = {};  // of the plants, for formats of modules
  std::span<const std::span<const std::uint64_t>> births = {};  // by plant, by module: step in which it came; empty or
                                                                // above `step`: not known
  /// Interprets the strings once more and visits their modules; an error sentence when that fails.
  std::function<std::optional<std::string>(const ModuleVisitor&)> visitModules = {};

  [[nodiscard]] const language::Program& programOf(std::size_t plant) const {
    return programs.empty() ? *program : *programs[plant];
  }
};

/// Where a copy of a scene stands: its point p comes to position + scale · (p turned about the y axis).
struct ScenePlacement {
  std::uint32_t scene = 0;  // index into PlacedScenes::scenes
  core::Vec3 position{};
  double turnRadians = 0.0;  // from the z axis toward the x axis: counter-clockwise seen from above
  double scale = 1.0;        // above 0

  [[nodiscard]] bool isIdentity() const { return position == core::Vec3{} && turnRadians == 0.0 && scale == 1.0; }
};

/// Copies of a few scenes, as a forest of a few grown trees. Camera, lights, page colour, picture options and threads
/// are those of the first scene; each scene has its own colours, textures and level of detail.
struct PlacedScenes {
  std::span<const ExportInput> scenes;
  std::span<const ScenePlacement> placements;
};

/// The source that a format needs.
enum class ExportSource : std::uint8_t {
  Scene,    // ExportInput::scene
  Modules,  // program, strings, visitModules; the scene may be empty
};

/// Receives the progress of an export: parts written and parts in all. Called from time to time and with the last part,
/// by one thread at a time, which need not be the caller's.
using ExportProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

/// Calls a progress function, if there is one, at every 4096th part and at the last.
inline void reportProgress(const ExportProgress& progress, std::uint64_t done, std::uint64_t total) {
  if (progress && (done % 4096 == 0 || done == total)) {
    progress(done, total);
  }
}

/// Where an export goes. Its sinks get their bytes from one thread at a time, which need not be the caller's.
struct ExportTarget {
  std::string fileName;  // without folders; its companions are named after it
  core::ByteSink& sink;
  /// Opens a further file beside the first, as the `.mtl` of an `.obj`; `name` has no folders. The sink stays open
  /// until the export has ended. Without it companions are not written and not referred to.
  std::function<core::ByteSink&(const std::string& name)> openCompanion;
  ExportProgress progress;  // may be empty
};

/// The frames of a growth animation: the steps firstStep, firstStep + every, … up to lastStep.
struct GrowthRange {
  std::uint64_t firstStep = 0;
  std::uint64_t lastStep = 0;
  std::uint64_t every = 1;
};

/// A file that takes one frame after another.
class GrowthExport {
 public:
  virtual ~GrowthExport() = default;
  /// Writes the scene of a step; steps must ascend. Returns an error sentence, or nothing on success.
  [[nodiscard]] virtual std::optional<std::string> addFrame(const ExportInput& input, std::uint64_t step) = 0;
  /// Ends the file; to be called once, after the last frame.
  virtual void finish() = 0;
};

/// A file format that a scene can be written in. A writer streams to the target and never holds a second copy of the
/// scene; the same input gives the same bytes. It returns an error sentence, or nothing on success.
struct ExportFormat {
  std::string_view name;     // as in `--format`
  std::string_view suffix;   // with its point, lower case
  std::string_view summary;  // a few words
  std::optional<std::string> (*write)(const ExportInput& input, const ExportTarget& target);
  /// Begins a file that holds a whole growth animation; null: the format has one scene a file. `target` must outlive
  /// the result.
  std::unique_ptr<GrowthExport> (*beginGrowth)(const ExportTarget& target, const GrowthRange& range) = nullptr;
  ExportSource source = ExportSource::Scene;
  /// Writes copies of scenes, at least one scene; null: the format holds one scene as it is. A scene that is placed
  /// several times is in the file once where the format has shared meshes (glb), and never twice in memory.
  std::optional<std::string> (*writePlaced)(const PlacedScenes& placed, const ExportTarget& target) = nullptr;
};

/// All formats, the table that the command line lists.
[[nodiscard]] std::span<const ExportFormat> exportFormats();

/// The format of that name; null: there is none.
[[nodiscard]] const ExportFormat* findExportFormat(std::string_view name);

/// The format whose suffix a file's name ends in, in upper or lower case; null: there is none.
[[nodiscard]] const ExportFormat* findExportFormatOfFile(std::string_view fileName);

/// `fileName` with its suffix replaced by `suffix` (with its point).
[[nodiscard]] std::string withSuffix(std::string_view fileName, std::string_view suffix);

}  // namespace espalier::turtle
