#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/simulation_error.h"
#include "engine/simulation/plants_view.h"
#include "engine/turtle/interpretation/record_chain.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::simulation {

/// Draws the views of one simulation, one after the other, while the simulation goes on. It keeps what all of them
/// need, and the records of the last view that was told as a chain. One thread at a time; no function changes a view.
class ViewDrawing {
 public:
  ViewDrawing();
  ~ViewDrawing();

  /// From now on this view is drawn.
  void show(std::shared_ptr<const PlantsView> view);
  [[nodiscard]] const PlantsView& view() const;
  /// Forgets the view, and the memory that it shares with the simulation.
  void close();

  /// The functions below give for the view what symbolNames, view, stringText, scene and turtleRecords give for a
  /// Simulation.
  [[nodiscard]] const std::vector<std::string>& symbolNames() const;
  [[nodiscard]] const files::ViewSettings& settings() const;
  [[nodiscard]] std::string stringText(std::size_t plant) const;
  [[nodiscard]] tl::expected<turtle::Scene, core::SimulationError> scene();
  [[nodiscard]] tl::expected<std::vector<turtle::TurtleRecord>, core::SimulationError> turtleRecords();
  /// Does what Simulation::visitModules does.
  [[nodiscard]] std::optional<core::SimulationError> visitModules(
      const std::function<void(const turtle::TurtleRecord&, std::uint64_t first)>& visit);
  /// The records as a chain of stretches. It shares with the chain of an earlier view what has not changed since. Null
  /// when the models' drawings are not repeatable (record_chain.h).
  [[nodiscard]] tl::expected<std::shared_ptr<const turtle::RecordChain>, core::SimulationError> recordChain();
  /// The next chain is made without an earlier one.
  void forgetChain();

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace espalier::simulation
