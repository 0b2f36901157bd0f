#pragma once

#include <cstdint>

namespace espalier::environment {

/// The hydraulic functions of a soil after van Genuchten (1980) and Mualem (1976, l = 1/2), or after Gardner (1958):
/// both S and K/Ks are e^(αh). Heads h are in the world's length unit, negative where water is held by suction;
/// conductivities in length per day.
struct SoilLayer {
  enum class Function : std::uint8_t { VanGenuchten, Gardner };

  double residualContent = 0.078;  // θr
  double saturatedContent = 0.43;  // θs
  double alpha = 3.6;              // 1/length
  double n = 1.56;                 // above 1; not of Gardner's soil
  double conductivity = 0.2496;    // saturated, length/day
  double specificStorage = 1e-6;   // water taken up by saturated soil, 1/length
  Function function = Function::VanGenuchten;

  /// Effective saturation ((θ − θr)/(θs − θr)) at a head: 1 when h ≥ 0.
  [[nodiscard]] double saturation(double head) const;
  /// Volume of water per volume of soil: θ(h), and beyond θs with the specific storage.
  [[nodiscard]] double content(double head) const;
  /// Its derivative, 1/length.
  [[nodiscard]] double capacity(double head) const;
  /// Hydraulic conductivity K(h), length/day.
  [[nodiscard]] double conductivityAt(double head) const;
  /// The head at a water content; −10⁷ lengths at the residual water content.
  [[nodiscard]] double headAt(double content) const;
  /// The head at an effective saturation from 0 to below 1; at least −10⁷ lengths.
  [[nodiscard]] double headAtSaturation(double effective) const;
  /// dK/dh, 1/day; 0 when h ≥ 0.
  [[nodiscard]] double conductivitySlope(double head) const;

  struct Functions {
    double content = 0.0;
    double capacity = 0.0;
    double conductivity = 0.0;
    double conductivitySlope = 0.0;
  };
  /// All functions of a head at once, with the same bits, in half the time.
  [[nodiscard]] Functions at(double head) const;
};

}  // namespace espalier::environment
