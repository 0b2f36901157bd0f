#pragma once

#include <limits>
#include <optional>
#include <string>

#include "engine/turtle/export/mesh/mesh.h"
#include "engine/turtle/export/mesh/scene_meshes.h"

namespace espalier::turtle {

/// The smallest box around positions as files hold them, in 32-bit numbers.
struct Bounds {
  core::Vec3 low{kLargest, kLargest, kLargest};
  core::Vec3 high{-kLargest, -kLargest, -kLargest};

  void add(const Mesh& mesh);
  void add(const Bounds& other);

 private:
  static constexpr double kLargest = std::numeric_limits<double>::max();
};

/// The reason why the mesh of a part cannot be written: a position that is not finite in 32 bits. Names plant,
/// module (on a tube that of the first such position) with its symbol and, when the scene's input knows it, the step.
[[nodiscard]] std::optional<std::string> problemOf(const Mesh& mesh, const SceneMeshes& scene, const MeshPart& part);

/// A normal as files need it: of length 1. Where there is none (a shape without extent) it is +y.
[[nodiscard]] core::Vec3 unitNormal(const core::Vec3& normal);

}  // namespace espalier::turtle
