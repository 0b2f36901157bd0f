#pragma once

#include "environment/base/air.h"

namespace espalier::environment {

/// Water and energy that a unit of leaf area gives off.
struct LeafExchange {
  double water = 0.0;          // kg m⁻² s⁻¹, negative where dew falls
  double byConductance = 0.0;  // how much more with a wider opening, kg m⁻³
  double latent = 0.0;         // W/m²
  double sensible = 0.0;       // W/m²
  double temperature = 0.0;    // of the leaf, degrees Celsius
};

/// The energy balance of a leaf: net radiation is latent and sensible heat (Penman 1948; Monteith 1965). Both
/// conductances are in m/s on a unit of leaf area; that of the boundary layer is the same for heat and vapour. With
/// `isCurve` the vapour pressure in the leaf is that of saturation at the leaf's temperature, to 10⁻⁹ K; else it
/// follows the tangent at the temperature of the air, which is the equation of Penman and Monteith.
[[nodiscard]] LeafExchange leafExchange(const Air& air, double netRadiation, double boundaryConductance,
                                        double stomatalConductance, bool isCurve);

/// The conductance of the laminar boundary layers on both sides of a flat leaf, m/s on a unit of its area (one side):
/// 2 · 0.664 κ/d Re^½ Pr^⅓ (Pohlhausen 1921), with κ and the viscosity of air at 20 °C. `width` in m along a wind in
/// m/s.
[[nodiscard]] double boundaryConductance(double width, double wind);

/// How far stomata open: g_max · f(PAR) · f(VPD) · f(ψ) (Jarvis 1976), m/s.
struct Stomata {
  double most = 0.01;        // g_max, m/s
  double least = 0.0;        // of the cuticle, m/s
  double halfPar = 100.0;    // f = PAR/(PAR + halfPar), µmol m⁻² s⁻¹; 0: no response
  double halfDeficit = 0.0;  // f = 1/(1 + VPD/halfDeficit), kPa (Lohammar et al. 1980); 0: no response
  double halfHead = 0.0;     // f = 1/(1 + (ψ/halfHead)^shape), length; 0: no response
  double shape = 3.0;

  /// The product without ψ.
  [[nodiscard]] double openness(double par, double deficit) const;
  /// f(ψ), and its derivative.
  [[nodiscard]] double waterPart(double head) const;
  [[nodiscard]] double waterPartSlope(double head) const;
};

}  // namespace espalier::environment
