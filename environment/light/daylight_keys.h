#pragma once

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "environment/base/configuration.h"
#include "environment/light/sky.h"

namespace espalier::environment {

// The keys of sun and sky, the same in every process that takes daylight.h. `diffuseIrradiance` is the process's own.

inline constexpr std::array<std::string_view, 3> kSunNames{"none", "direction", "position"};
inline constexpr std::array kSunFromAbove{0.0, 1.0, 0.0};

inline constexpr std::array kDaylightKeys{
    ConfigurationKey{.name = "sky",
                     .kind = KeyKind::Choice,
                     .description = "brightness of the sky; overcast is (1 + 2 cos θ)/3, clear the CIE's with the sun",
                     .defaultText = "overcast",
                     .choices = kSkyNames},
    ConfigurationKey{
        .name = "sun",
        .kind = KeyKind::Choice,
        .description = "none; direction: sunDirection; position: by the world's latitude, longitude and start",
        .defaultText = "none",
        .choices = kSunNames},
    ConfigurationKey{.name = "start",
                     .kind = KeyKind::Text,
                     .description = "date and universal time of step 0, with latitude and longitude, instead of the "
                                    "world's; empty: the world's"},
    ConfigurationKey{.name = "latitude",
                     .description = "latitude, north positive, for the sun by position; needs start",
                     .unit = "degree",
                     .minimum = -90.0,
                     .maximum = 90.0},
    ConfigurationKey{.name = "longitude",
                     .description = "longitude, east positive, for the sun by position; needs start",
                     .unit = "degree",
                     .minimum = -360.0,
                     .maximum = 360.0},
    ConfigurationKey{.name = "sunDirection",
                     .kind = KeyKind::Numbers,
                     .description = "direction x, y, z towards the sun",
                     .defaultNumbers = kSunFromAbove,
                     .minimumCount = 3,
                     .maximumCount = 3},
    ConfigurationKey{.name = "sunAzimuths",
                     .kind = KeyKind::Integer,
                     .description = "sun by direction: the mean of so many azimuths, evenly around the vertical",
                     .minimum = 1.0,
                     .maximum = 256.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "directIrradiance",
                     .description = "irradiance of a plane that faces the sun; not used when sun is position",
                     .unit = "W/m^2",
                     .minimum = 0.0,
                     .defaultNumber = 800.0},
    ConfigurationKey{.name = "atmosphere",
                     .description = "τ, the part of the light from the zenith that clear air lets through",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 0.7},
    ConfigurationKey{.name = "sunSamples",
                     .kind = KeyKind::Integer,
                     .description = "number of positions of the sun in a step; 1: the middle of the step",
                     .minimum = 1.0,
                     .maximum = 1000.0,
                     .defaultNumber = 24.0},
};

[[nodiscard]] inline SkyKind skyKindOf(const Configuration& configuration) {
  return static_cast<SkyKind>(std::find(kSkyNames.begin(), kSkyNames.end(), configuration.text("sky")) -
                              kSkyNames.begin());
}

/// The problems of the keys of sun and sky together. Empty: none.
[[nodiscard]] inline std::vector<core::Diagnostic> checkDaylight(std::string_view process,
                                                                 const Configuration& configuration) {
  if (configuration.text("sky") == "clear" && configuration.text("sun") == "none") {
    return {wrongConfiguration(process, "a clear 'sky' is brightest around the sun, and 'sun' is none",
                               "set sun to direction or position")};
  }
  return {};
}

}  // namespace espalier::environment
