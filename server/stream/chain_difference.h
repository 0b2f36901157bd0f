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

/// What a viewer of `base` needs to have `chain`, of the same Programs. Groups that both share, and stretches of other
/// groups, are kept without a look at their rows, unless what they grow from has moved otherwise than they; between
/// them rows are compared (differenceOf). O(groups + stretches of groups that are not shared + rows that are not
/// shared). Throws protocol::NonFiniteNumber.
[[nodiscard]] TurtleChange differenceOf(const turtle::RecordChain& base, const turtle::RecordChain& chain,
                                        std::shared_ptr<const std::vector<std::string>> symbols);

}  // namespace espalier::server
