#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "clients/bmi/settings.h"
#include "engine/simulation/simulation.h"

namespace espalier::bmi {

/// A simulation with its environment, and what the interface asks of it. Everything that fails throws BmiError.
class SteppedModel {
 public:
  explicit SteppedModel(const Settings& settings);

  void step();
  /// Gives macros or variables of the model other values, from the next step on. Macros compile the model again.
  void set(const std::vector<std::pair<std::string, double>>& values);
  /// One of the values of `outputs`.
  [[nodiscard]] double output(const std::string& name) const;
  [[nodiscard]] double stepDays() const { return options_.world.stepDurationDays; }
  [[nodiscard]] std::uint64_t lastStep() const { return simulation_->derivationLength(); }

 private:
  using Environment = std::unique_ptr<turtle::EnvironmentProcess>;

  [[nodiscard]] std::unique_ptr<simulation::Simulation> simulationOf(
      std::shared_ptr<const language::Program> program) const;

  simulation::SimulationOptions options_;
  std::function<Environment()> makeEnvironment_;
  std::unique_ptr<simulation::Simulation> simulation_;
};

/// The environment that a configuration names, or else the model's own: that of `folderFile`, which starts no program.
/// Null: there is none.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makeEnvironmentOf(const Settings& settings,
                                                                            const std::string& folderFile,
                                                                            core::Compatibility compatibility);

}  // namespace espalier::bmi
