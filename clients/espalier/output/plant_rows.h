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

/// Grown plants in rows on the ground, as in a nursery, in one file. Equal plants share a mesh.
class PlantRows {
 public:
  /// Adds the plant of a simulation. A plant whose strings equal those of an earlier plant shares its mesh. Prints an
  /// error and returns false when the plant cannot be drawn.
  [[nodiscard]] bool add(const simulation::Simulation& simulation);

  /// Writes all plants in a square of rows with the distance `spacing`; 0: they just do not touch. In a mesh the rows
  /// stand behind each other; in a picture below each other, so that every plant is seen.
  [[nodiscard]] bool write(const OutputOptions& options, double spacing, bool isQuiet) const;

  [[nodiscard]] std::size_t plantCount() const { return kinds_.size(); }
  /// Number of different plants.
  [[nodiscard]] std::size_t kindCount() const { return grown_.size(); }

 private:
  struct Grown {
    std::shared_ptr<const language::Program> program;
    files::ViewSettings view;  // of all its models
    files::Palette palette;
    turtle::Scene scene;
    std::uint64_t hash = 0;  // of its strings
  };
  /// The size of the largest plant.
  struct Room {
    double width = 0.0;
    double height = 0.0;
  };
  [[nodiscard]] Room room() const;

  std::vector<std::unique_ptr<Grown>> grown_;  // unique_ptr: their addresses stay
  std::vector<std::uint32_t> kinds_;           // of each plant
};

}  // namespace espalier::command
