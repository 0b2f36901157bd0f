#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/files/colour_files.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/picture/picture.h"

namespace CLI {
class App;
}

namespace espalier::command {

/// What is written to files after or during a run, as told on the command line.
struct OutputOptions {
  std::vector<std::string> files;
  std::string format;  // of all files; empty: by their suffixes
  double detail = 1.0;
  bool isColouredByOrder = false;  // lines in the colours of the order in which they are drawn
  bool usesInstancing = false;     // glb: copies of a scene are one node
  turtle::PictureOptions picture;
};

/// -o, --format and what says how pictures and meshes look: --size, --background, --framing, --colours, --detail.
void addOutputOptions(CLI::App& command, OutputOptions& options, bool isOutputRequired);

/// Whether every file can be written at all, before a long run rather than after it: known format, existing folder. The
/// exit status, with an error written when it is not success.
[[nodiscard]] int checkOutputs(const OutputOptions& options);

/// The same, and that every format holds copies of scenes.
[[nodiscard]] int checkPlacedOutputs(const OutputOptions& options);

/// Writes copies of scenes to all files, each complete or not at all; `what` is what they show, for the note on
/// standard error: "20 plants". Detail, picture options, threads and instancing are those of the options. False, with
/// an error written, when one cannot be written.
[[nodiscard]] bool writePlacedFiles(const OutputOptions& options, std::span<turtle::ExportInput> scenes,
                                    std::span<const turtle::ScenePlacement> placements, const std::string& what,
                                    bool isQuiet);

/// The format of a file by --format or its suffix; null: a snapshot, or none of that name.
[[nodiscard]] const turtle::ExportFormat* formatOf(const OutputOptions& options, const std::string& file);

/// `file` with a number: in the place of its `%d` or `%04d`, or else before its suffix, `-` and as many digits as
/// given.
[[nodiscard]] std::string numberedName(const std::string& file, std::uint64_t number, int digits);

/// Writes the present state of a simulation to all files, or, with a number, to files of that number. Each appears
/// complete or not at all. Says on standard error what was written, or what went wrong.
class OutputWriter {
 public:
  /// `options` must outlive the object.
  OutputWriter(const OutputOptions& options, bool isQuiet) : options_(options), isQuiet_(isQuiet) {}

  [[nodiscard]] bool write(const simulation::Simulation& simulation, std::optional<std::uint64_t> number = std::nullopt,
                           int digits = 4) const;

 private:
  struct Drawn;
  [[nodiscard]] bool writeOne(const simulation::Simulation& simulation, const Drawn& drawn, const std::string& file,
                              const std::string& formatFrom) const;

  const OutputOptions& options_;
  bool isQuiet_;
};

}  // namespace espalier::command
