#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/light/rays/ray_caster.h"
#include "environment/light/rays/ray_directions.h"
#include "environment/light/rays/surface_changes.h"

namespace espalier::environment {

/// How a surface scatters the light of one band: diffuse (Lambertian) on both sides.
struct LightMaterial {
  double reflectance = 0.0;
  double transmittance = 0.0;
};

/// Light of one band on triangles, by gathering along fixed directions (ray_directions.h), starting at points of the
/// triangle that a low-discrepancy sequence (R2) gives. So a result is a pure function of the scene. Weights are scaled
/// for every side of every triangle so that a uniform light from everywhere gives exactly its irradiance; hence a
/// closed box of one radiance stays in balance to rounding.
///
/// Scattering: the light that a side gets, reflected and let through, leaves both sides evenly in all directions and is
/// gathered in the next bounce. Rays are traced once for all bands and bounces. settle() sends the light along rays of
/// its own: along those that gathered it, a leaf that happens to see more of the sky would send more back there.
///
/// A scene that follows another keeps the rays that cannot have changed: of triangles that were there before, those
/// whose line misses every triangle that came or went. The light is the same, bit by bit, as that of a new LeafLight.
class LeafLight {
 public:
  struct Options {
    int directions = 128;   // of a triangle that is not thinned, over the whole sphere
    bool keepsHits = true;  // for bounces and for emitting surfaces
    bool settles = false;   // for settle(), and then not for bounces
    unsigned threads = 1;
    std::optional<RayCaster::Repetition> repetition{};
  };
  /// Parallel light: the unit vector towards it, and its irradiance on a plane that faces it, by band.
  struct Sun {
    core::Vec3 direction;
    std::vector<double> irradiance;
  };

  /// The light of one band when almost nothing is left of it.
  struct Balance {
    std::vector<double> irradiances;  // as irradiances() gives them; they balance
    std::vector<double> gathered;     // the same, but organs gather scattered light
    std::vector<double> sent;         // radiant exitance of each side
    double leavingUp = 0.0;           // scattered power that goes to the sky
    double leavingDown = 0.0;         // and past everything downwards
  };

  /// Without triangles.
  explicit LeafLight(const Options& options);
  /// With a first scene.
  LeafLight(LightSurfaces surfaces, std::vector<std::uint32_t> wanted, std::vector<Sun> suns, const Options& options);

  /// Changes to the next scene and traces the rays of the triangles in `wanted` (ascending; all when empty; a bounce
  /// needs all). O(triangles · (directions + suns) · log n); a kept ray costs the log of the changed triangles only.
  /// Memory: 4 bytes a ray, and twice as much during the call.
  void setScene(LightSurfaces surfaces, std::vector<std::uint32_t> wanted, std::vector<Sun> suns);

  /// The directions of all triangles; the radiance of the sky is given for each of directions().all().
  [[nodiscard]] const RayDirections& directions() const { return directions_; }

  /// Irradiances of the two sides of every triangle in one band (2 · triangles; front first: the side from which the
  /// corners run counterclockwise), with so many bounces. `sky` has the radiance by direction, `materials` those of the
  /// band, `emitted` the radiant exitance of each side (empty: none). `sent`, if given, receives all exitances that
  /// were gathered. O(bounces · rays).
  [[nodiscard]] std::vector<double> irradiances(std::size_t band, const std::vector<double>& sky,
                                                const std::vector<LightMaterial>& materials,
                                                const std::vector<double>& emitted, int bounces,
                                                std::vector<double>* sent = nullptr) const;

  /// Irradiances with as many bounces as it takes until a part `remainder` (above 0) of the light that came in is left.
  /// Scattered light is sent out, not gathered, so that none is lost or made: what comes in, what is absorbed and what
  /// leaves balance up to the remainder. But few of these rays meet a small organ; in the end each organ gathers what
  /// the surfaces around it send (final gathering; Reichert 1992). Needs `settles` and the rays of all triangles. One
  /// thread adds the sums in a fixed order. O(bounces · rays). `incoming` is for a scene with a ground under a plot
  /// that repeats itself: the power of the band that comes in over the plot, all of which meets a plant or the ground.
  [[nodiscard]] Balance settle(std::size_t band, const std::vector<double>& sky,
                               const std::vector<LightMaterial>& materials, double remainder, const core::Vec3& up,
                               const std::optional<double>& incoming) const;

  /// Irradiance of a plane facing `normal` at a point, from the sky, the suns and the sides of triangles with their
  /// radiant exitance `sent` (empty: none). Its rays are not kept.
  [[nodiscard]] double irradianceAt(const core::Vec3& point, const core::Vec3& normal, std::size_t band,
                                    const std::vector<double>& sky, const std::vector<double>& sent) const;

  [[nodiscard]] double areaOf(std::size_t triangle) const { return areas_[triangle]; }
  /// Rays of the scene, and how many of them were kept from the one before.
  [[nodiscard]] std::uint64_t rayCount() const { return hits_.size() + isLit_.size(); }
  [[nodiscard]] std::uint64_t keptCount() const { return keptCount_; }

 private:
  static constexpr std::uint32_t kSky = RayCaster::kMiss;
  struct Earlier;

  void measure();
  void giveTheGroundTheRest(double incoming, const core::Vec3& up, std::vector<double>& irradiances) const;
  void gather(std::size_t band, const std::vector<double>& sky, const std::vector<LightMaterial>& materials,
              double leastChange, Balance& balance) const;
  void shoot(std::size_t row, const std::vector<double>& power, const core::Vec3& up, std::vector<double>& arrived,
             Balance& balance) const;
  /// The directions along which a triangle gathers light, and those along which settle() sends it.
  [[nodiscard]] RayDirections::Lattice gatheringOf(std::uint32_t triangle) const;
  [[nodiscard]] RayDirections::Lattice sendingOf(std::uint32_t triangle) const;
  /// Whether the rays that gather know what they meet. With `settles` the ground takes what is sent to it.
  [[nodiscard]] bool gathersFromSurfaces(std::uint32_t triangle) const {
    return options_.keepsHits && (!options_.settles || triangle < surfaces_.groundBegin);
  }
  void listRows(std::vector<std::uint32_t> wanted);
  [[nodiscard]] std::vector<std::uint32_t> rowsInSpace() const;
  /// Traces a row; how many of its rays were kept.
  std::uint64_t traceRow(std::uint32_t row, const Earlier* earlier);
  template <typename Work>
  void inParallel(std::size_t count, const Work& work) const;

  Options options_;
  RayDirections directions_;
  LightSurfaces surfaces_;
  std::vector<Sun> suns_;
  RayCaster caster_;
  std::vector<core::Vec3> normals_;  // unit vectors, of the front sides (triangles)
  std::vector<double> areas_;        // (triangles)
  std::vector<std::uint32_t> wanted_;
  std::vector<std::uint32_t> rowOf_;   // of a triangle; kMiss: not wanted (triangles)
  std::vector<std::size_t> rowStart_;  // of the rows in hits_, then its size (wanted + 1)
  /// The hit of each ray of the wanted triangles: 2 · triangle + side, or kSky. First those that gather, then those
  /// that send. A hit of a ray that only gathers from the sky is only told from the sky.
  std::vector<std::uint32_t> hits_;
  std::vector<std::uint8_t> isLit_;  // by a sun (wanted, suns)
  std::uint64_t keptCount_ = 0;
};

}  // namespace espalier::environment
