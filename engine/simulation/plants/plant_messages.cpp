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

}  // namespace espalier::simulation
