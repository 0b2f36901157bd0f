#pragma once

#include <optional>

#include "engine/files/view_settings.h"
#include "engine/turtle/scene/scene.h"

namespace espalier::turtle {

/// The smallest box around everything drawn: points of lines, vertices, spheres and discs with their radius, surfaces
/// as sampled, control points of cylinders and patches, places of labels; without the widths of lines and cylinders.
/// Nothing for an empty scene. O(scene).
[[nodiscard]] std::optional<files::Box> boundsOf(const Scene& scene, const files::ViewSettings& view);

}  // namespace espalier::turtle
