#pragma once

#include <algorithm>
#include <array>
#include <string_view>

namespace espalier::language {

/// The values of its world that a model reads in Espalier's own mode, as `world.NAME`: the means of the weather over
/// the step, the time at the beginning of the step in days after the start, and thermal time up to then.
inline constexpr std::string_view kWorldPrefix = "world.";
inline constexpr std::array<std::string_view, 10> kWorldNames{
    "time", "thermalTime", "temperature", "humidity", "wind", "rain", "co2", "global", "direct", "diffuse"};

[[nodiscard]] constexpr bool isWorldName(std::string_view name) {
  return name.starts_with(kWorldPrefix);
}
[[nodiscard]] constexpr bool isKnownWorldName(std::string_view name) {
  return isWorldName(name) &&
         std::find(kWorldNames.begin(), kWorldNames.end(), name.substr(kWorldPrefix.size())) != kWorldNames.end();
}

}  // namespace espalier::language
