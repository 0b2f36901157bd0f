#include "engine/simulation/plants/plant_messages.h"

namespace espalier::simulation {

void PlantMessages::deliver(std::uint32_t plant, core::MessageKind kind, std::string_view text) {
  if (!held_.empty()) {
    held_[plant].emplace_back(kind, text);
  } else if (sink_) {
    sink_(kind, text);
  }
}

void PlantMessages::release(std::span<const std::size_t> plants) {
  const auto held = std::exchange(held_, {});
  for (const std::size_t plant : plants) {
    for (const auto& [kind, text] : held[plant]) {
      sink_(kind, text);
    }
  }
}

core::SimulationError sayingWhereItStays(core::SimulationError error, std::uint64_t completedSteps) {
  constexpr std::string_view kStays = "The simulation stays at step ";
  if (error.message.find(kStays) == std::string::npos) {
    error.message += error.message.ends_with('.') ? " " : ". ";
    error.message += std::string(kStays) + std::to_string(completedSteps) + ".";
  }
  return error;
}

}  // namespace espalier::simulation
