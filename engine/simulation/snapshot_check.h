#pragma once

#include <string>

#include "engine/core/limits.h"
#include "engine/simulation/snapshot_content.h"

namespace espalier::simulation {

// A snapshot can come from a stranger, and its checksum proves nothing: anybody can compute one. These checks stand
// between the bytes and every part of the engine that indexes by them.

/// What is wrong with the values of a snapshot that need no Program to be checked (steps, places, rules for seeds,
/// colours, coupling, replies), as the end of a sentence; empty: nothing. Without plants only the head is checked.
[[nodiscard]] std::string problemOfRun(const SnapshotContent& content);

/// Checks every plant against the Program it is to run with and turns its module types into the Program's. A whole
/// error sentence; empty: the content can run. O(bytes of the snapshot).
[[nodiscard]] std::string adoptPrograms(SnapshotContent& content, const Programs& programs, const core::Limits& limits);

}  // namespace espalier::simulation
