#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/turtle/interpretation/record_chain.h"
#include "server/stream/turtle_frame.h"

namespace espalier::server {

/// All records of a chain. Throws protocol::NonFiniteNumber.
[[nodiscard]] TurtleFrame makeTurtleFrame(const turtle::RecordChain& chain,
                                          std::shared_ptr<const std::vector<std::string>> symbols);

/// The difference that makes `chain` of `base`, an earlier chain of the same simulation and Programs. Shared groups,
/// and shared stretches of other groups, are kept without reading their rows, unless the rows they grow from have moved
/// by another amount. Rows between them are compared (differenceOf). O(groups + stretches of groups that are not shared
/// + rows that are not shared). Throws protocol::NonFiniteNumber.
[[nodiscard]] TurtleChange differenceOf(const turtle::RecordChain& base, const turtle::RecordChain& chain,
                                        std::shared_ptr<const std::vector<std::string>> symbols);

}  // namespace espalier::server
