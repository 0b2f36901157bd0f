#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "environment/geometry/shapes.h"
#include "environment/obstacles/obstacle_mesh.h"

namespace espalier::environment {

/// The solids and surfaces of a cpfg background scene.
struct SceneShapes {
  std::vector<Sphere> spheres;
  std::vector<MeshData> meshes;
};

/// Reads a background scene (engine/files/surfaces/background_scene.h). The error is a sentence with the line of a
/// keyword with too few numbers; unknown keywords are skipped. O(text).
[[nodiscard]] tl::expected<SceneShapes, std::string> readScene(std::string_view text);

}  // namespace espalier::environment
