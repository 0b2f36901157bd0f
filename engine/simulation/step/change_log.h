#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/derivation/state/plant_state.h"
#include "engine/derivation/state/step_changes.h"

namespace espalier::simulation {

/// The readers that ask what has happened to the strings since they last looked: the views of a simulation, and the
/// pass that puts the queries.
enum class ChangeReader : std::uint8_t { Views, Queries };

/// Joins what happens to the strings of plants between two looks of a reader at them: answers, steps, edits, restores.
class ChangeLog {
 public:
  void follow(ChangeReader reader, bool isWanted);
  /// By any reader.
  [[nodiscard]] bool isFollowed() const;
  /// Whether the reader called take() before and nothing was forgotten since.
  [[nodiscard]] bool isKnown(ChangeReader reader) const { return of(reader).isKnown; }

  /// The string of a plant has changed.
  void add(std::size_t plant, const derivation::StepChanges& changes);
  /// The plants have become others.
  void forget();
  void forget(ChangeReader reader);
  /// By plant: the changes since the reader's last call. These are the plants now.
  [[nodiscard]] std::vector<derivation::StepChanges> take(ChangeReader reader,
                                                          const std::vector<derivation::PlantState>& plants);

 private:
  struct Reading {
    bool isFollowed = false;
    bool isKnown = false;
    std::vector<derivation::StepChanges> changes;  // by plant; plants that came since are missing
  };

  [[nodiscard]] Reading& of(ChangeReader reader) { return readings_[static_cast<std::size_t>(reader)]; }
  [[nodiscard]] const Reading& of(ChangeReader reader) const { return readings_[static_cast<std::size_t>(reader)]; }

  std::array<Reading, 2> readings_;  // by ChangeReader
  derivation::StepChanges joined_;   // working memory
};

}  // namespace espalier::simulation
