#pragma once

#include <string>

#include "engine/core/limits.h"
#include "engine/simulation/snapshot_content.h"

namespace espalier::simulation {

// A snapshot can come from a stranger, and its checksum proves nothing: anybody can compute one. These checks stand
// between the bytes and every part of the engine that indexes by them.

/// The first wrong value of a snapshot that can be found without a Program (steps, places, rules for seeds, colours,
/// coupling, replies), as the end of a sentence. Empty: all are right.
[[nodiscard]] std::string problemOfRun(const SnapshotContent& content);

/// Checks every plant against the Program it is to run with and turns its module types into the Program's. A whole
/// error sentence; empty: the content can run. O(bytes of the snapshot).
[[nodiscard]] std::string adoptPrograms(SnapshotContent& content, const Programs& programs, const core::Limits& limits);

/// The error of strings that are together larger than `limits` allow, or nothing. The content's counts are checked.
[[nodiscard]] std::optional<core::SimulationError> sizeErrorOf(const SnapshotContent& content,
                                                               const core::Limits& limits);

}  // namespace espalier::simulation
