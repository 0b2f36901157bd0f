#pragma once

#include <string>
#include <vector>

#include "clients/espalier/output/outputs.h"

namespace espalier::command {

/// A picture of many plants: one cell each, with its name below. Every cell shows its plant as large as possible.
class ContactSheet {
 public:
  /// `options` must outlive the object. Its size is that of a cell.
  explicit ContactSheet(const OutputOptions& options) : options_(options) {}

  /// Adds the present state of a simulation. False, with a message: it cannot be drawn.
  [[nodiscard]] bool add(const simulation::Simulation& simulation, const std::string& name);
  /// Adds an empty cell for a model that failed.
  void addFailed(const std::string& name);
  /// Writes the sheet to every output file.
  [[nodiscard]] bool write(bool isQuiet) const;

 private:
  struct Cell {
    turtle::PictureImage image;  // without pixels: the model failed
    std::string name;
  };
  [[nodiscard]] turtle::PictureImage assembled() const;

  const OutputOptions& options_;
  std::vector<Cell> cells_;
};

/// Checks that all files are pictures of points (.png) that can be written; a usage error else.
[[nodiscard]] int checkSheetOutputs(const OutputOptions& options);

/// Sets the size of a cell when the command line gives none.
void setCellSize(OutputOptions& options);

}  // namespace espalier::command
