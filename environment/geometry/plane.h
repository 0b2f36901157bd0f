#pragma once

#include <array>
#include <string_view>

#include "engine/core/vec3.h"
#include "environment/base/configuration.h"

namespace espalier::environment {

/// Where a process measures distances.
enum class Plane : std::uint8_t { Space, Xz, Xy, Yz };

inline constexpr std::array<std::string_view, 3> kPlaneNames{"xz", "xy", "yz"};

/// The two keys of processes that measure in a plane or in space; planeOf() reads them.
inline constexpr ConfigurationKey kThreeDimensionalKey{
    .name = "threeDimensional",
    .kind = KeyKind::Boolean,
    .description = "measure distances in space instead of in the plane"};
inline constexpr ConfigurationKey kPlaneKey{
    .name = "plane",
    .kind = KeyKind::Choice,
    .description = "the plane in which distances are measured when threeDimensional is false",
    .defaultText = "xz",
    .choices = kPlaneNames};

/// The plane of one of kPlaneNames.
[[nodiscard]] constexpr Plane planeNamed(std::string_view name) {
  return name == "xy" ? Plane::Xy : name == "yz" ? Plane::Yz : Plane::Xz;
}

[[nodiscard]] inline Plane planeOf(const Configuration& configuration) {
  return configuration.flag("threeDimensional") ? Plane::Space : planeNamed(configuration.text("plane"));
}

/// The point with the coordinate across the plane set to 0.
[[nodiscard]] constexpr core::Vec3 flattened(Plane plane, const core::Vec3& p) {
  switch (plane) {
    case Plane::Space:
      return p;
    case Plane::Xz:
      return {p.x, 0.0, p.z};
    case Plane::Xy:
      return {p.x, p.y, 0.0};
    case Plane::Yz:
      return {0.0, p.y, p.z};
  }
  return p;
}

}  // namespace espalier::environment
