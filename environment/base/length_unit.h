#pragma once

#include <array>
#include <string>
#include <string_view>

#include "engine/turtle/environment_process.h"

namespace espalier::environment {

/// A length unit with a known size.
struct LengthUnit {
  std::string_view name;
  double metres;
  double litres;  // in a volume of one unit cubed
};

inline constexpr std::array kLengthUnits{LengthUnit{"m", 1.0, 1000.0}, LengthUnit{"dm", 0.1, 1.0},
                                         LengthUnit{"cm", 0.01, 1e-3}, LengthUnit{"mm", 0.001, 1e-6}};

/// The unit of a name; null when its size is unknown.
[[nodiscard]] constexpr const LengthUnit* findLengthUnit(std::string_view name) {
  for (const LengthUnit& unit : kLengthUnits) {
    if (unit.name == name) {
      return &unit;
    }
  }
  return nullptr;
}

/// The error of a process that must know the size of the world's length unit.
[[nodiscard]] inline turtle::EnvironmentError unknownLengthUnit(std::string_view process, const turtle::World& world) {
  return {"Environment '" + std::string(process) + "' needs lengths in m, dm, cm or mm, and the world's unit is '" +
              world.lengthUnit + "'. Set lengthUnit to one of these.",
          false};
}

}  // namespace espalier::environment
