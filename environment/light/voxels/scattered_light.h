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
  /// The fluxes of the light that comes in over the box, as irradiances of its base.
  struct Fluxes {
    double incoming = 0.0;
    double up = 0.0;
    double down = 0.0;  // on the ground
    double byPlants = 0.0;
    double byGround = 0.0;
    double aside = 0.0;  // scattered out of the sides of a box that does not repeat itself
  };

  /// O(orders · directions · leafy voxels · (rays through a voxel + directions)), and once O(directions · voxels · rays
  /// through a voxel). Memory meanwhile: 12 bytes for each direction of both hemispheres in a leafy voxel.
  ScatteredLight(const VoxelField& field, const Options& options, const core::Vec3& up, std::span<const Beam> beams);

  [[nodiscard]] const Fluxes& fluxes() const { return fluxes_; }
  /// Scattered light on a horizontal plane, from above, in a voxel by its index.
  [[nodiscard]] double downAt(std::size_t voxel) const { return down_[voxel]; }
  /// Scattered light that a unit of leaf area absorbs in a voxel; 0 without leaves. O(log leafy voxels).
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
    double part = 0.0;      // of the leaf area
    double emission = 0.0;  // sum of weight · |cosine| over the directions on a side
  };
  struct Direction {
    core::Vec3 towards;       // the way that the light goes
    double weight = 0.0;      // solid angle
    double cosine = 0.0;      // of the angle to the vertical, above 0
    double projection = 0.0;  // G of the leaves
    std::vector<Piece> pieces;
  };
  /// The response of leaves to light that comes along some ways: sources along pairs of opposite directions. Leaves
  /// send ρ + τ evenly to both sides, and by τ − ρ more onwards than back. So the sum of the light of two opposite ways
  /// gives the even part of a pair, and their difference the odd part.
  struct Exchange {
    std::size_t ways = 0;
    std::vector<double> even;  // (pairs, ways)
    std::vector<double> odd;   // (pairs, ways)
    std::vector<double> met;   // light that a unit of leaf area meets (ways)
  };
  /// Rays that left through the sides of the box.
  struct Aside {
    double radiance = 0.0;  // their sum
    double count = 0.0;
  };

  void makeNormals(const core::Vec3& up);
  void makeDirections(const core::Vec3& up);
  void listLeaves();
  [[nodiscard]] std::vector<Piece> piecesOf(const core::Vec3& towards) const;
  [[nodiscard]] double projectionOf(const core::Vec3& towards) const;
  /// The exchange of ways with so much solid angle each.
  [[nodiscard]] Exchange exchangeOf(std::span<const core::Vec3> towards, std::span<const double> weights) const;
  /// The light that no leaf has met yet; what the leaves have met of it.
  double takeBeams(std::span<const Beam> beams, const core::Vec3& up);
  /// One order of scattering: sends the light of all sources; what the leaves have met of it.
  double sendOut();
  /// Follows all rays of a direction through leaves with the radiance `source` (leafy voxels). `rays` has the radiance
  /// at the column where each starts, and then that at its end; `outside` is that of rays that come in through a side.
  /// Leaves the mean radiance of each leafy voxel in `mean`. `passing(voxel, ray, count, part)` sees the rays that come
  /// to a row of voxels.
  template <typename Passing>
  Aside follow(const Direction& direction, const double* source, std::vector<double>& rays, double outside,
               double* mean, const Passing& passing) const;
  /// The column where the ray from a column ends.
  [[nodiscard]] std::size_t endOf(const Direction& direction, std::size_t column) const;
  /// Adds what leaves make of the light in a block of leafy voxels to their sources; what they meet of it.
  double scatterBlock(const Exchange& exchange, const double* sums, const double* differences, std::size_t first,
                      bool isCounted);
  /// The sources of the ground for the next order, and the sums of this one; what is left of the light.
  double scatter(double met);
  /// The scattered light from above everywhere, by the sources of all orders.
  void fillDown();

  VoxelField field_;
  Options options_;
  std::array<std::int64_t, 3> counts_{};  // a, b, layers
  double voxelSize_;
  std::vector<Normal> normals_;
  std::vector<Direction> directions_;  // pairs of opposite ones: down, up
  std::vector<std::uint32_t> leafyVoxels_;
  std::vector<std::uint32_t> columnB_;               // place along b (leafy voxels)
  std::vector<std::uint32_t> densityOf_;             // in layerDensities_ (leafy voxels)
  std::vector<std::size_t> rowStart_;                // of the row (layer, a) in leafyVoxels_, then its size
  std::vector<std::vector<double>> layerDensities_;  // each density once (layers)
  std::size_t stride_ = 0;                           // leafy voxels, filled up to whole blocks
  Exchange exchange_;                                // of the pairs of directions
  std::vector<double> sources_;                      // radiance of leaves for the next order (directions, stride)
  std::vector<double> allSources_;                   // of all orders, downwards (pairs, stride)
  std::vector<double> ground_;                       // irradiance in this order (columns)
  std::vector<double> groundSource_;                 // exitance (columns)
  std::vector<double> down_;                         // (voxels)
  std::vector<double> absorbed_;                     // (stride)
  Fluxes fluxes_;
};

}  // namespace espalier::environment
