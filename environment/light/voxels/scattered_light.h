#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/light/voxels/leaf_angles.h"
#include "environment/light/voxels/voxel_field.h"

namespace espalier::environment {

/// Light in a turbid medium of leaves that scatter, over a ground that reflects: discrete ordinates along parallel rays
/// through voxels (the method of characteristics; Carlson & Lathrop 1968, Askew 1972), order of scattering by order.
///
/// One ray of each direction starts in every column of voxels, so all voxels of a layer see the same pattern of rays,
/// and their lengths in a voxel add up to its volume over the area of a ray: no light is lost or made. Leaves scatter
/// as diffuse (Lambertian) surfaces on both sides; their normals are a quadrature of their distribution.
class ScatteredLight {
 public:
  struct Options {
    LeafAngles leafAngles = LeafAngles::Spherical;
    double ellipsoidRatio = 1.0;
    double reflectance = 0.0;  // of leaves
    double transmittance = 0.0;
    double groundReflectance = 0.0;
    double remainder = 1e-4;  // part of the light that may be left at the end
    int zenithAngles = 6;     // of scattered light, in each hemisphere
    int azimuthAngles = 8;
  };
  /// Parallel light from above.
  struct Beam {
    core::Vec3 direction;     // a unit vector towards it
    double irradiance = 0.0;  // of a horizontal plane
    double projection = 0.0;  // G of the leaves
  };
  /// What becomes of the light that comes in over the box, as irradiances of its base.
  struct Fluxes {
    double incoming = 0.0;
    double up = 0.0;
    double down = 0.0;  // on the ground
    double byPlants = 0.0;
    double byGround = 0.0;
    double aside = 0.0;  // scattered out of the sides of a box that does not repeat itself
  };

  /// O(orders · voxels · directions).
  ScatteredLight(const VoxelField& field, const Options& options, const core::Vec3& up, std::span<const Beam> beams);

  [[nodiscard]] const Fluxes& fluxes() const { return fluxes_; }
  /// Scattered light on a horizontal plane, from above, in a voxel by its index.
  [[nodiscard]] double downAt(std::size_t voxel) const { return down_[voxel]; }
  /// Scattered light that a unit of leaf area absorbs in a voxel; 0 without leaves.
  [[nodiscard]] double absorbedAt(std::size_t voxel) const;

 private:
  /// A piece of a ray in a voxel, which lies so many columns from where the ray started.
  struct Piece {
    std::int64_t a = 0;
    std::int64_t b = 0;
    std::int64_t layer = 0;
    double length = 0.0;
  };
  struct Normal {
    core::Vec3 direction;
    double part = 0.0;                 // of the leaf area
    std::array<double, 2> emission{};  // sum of weight · |cosine| over the directions on each side
  };
  struct Direction {
    core::Vec3 towards;       // the way that the light goes
    double weight = 0.0;      // solid angle
    double cosine = 0.0;      // of the angle to the vertical, above 0
    double projection = 0.0;  // G by the quadrature of normals
    std::vector<Piece> pieces;
  };

  void makeNormals(const core::Vec3& up);
  void makeDirections(const core::Vec3& up);
  [[nodiscard]] std::vector<Piece> piecesOf(const core::Vec3& towards) const;
  /// Follows all rays of a direction. `entering` is the radiance at a column's start, `outside` that of rays that come
  /// in through a side; without `sources` leaves only take light. Leaves the mean radiance of each voxel in mean_ and
  /// calls `leave(column, radiance)` at each end.
  template <typename Entering, typename Leave>
  void follow(const Direction& direction, double projection, const Entering& entering, double outside, bool hasSources,
              const Leave& leave);
  void takeUp(const Direction& direction, double scale);
  /// The sources of the next order of scattering; what is left of the light.
  double scatter();

  VoxelField field_;
  Options options_;
  bool isPeriodic_;
  std::array<std::int64_t, 3> counts_{};  // a, b, layers
  double voxelSize_;
  std::vector<Normal> normals_;
  std::vector<Direction> directions_;
  std::vector<std::uint32_t> leafyVoxels_;
  std::vector<double> taken_;           // irradiance of both sides of each normal (leafy voxels, normals, 2)
  std::vector<double> emitted_;         // exitance of the same
  std::vector<double> source_;          // of one direction, per leaf area (voxels)
  std::vector<double> mean_;            // radiance of one direction (voxels)
  std::vector<double> ground_;          // irradiance in this order (columns)
  std::vector<double> groundSource_;    // exitance (columns)
  std::vector<double> down_;            // (voxels)
  std::vector<double> absorbed_;        // (leafy voxels)
  std::vector<std::uint32_t> leafyOf_;  // of a voxel (voxels)
  Fluxes fluxes_;
};

}  // namespace espalier::environment
