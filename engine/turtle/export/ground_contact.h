#pragma once

#include <vector>

#include "engine/core/vec3.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// Where a stem stands on the ground: pictures darken the page there, so that the plant does not float.
struct GroundContact {
  core::Vec3 place;     // the foot of its stem
  double radius = 0.0;  // world units
};

/// The contacts of all stems that stand: they have branches or organs, begin with an upright line at the lowest part of
/// their plant, and are not flat on the ground. Curves, roots and creepers have none, nor a stand of hundreds.
/// O(scene).
[[nodiscard]] std::vector<GroundContact> groundContactsOf(const Scene& scene);

}  // namespace espalier::turtle
