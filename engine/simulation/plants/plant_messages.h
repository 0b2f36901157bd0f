#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/simulation_error.h"
#include "engine/core/streams.h"

namespace espalier::simulation {

/// The warnings and the printed text of plants, on their way to the caller. While plants are derived side by side their
/// messages are held, so that the caller receives them in the order of the plants.
class PlantMessages {
 public:
  /// A null sink drops every message.
  explicit PlantMessages(core::MessageSink sink) : sink_(std::move(sink)) {}

  [[nodiscard]] bool isWanted() const { return sink_ != nullptr; }
  /// Messages of different plants may come from different threads while they are held.
  void deliver(std::uint32_t plant, core::MessageKind kind, std::string_view text);

  /// From now on messages wait, by plant number below `plantCount`.
  void hold(std::size_t plantCount) { held_.assign(plantCount, {}); }
  /// Delivers the messages of these plants in this order, drops the others, and holds no further ones.
  void release(std::span<const std::size_t> plants);

 private:
  core::MessageSink sink_;
  std::vector<std::vector<std::pair<core::MessageKind, std::string>>> held_;  // by plant; empty: nothing is held
};

/// The error with the step at which the simulation stays at the end of its message.
[[nodiscard]] core::SimulationError sayingWhereItStays(core::SimulationError error, std::uint64_t completedSteps);

}  // namespace espalier::simulation
