#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "environment/geometry/box_tree.h"
#include "environment/geometry/shapes.h"

namespace espalier::environment {

/// Triangles as indices of corners.
struct MeshData {
  std::vector<core::Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  bool isGround = false;  // a height field over x, z: the space below it is solid
};

/// The triangles of a mesh file (engine/files/surfaces/mesh_file.h), corners at the same place merged; or a sentence
/// that says what is wrong with the file. `name` may be empty for the text of an OBJ or glTF file. O(n log n).
[[nodiscard]] tl::expected<MeshData, std::string> readMesh(std::string_view name, const std::string& bytes);

/// Lets all triangles use the first of the vertices that lie at the same place, unless the mesh is closed with its own.
/// O(n log n).
void mergeCorners(MeshData& mesh);

/// The first error of a mesh: a coordinate that is not finite, a corner that is no vertex, no triangle. Empty when
/// there is none.
[[nodiscard]] std::string problemOf(const MeshData& mesh);

/// A surface of triangles with a tree. A closed one (each side belongs to two triangles) is a solid, whichever way each
/// of its triangles faces; a surface with holes, and a one-sided one, has no inside. Inside
/// and outside are told by the angle-weighted normal of the nearest part (Bærentzen & Aanæs, IEEE Transactions on
/// Visualization and Computer Graphics 11, 2005).
class ObstacleMesh {
 public:
  /// `data` has no problem. O(n log n).
  explicit ObstacleMesh(MeshData data);

  [[nodiscard]] bool isClosed() const { return isClosed_; }
  [[nodiscard]] std::size_t triangleCount() const { return triangles_.size(); }
  /// The nearest point of the surface, if it is within `most`; any point inside a solid is.
  [[nodiscard]] std::optional<SurfacePoint> nearest(const core::Vec3& p, double most) const;
  [[nodiscard]] bool isInside(const core::Vec3& p) const;
  /// Distance of a segment if it is within `most`; 0 when they touch or the segment is inside.
  [[nodiscard]] std::optional<double> distanceTo(const core::Vec3& a, const core::Vec3& b, double most) const;
  /// Length of a ray up to the surface, if it is within `reach`; 0 inside.
  [[nodiscard]] std::optional<double> rayTo(const core::Vec3& origin, const core::Vec3& direction, double reach) const;

 private:
  [[nodiscard]] bool isOverGround(const core::Vec3& p) const;

  std::vector<Triangle> triangles_;
  std::vector<std::array<core::Vec3, 7>> normals_;  // by triangle and feature, as nearestOnTriangle counts them
  bool isClosed_ = false;
  bool isGround_ = false;
  Bounds bounds_;
  BoxTree tree_;
};

}  // namespace espalier::environment
