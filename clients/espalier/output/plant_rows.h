#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "clients/espalier/output/outputs.h"
#include "engine/files/colour_files.h"
#include "engine/language/program.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::command {

/// Grown plants that stand in rows on the ground, as a nursery has them: in one file, equal ones with one mesh.
class PlantRows {
 public:
  /// Keeps what a simulation has grown, or notes that it grew what an earlier one did (its strings are
  /// equal). False, with an error written, when it cannot be drawn.
  [[nodiscard]] bool add(const simulation::Simulation& simulation);

  /// Writes all plants, in rows as square as can be along x and then z, `spacing` apart; 0: as far that they do not
  /// touch.
  [[nodiscard]] bool write(const OutputOptions& options, double spacing, bool isQuiet) const;

  [[nodiscard]] std::size_t plantCount() const { return kinds_.size(); }
  /// Different ones.
  [[nodiscard]] std::size_t kindCount() const { return grown_.size(); }

 private:
  struct Grown {
    std::shared_ptr<const language::Program> program;
    files::ViewSettings view;  // of all its models
    files::Palette palette;
    turtle::Scene scene;
    std::uint64_t hash = 0;  // of its strings
  };
  [[nodiscard]] double ownSpacing() const;

  std::vector<std::unique_ptr<Grown>> grown_;  // which do not move
  std::vector<std::uint32_t> kinds_;           // of each plant
};

}  // namespace espalier::command
