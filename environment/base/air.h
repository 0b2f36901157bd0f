#pragma once

namespace espalier::environment {

/// Latent heat of vaporisation, J/kg (Allen et al. 1998, FAO-56).
inline constexpr double kLatentHeat = 2.45e6;
/// Heat capacity of air, J kg⁻¹ K⁻¹ (the same).
inline constexpr double kAirHeat = 1013.0;

/// The air at a leaf or above the ground.
struct Air {
  double temperature = 20.0;     // degrees Celsius
  double vapourPressure = 1.17;  // kPa
  double pressure = 101.3;       // kPa

  /// The vapour pressure that is missing to saturation, kPa; at least 0.
  [[nodiscard]] double deficit() const;
  /// kg m⁻³.
  [[nodiscard]] double density() const;
  /// The psychrometric constant γ, kPa/K.
  [[nodiscard]] double psychrometric() const;
};

/// The saturation vapour pressure over water, kPa, at degrees Celsius (Tetens 1930; Allen et al. 1998, FAO-56, equation
/// 11), and its derivative.
[[nodiscard]] double saturationPressure(double temperature);
[[nodiscard]] double saturationSlope(double temperature);

/// The conductance of the air between a bare surface and the height at which wind, temperature and humidity are
/// measured, m/s: u κ²/(ln(z/z₀) ln(z/0.1 z₀)), κ = 0.41 (Allen et al. 1998, FAO-56, equation 4, without a crop that
/// lifts the wind). `wind` u in m/s; `height` z above `roughness` z₀, both in m.
[[nodiscard]] double airConductance(double wind, double height, double roughness);

/// Water that a wet surface gives off, kg m⁻² s⁻¹: (Δ R + ρ c_p D g)/(λ (Δ + γ)) (Penman 1948), with the available
/// energy R in W/m² and the conductance g of the air in m/s; negative where dew falls.
[[nodiscard]] double wetSurfaceEvaporation(const Air& air, double energy, double conductance);

}  // namespace espalier::environment
