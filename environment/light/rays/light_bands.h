#pragma once

#include <vector>

#include "engine/core/diagnostic.h"
#include "environment/base/configuration.h"

namespace espalier::environment {

/// A band of the spectrum, of the process `light`.
struct LightBand {
  double part = 1.0;  // of the irradiance
  double reflectance = 0.0;
  double transmittance = 0.0;
  double stemReflectance = 0.0;
  double groundReflectance = 0.0;
  double photonsPerJoule = 0.0;  // µmol/J
};

/// The bands of a configuration. With `bandLimits` they follow from the spectra of light, leaves and ground: of each
/// band the part of the light's energy, the means weighted with the light's energy, and the photons λ/(N h c). Spectra
/// are linear between their rows and are summed in steps of 1 nm.
[[nodiscard]] std::vector<LightBand> bandsOf(const Configuration& configuration);

/// The errors of the keys of spectra.
[[nodiscard]] std::vector<core::Diagnostic> checkSpectra(const Configuration& configuration);

}  // namespace espalier::environment
