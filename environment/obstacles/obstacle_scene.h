#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "environment/base/configuration.h"
#include "environment/geometry/shapes.h"
#include "environment/obstacles/obstacle_mesh.h"

namespace espalier::environment {

/// Fixed obstacles of all kinds in one scene. Distances are negative inside a solid.
class ObstacleScene {
 public:
  struct Content {
    std::vector<HalfSpace> halfSpaces;
    std::vector<Bounds> boxes;
    std::vector<Sphere> spheres;
    std::vector<Capsule> capsules;
    std::vector<MeshData> meshes;  // none with a problem
  };
  explicit ObstacleScene(Content content);

  [[nodiscard]] bool isEmpty() const;
  /// The nearest surface within `most`; a point inside an obstacle always has one.
  [[nodiscard]] std::optional<SurfacePoint> nearest(const core::Vec3& p, double most) const;
  [[nodiscard]] bool isInside(const core::Vec3& p) const;
  /// Whether a segment with round ends of a radius touches no obstacle.
  [[nodiscard]] bool isClear(const core::Vec3& a, const core::Vec3& b, double radius) const;
  /// Length of a ray up to the first obstacle, at most `reach`; 0 inside an obstacle.
  [[nodiscard]] double clearance(const core::Vec3& origin, const core::Vec3& direction, double reach) const;

 private:
  std::vector<HalfSpace> halfSpaces_;
  std::vector<Bounds> boxes_;
  std::vector<Sphere> spheres_;
  std::vector<Capsule> capsules_;
  std::vector<ObstacleMesh> meshes_;
  BoxTree tree_;  // boxes, then spheres, then capsules
};

inline constexpr ConfigurationKey kPlanesKey{
    .name = "planes",
    .kind = KeyKind::Rows,
    .description =
        "solid half-spaces: a point x, y, z of the plane and the normal nx, ny, nz that points out of the solid",
    .unit = "length",
    .minimumCount = 6,
    .maximumCount = 6};
inline constexpr ConfigurationKey kBoxesKey{
    .name = "boxes",
    .kind = KeyKind::Rows,
    .description = "solid boxes along the axes: the corner with the smallest coordinates and the opposite one",
    .unit = "length",
    .minimumCount = 6,
    .maximumCount = 6};
inline constexpr ConfigurationKey kSpheresKey{.name = "spheres",
                                              .kind = KeyKind::Rows,
                                              .description = "solid spheres: middle x, y, z and radius",
                                              .unit = "length",
                                              .minimumCount = 4,
                                              .maximumCount = 4};
inline constexpr ConfigurationKey kCapsulesKey{
    .name = "capsules",
    .kind = KeyKind::Rows,
    .description = "solid segments with round ends: x, y, z of both ends and a radius",
    .unit = "length",
    .minimumCount = 7,
    .maximumCount = 7};
inline constexpr ConfigurationKey kHeightsKey{
    .name = "heightField",
    .kind = KeyKind::Rows,
    .description = "heights y of the ground by rows along x, the row with the largest z first; solid below",
    .unit = "length",
    .minimumCount = 2};
inline constexpr ConfigurationKey kHeightsExtentKey{
    .name = "heightFieldExtent",
    .kind = KeyKind::Numbers,
    .description = "smallest x and z, largest x and z of the height field",
    .unit = "length",
    .maximumCount = 4};
inline constexpr ConfigurationKey kVerticesKey{.name = "vertices",
                                               .kind = KeyKind::Rows,
                                               .description = "x, y, z of the vertices of a mesh",
                                               .unit = "length",
                                               .minimumCount = 3,
                                               .maximumCount = 3};
inline constexpr ConfigurationKey kTrianglesKey{.name = "triangles",
                                                .kind = KeyKind::Rows,
                                                .description = "the three vertices of each triangle, counted from 0",
                                                .minimum = 0.0,
                                                .isWhole = true,
                                                .minimumCount = 3,
                                                .maximumCount = 3};
inline constexpr ConfigurationKey kMeshKey{
    .name = "mesh", .kind = KeyKind::Text, .description = "the text of a Wavefront OBJ or glTF file"};
inline constexpr ConfigurationKey kSceneKey{
    .name = "scene", .kind = KeyKind::Text, .description = "the text of a background scene of cpfg"};
/// All of them: the keys of a process with obstacles.
inline constexpr std::array kObstacleKeys{kPlanesKey,        kBoxesKey,    kSpheresKey,   kCapsulesKey, kHeightsKey,
                                          kHeightsExtentKey, kVerticesKey, kTrianglesKey, kMeshKey,     kSceneKey};

/// The obstacles of the keys above, or the errors in them: each message names `process` and the key.
[[nodiscard]] tl::expected<ObstacleScene::Content, std::vector<core::Diagnostic>> readObstacles(
    std::string_view process, const Configuration& configuration);

}  // namespace espalier::environment
