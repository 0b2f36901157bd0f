#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "clients/espalier/rendering/render_light.h"
#include "engine/core/vec3.h"
#include "engine/turtle/export/exporters.h"
#include "engine/turtle/export/picture/raster_texture.h"
#include "environment/light/rays/ray_caster.h"

namespace espalier::command {

/// The paint of a place on a plant, as linear light.
struct Paint {
  Light thrownBack{};      // shares of the light, by diffuse reflection
  Light letThrough{};      // shares of the light, by diffuse transmission: leaves and petals
  Light shine{};           // strength of the mirrored sun
  double shininess = 1.0;  // exponent of Blinn (1977)
  Light emitted{};
  double opacity = 1.0;
};

/// Where a ray meets the plants.
struct Meeting {
  core::Vec3 place;
  core::Vec3 normal;  // of the smooth surface, unit, to the side where the ray comes from
  core::Vec3 facing;  // of the flat triangle, likewise
  Paint paint;
};

/// The meshes of copies of scenes as triangles for rays. Lines are round, as in mesh files. Labels are not in it.
class RenderScene {
 public:
  /// Everything referred to must outlive the object. Positions that single precision cannot hold are refused:
  /// problem() says so then, and the scene is empty.
  explicit RenderScene(const turtle::PlacedScenes& placed);

  [[nodiscard]] const std::optional<std::string>& problem() const { return problem_; }
  [[nodiscard]] bool empty() const { return corners_.empty(); }
  /// The lowest height of a corner, 0 when there is none.
  [[nodiscard]] double lowest() const { return lowest_; }
  /// The distance from a surface at which its rays start.
  [[nodiscard]] double margin() const { return rays_->margin(); }

  /// The first place on a ray; nothing: it leaves the scene. `direction` is a unit vector. Thread-safe.
  [[nodiscard]] std::optional<Meeting> meet(const core::Vec3& origin, const core::Vec3& direction) const;
  /// The part of the light that comes along a ray from outside, 0 to 1: leaves with holes let some through.
  [[nodiscard]] double arriving(core::Vec3 origin, const core::Vec3& direction) const;

 private:
  struct Material {
    Paint paint;
    std::uint32_t texture = 0xFFFFFFFF;  // index into textures_
    bool isWhiteBelow = false;           // the texture holds the shape's own colour
    bool isLeaf = false;
  };
  [[nodiscard]] double opacityAt(std::uint32_t triangle, const std::array<double, 3>& weights) const;
  [[nodiscard]] Paint paintAt(std::uint32_t triangle, const std::array<double, 3>& weights) const;
  /// The shares of a triangle's corners at the place where a ray meets its plane, and the distance.
  [[nodiscard]] std::array<double, 3> weightsOf(std::uint32_t triangle, const core::Vec3& origin,
                                                const core::Vec3& direction, double& distance) const;
  [[nodiscard]] std::array<float, 4> texel(const Material& material, std::uint32_t triangle,
                                           const std::array<double, 3>& weights) const;

  std::vector<core::Vec3> places_;
  std::vector<std::array<float, 3>> normals_;      // (vertexCount)
  std::vector<std::array<float, 2>> coordinates_;  // (vertexCount)
  std::vector<std::array<std::uint32_t, 3>> corners_;
  std::vector<std::uint32_t> materialOf_;  // (triangleCount)
  std::vector<Material> materials_;
  std::vector<turtle::RasterTexture> textures_;
  std::optional<environment::RayCaster> rays_;
  std::optional<std::string> problem_;
  double lowest_ = 0.0;
  bool hasHoles_ = false;
};

}  // namespace espalier::command
