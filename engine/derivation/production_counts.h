#pragma once

#include <cstdint>
#include <unordered_map>

#include "engine/language/program.h"

namespace espalier::derivation {

/// How often each production of a Program was applied, those of decomposition included. One that was not has no entry.
using ProductionCounts = std::unordered_map<const language::Production*, std::uint64_t>;

}  // namespace espalier::derivation
