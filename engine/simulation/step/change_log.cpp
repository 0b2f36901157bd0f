#include "engine/simulation/step/change_log.h"

#include <algorithm>
#include <utility>

namespace espalier::simulation {

void ChangeLog::follow(ChangeReader reader, bool isWanted) {
  of(reader).isFollowed = isWanted;
  if (!isWanted) {
    forget(reader);
  }
}

bool ChangeLog::isFollowed() const {
  return std::any_of(readings_.begin(), readings_.end(), [](const Reading& reading) { return reading.isFollowed; });
}

void ChangeLog::add(std::size_t plant, const derivation::StepChanges& changes) {
  for (Reading& reading : readings_) {
    if (plant < reading.changes.size()) {
      reading.changes[plant].join(changes, joined_);
      std::swap(reading.changes[plant], joined_);
    }
  }
}

void ChangeLog::forget() {
  forget(ChangeReader::Views);
  forget(ChangeReader::Queries);
}

void ChangeLog::forget(ChangeReader reader) {
  of(reader).isKnown = false;
  of(reader).changes.clear();
}

std::vector<derivation::StepChanges> ChangeLog::take(ChangeReader reader,
                                                     const std::vector<derivation::PlantState>& plants) {
  Reading& reading = of(reader);
  std::vector<derivation::StepChanges> changes = std::exchange(reading.changes, {});
  changes.resize(plants.size());
  if (reading.isFollowed) {
    for (const derivation::PlantState& plant : plants) {
      reading.changes.push_back(derivation::StepChanges::nothing(plant.string.size()));
    }
    reading.isKnown = true;
  }
  return changes;
}

}  // namespace espalier::simulation
