#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "engine/core/vec3.h"
#include "environment/base/configuration.h"

namespace espalier::environment {

// The keys with which processes describe a box of cells, and their reader.

inline constexpr std::array kOrigin{0.0, 0.0, 0.0};
inline constexpr std::array kUnitSides{1.0, 1.0, 1.0};

/// `gridSize`: three whole numbers from 1 to `maximum`.
[[nodiscard]] constexpr ConfigurationKey gridSizeKey(std::span<const double> defaults,
                                                     std::string_view description = "number of cells along x, y, z",
                                                     double maximum = 4096.0) {
  return {.name = "gridSize",
          .kind = KeyKind::Numbers,
          .description = description,
          .minimum = 1.0,
          .maximum = maximum,
          .isWhole = true,
          .defaultNumbers = defaults,
          .minimumCount = 3,
          .maximumCount = 3};
}

/// `position`: the low corner of the box.
[[nodiscard]] constexpr ConfigurationKey positionKey(std::span<const double> defaults) {
  return {.name = "position",
          .kind = KeyKind::Numbers,
          .description = "corner of the box with the smallest coordinates",
          .unit = "length",
          .defaultNumbers = defaults,
          .minimumCount = 3,
          .maximumCount = 3};
}

/// Three lengths above 0, along x, y and z.
[[nodiscard]] constexpr ConfigurationKey sidesKey(std::string_view name, std::string_view description,
                                                  std::span<const double> defaults) {
  return {.name = name,
          .kind = KeyKind::Numbers,
          .description = description,
          .unit = "length",
          .minimum = 0.0,
          .isMinimumExclusive = true,
          .defaultNumbers = defaults,
          .minimumCount = 3,
          .maximumCount = 3};
}

/// The three numbers of a key as a vector.
[[nodiscard]] inline core::Vec3 vectorOf(const Configuration& configuration, std::string_view key) {
  const std::vector<double>& numbers = configuration.numbers(key);
  return {numbers[0], numbers[1], numbers[2]};
}

/// `gridSize` as counts of cells along x, y, z.
[[nodiscard]] inline std::array<std::size_t, 3> cellsOf(const Configuration& configuration) {
  const std::vector<double>& numbers = configuration.numbers("gridSize");
  return {static_cast<std::size_t>(numbers[0]), static_cast<std::size_t>(numbers[1]),
          static_cast<std::size_t>(numbers[2])};
}

/// The error of a grid with more than `most` cells; nothing for a smaller one.
[[nodiscard]] inline std::optional<core::Diagnostic> tooManyCells(std::string_view process,
                                                                  const std::array<std::size_t, 3>& cells,
                                                                  std::size_t most) {
  const std::size_t count = cells[0] * cells[1] * cells[2];
  if (count <= most) {
    return std::nullopt;
  }
  return wrongConfiguration(
      process, "the grid has " + std::to_string(count) + " cells, and the limit is " + std::to_string(most),
      "use fewer cells along x, y or z");
}

}  // namespace espalier::environment
