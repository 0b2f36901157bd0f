#pragma once

#include <cstddef>

#include "environment/soil/flux_potential.h"

namespace espalier::environment {

/// How the flux potentials of a soil cell and of the root surface in it differ: Φ(cell) − Φ(surface) = Q g/2π, where Q
/// is the uptake of a unit of root length. This gives g when the root drains the soil around it at a steady rate up to
/// `ratio` times its radius, and Φ(cell) is the mean over that soil (Schröder et al., Vadose Zone Journal 7, 2008).
[[nodiscard]] double annulusFactor(double ratio);

/// The same for cells that are smaller than the soil which a root drains, so that water enters through their faces.
struct CellFactor {
  std::size_t reach = 0;  // cells up to so many to each side of the root share the uptake equally, and Φ is their mean
  double factor = 0.0;    // g; 0 when the root fills all of them
};
/// The factor of one cell is g = ln(0.198 side/radius) (Peaceman, Society of Petroleum Engineers Journal 18, 1978). The
/// soil has the cell's head at a distance of 0.198 sides from the root. A root that is wider than that takes from a
/// block of cells, which has a larger such distance. Its logarithm is the mean of the logarithms of the distances of
/// all pairs of cells in the block.
[[nodiscard]] CellFactor cellFactor(double side, double radius);

/// The uptake of a unit of root length, and how it changes.
struct RootUptake {
  double perLength = 0.0;    // length²/day, negative when water leaves the root
  double byHead = 0.0;       // how much less at a higher head in the xylem, length/day
  double bySoilHead = 0.0;   // how much more at a higher head of the soil, length/day
  double surfaceHead = 0.0;  // at the root surface, length
};

/// A head of the soil around a root, with what the uptake needs of it.
struct SoilPoint {
  double head = 0.0;          // length
  double phi = 0.0;           // Φ, length²/day
  double conductivity = 0.0;  // K, length/day
};
[[nodiscard]] SoilPoint soilPointAt(const FluxPotential& potential, double head);

/// The uptake through soil and root in series: C (ψ surface − ψ xylem) = 2π/g (Φ(soil) − Φ(surface)), where C is the
/// conductance of a unit of root length, 2πa kr of a thin root, length/day. Water that leaves a root meets no
/// resistance of the soil. `surfaceGuess` is a head near that of the surface.
[[nodiscard]] RootUptake rootUptake(const FluxPotential& potential, double factor, const SoilPoint& soil,
                                    double rootConductance, double xylemHead, double surfaceGuess);

}  // namespace espalier::environment
