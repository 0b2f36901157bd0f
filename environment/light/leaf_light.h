#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/light/ray_caster.h"

namespace espalier::environment {

/// Triangles that take, reflect and let pass light.
struct LightSurfaces {
  std::vector<core::Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> material;  // of each triangle
};

/// What a surface does to the light of one band: diffuse (Lambertian) on both sides.
struct LightMaterial {
  double reflectance = 0.0;
  double transmittance = 0.0;
};

/// Light of one band on triangles, by gathering along fixed directions, all of which every triangle uses: directions of
/// a Fibonacci lattice over the whole sphere, starting at points of the triangle that a low-discrepancy sequence (R2)
/// gives. So a result is a pure function of the scene. Weights are scaled for every side of every triangle so that a
/// uniform light from everywhere gives exactly its irradiance; hence a closed box of one radiance stays in balance to
/// rounding.
///
/// Scattering: the light that a side gets, reflected and let through, leaves both sides evenly in all directions and is
/// gathered in the next bounce. Rays are traced once for all bands and bounces.
class LeafLight {
 public:
  struct Options {
    int directions = 128;   // over the whole sphere
    bool keepsHits = true;  // for bounces and for emitting surfaces; costs 4 bytes a triangle and direction
    unsigned threads = 1;
    std::optional<RayCaster::Repetition> repetition{};
  };
  /// Parallel light: the unit vector towards it, and its irradiance on a plane that faces it, by band.
  struct Sun {
    core::Vec3 direction;
    std::vector<double> irradiance;
  };

  /// Traces all rays of the triangles in `wanted` (all when empty; a bounce needs all). O(triangles · (directions +
  /// suns) · log n).
  LeafLight(const LightSurfaces& surfaces, std::vector<std::uint32_t> wanted, const std::vector<Sun>& suns,
            const Options& options);

  /// The directions of so many rays, a Fibonacci lattice; the radiance of the sky is given for each of them.
  [[nodiscard]] static std::vector<core::Vec3> directionsOf(int count);

  /// Irradiances of the two sides of every triangle in one band (2 · triangles; front first: the side from which the
  /// corners run counterclockwise), with so many bounces. `sky` has the radiance by direction, `materials` those of the
  /// band, `emitted` the radiant exitance of each side (empty: none). O(bounces · triangles · directions).
  [[nodiscard]] std::vector<double> irradiances(std::size_t band, const std::vector<double>& sky,
                                                const std::vector<LightMaterial>& materials,
                                                const std::vector<double>& emitted, int bounces) const;

  /// Irradiance of a plane facing `normal` at a point, from the sky and the suns only. Traces its rays anew.
  [[nodiscard]] double irradianceAt(const core::Vec3& point, const core::Vec3& normal, std::size_t band,
                                    const std::vector<double>& sky) const;

  [[nodiscard]] double areaOf(std::size_t triangle) const { return areas_[triangle]; }
  /// Rays traced by the constructor.
  [[nodiscard]] std::uint64_t rayCount() const { return rayCount_; }

 private:
  static constexpr std::uint32_t kSky = RayCaster::kMiss;

  void traceRays(std::uint32_t triangle);
  [[nodiscard]] core::Vec3 pointOf(std::uint32_t triangle, std::size_t direction) const;
  template <typename Work>
  void inParallel(std::size_t count, const Work& work) const;

  LightSurfaces surfaces_;
  std::vector<Sun> suns_;
  Options options_;
  std::vector<core::Vec3> directions_;
  RayCaster caster_;
  std::vector<core::Vec3> normals_;  // unit vectors, of the front sides (triangles)
  std::vector<double> areas_;        // (triangles)
  std::vector<std::uint32_t> wanted_;
  std::vector<std::uint32_t> rowOf_;  // of a triangle in hits_; kMiss: not wanted (triangles)
  /// What each ray of the wanted triangles meets: 2 · triangle + side, or kSky (wanted, directions). Without keepsHits
  /// a hit is only told from the sky.
  std::vector<std::uint32_t> hits_;
  std::vector<std::uint8_t> isLit_;  // by a sun (wanted, suns)
  std::uint64_t rayCount_ = 0;
};

}  // namespace espalier::environment
