#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clients/espalier/output/outputs.h"

namespace espalier::command {

/// Whether `--every` writes one file of all steps to `file` instead of one file a step: its format can hold a growth
/// animation and the name has no place for a number.
[[nodiscard]] bool isGrowthFile(const OutputOptions& options, const std::string& file);

/// The files of a run with --every that hold all its steps. They appear when the run is complete.
class GrowthOutputs {
 public:
  /// `options` must outlive the object; the steps go from `first` to `last`.
  GrowthOutputs(const OutputOptions& options, std::uint64_t first, std::uint64_t last);
  ~GrowthOutputs();
  GrowthOutputs(const GrowthOutputs&) = delete;
  GrowthOutputs& operator=(const GrowthOutputs&) = delete;

  /// Writes the present state as the next frame. Prints an error and returns false on a failure.
  [[nodiscard]] bool addFrame(const simulation::Simulation& simulation);
  /// Completes the files and gives them their names. Prints the names on standard error unless `isQuiet`.
  [[nodiscard]] bool finish(bool isQuiet);

 private:
  struct File;

  const OutputOptions& options_;
  std::vector<std::unique_ptr<File>> files_;
  std::uint64_t frameCount_ = 0;
};

}  // namespace espalier::command
