#pragma once

#include <string>
#include <vector>

namespace espalier::validation {

/// The light fluxes of a layer of leaves, as parts of the light that comes in.
struct LayerFluxes {
  double reflected = 0.0, absorbed = 0.0, down = 0.0;  // down: on the ground, also light that comes down again
};
/// Small horizontal leaves of any illumination over a ground: Kubelka & Munk's equations.
[[nodiscard]] LayerFluxes horizontalLayer(double leafAreaIndex, double rho, double tau, double ground);

/// Mean projection of a unit of leaf area in a direction (Ross 1981), by the name of the distribution of leaf angles.
/// `ratio` is that of the ellipsoid (Campbell 1986, with the exact normalisation).
[[nodiscard]] double leafProjection(const std::string& leaves, double ratio, double zenithRadians);

/// Angles of leaf normals to the vertical with one of these distributions.
class LeafAngleTable {
 public:
  LeafAngleTable(const std::string& leaves, double ratio);
  /// The angle below which this part of the leaf area is, in radians.
  [[nodiscard]] double at(double part) const;

 private:
  double only_ = -1.0;             // of all leaves; below 0: there are others
  std::vector<double> cumulated_;  // leaf area below the ends of equal steps of the angle
};

/// The part of a light that passes black leaves: `light` is "uniform", "overcast" or "zenith" with an angle in degrees.
[[nodiscard]] double passedBlackLeaves(const std::string& leaves, double ratio, const std::string& light,
                                       double leafAreaIndex);

/// View factors. Discs: radii p1 and p2 at a distance p3 on one axis. Rectangles: p1 x p2, opposed at a distance p3.
/// Corner: from a rectangle of width p1 to one of width p2 that stands on their common edge p3. Sphere: to a rectangle
/// p1 x p2 whose corner is at a distance p3 below its middle.
[[nodiscard]] double viewFactor(const std::string& kind, double p1, double p2, double p3);

/// The area that two discs share.
[[nodiscard]] double lensArea(double first, double second, double distance);

}  // namespace espalier::validation
