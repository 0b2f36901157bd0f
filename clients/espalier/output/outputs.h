#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/rendering/render.h"
#include "engine/files/colour_files.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/picture/picture.h"

namespace CLI {
class App;
}

namespace espalier::command {

/// Options of the command line about output files.
struct OutputOptions {
  std::vector<std::string> files;
  std::string format;  // of all files; empty: by their suffixes
  double detail = 1.0;
  bool isColouredByOrder = false;  // lines in the colours of the order in which they are drawn
  bool usesInstancing = false;     // glb: copies of a scene are one node
  turtle::PictureOptions picture;
  RenderOptions render;         // of PNG files; the camera of the others does not change
  std::uint64_t turntable = 0;  // pictures of one turn of the plant; 0: it stands still
  std::string lengthUnit;       // of the plants; empty: that of the world, unless it is the default
  std::shared_ptr<const turtle::RsmlLabels> rootLabels;  // of a model that is a file of roots; null: none
};

/// Adds -o, --format and the options for pictures and meshes: --size, --background, --framing, --colours, --render and
/// its options, --detail. `options` must outlive the runs.
/// `arePlaced`: the files hold several plants, so only formats that can are listed.
void addOutputOptions(CLI::App& command, OutputOptions& options, bool isOutputRequired, bool arePlaced = false);

/// Checks before a long run that every file can be written: known format, existing folder. Returns the exit status;
/// prints an error when it is not success.
[[nodiscard]] int checkOutputs(const OutputOptions& options);

/// The same. Also checks that every format can hold copies of scenes.
[[nodiscard]] int checkPlacedOutputs(const OutputOptions& options);

/// Writes copies of scenes to all files, each complete or not at all. `what` describes them in the note on standard
/// error: "20 plants". Prints an error and returns false when a file cannot be written.
[[nodiscard]] bool writePlacedFiles(const OutputOptions& options, std::span<turtle::ExportInput> scenes,
                                    std::span<const turtle::ScenePlacement> placements, const std::string& what,
                                    bool isQuiet);

/// Writes a picture to a PNG file. `what` describes it in the note on standard error.
[[nodiscard]] bool writePicture(const OutputOptions& options, const turtle::PictureImage& picture,
                                const std::string& file, const std::string& what, bool isQuiet);

/// Whether pictures are seen by viewToRender().
[[nodiscard]] bool movesViewer(const OutputOptions& options);

/// The unit of a simulation's lengths as files say it; empty: no one has said it.
[[nodiscard]] std::string_view lengthUnitOf(const OutputOptions& options, const simulation::Simulation& simulation);

/// The format of a file by --format or its suffix; null: a snapshot, or none of that name.
[[nodiscard]] const turtle::ExportFormat* formatOf(const OutputOptions& options, const std::string& file);

/// `file` with a number: in place of `%d` or `%04d`, else as `-` and at least `digits` digits before the suffix.
[[nodiscard]] std::string numberedName(const std::string& file, std::uint64_t number, int digits);

/// Writes the present state of a simulation to all files; with a number, to files with that number. Each file appears
/// complete or not at all. Prints the names of written files, or an error, on standard error.
class OutputWriter {
 public:
  /// `options` must outlive the object.
  OutputWriter(const OutputOptions& options, bool isQuiet) : options_(options), isQuiet_(isQuiet) {}

  [[nodiscard]] bool write(const simulation::Simulation& simulation, std::optional<std::uint64_t> number = std::nullopt,
                           int digits = 4) const;
  /// The bytes of a PNG file of the present state. Prints an error and returns nothing when it cannot be drawn.
  [[nodiscard]] std::optional<std::string> picture(const simulation::Simulation& simulation) const;

 private:
  struct Drawn;
  [[nodiscard]] std::optional<Drawn> drawn(const simulation::Simulation& simulation) const;
  [[nodiscard]] bool writeOne(const simulation::Simulation& simulation, const Drawn& drawn, const std::string& file,
                              const std::string& formatFrom) const;
  /// Returns an error sentence, or nothing on success.
  [[nodiscard]] std::optional<std::string> exportTo(const simulation::Simulation& simulation, const Drawn& drawn,
                                                    const turtle::ExportFormat& format,
                                                    const turtle::ExportTarget& target) const;
  /// Says once that a mesh of a scene far from 0 is coarse.
  void warnIfFar(const turtle::Scene& scene, const files::ViewSettings& view, const turtle::ExportFormat& format) const;

  const OutputOptions& options_;
  bool isQuiet_;
  mutable bool hasWarned_ = false;
};

}  // namespace espalier::command
