#pragma once

#include <span>
#include <string_view>

namespace espalier::protocol {

/// The candidate from which a name differs in at most two letters (one, when either has less than four), which are
/// changed, added or missing. Empty: there is none. Of equally near candidates the first counts. protocol/ does not see
/// the engine's distance.
[[nodiscard]] std::string_view nearName(std::string_view name, std::span<const std::string_view> candidates);

}  // namespace espalier::protocol
