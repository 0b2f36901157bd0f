#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "environment/base/configuration.h"

namespace espalier::environment {

/// A band of the spectrum.
struct LightBand {
  double part = 1.0;  // of the irradiance
  double reflectance = 0.0;
  double transmittance = 0.0;
  double groundReflectance = 0.0;
  double photonsPerJoule = 0.0;  // µmol/J
};

inline constexpr std::array kOneBand{1.0};
inline constexpr std::array kPhotonsOfPar{4.57};
inline constexpr std::array kLeafReflectance{0.08};
inline constexpr std::array kLeafTransmittance{0.05};
inline constexpr std::array kBareGroundReflectance{0.1};

/// A part of the light in each band, or one number for all.
[[nodiscard]] constexpr ConfigurationKey bandNumbersKey(std::string_view name, std::string_view description,
                                                        std::span<const double> defaults) {
  return {.name = name,
          .kind = KeyKind::Numbers,
          .description = description,
          .minimum = 0.0,
          .maximum = 1.0,
          .defaultNumbers = defaults,
          .minimumCount = 1,
          .isNumberAllowed = true};
}

/// The keys of bands, the same in every process with bands.
inline constexpr std::array kBandKeys{
    ConfigurationKey{.name = "bands",
                     .kind = KeyKind::Numbers,
                     .description = "part of the irradiance in each band of the spectrum",
                     .minimum = 0.0,
                     .defaultNumbers = kOneBand,
                     .minimumCount = 1,
                     .maximumCount = 16},
    ConfigurationKey{.name = "photonsPerJoule",
                     .kind = KeyKind::Numbers,
                     .description = "photons per energy, µmol/J, in each band, or one number for all; 4.57 is PAR",
                     .unit = "umol/J",
                     .minimum = 0.0,
                     .defaultNumbers = kPhotonsOfPar,
                     .minimumCount = 1,
                     .isNumberAllowed = true},
    bandNumbersKey("reflectance", "part of the light that organs reflect, in each band, or one number for all",
                   kLeafReflectance),
    bandNumbersKey("transmittance", "part of the light that passes organs, in each band, or one number for all",
                   kLeafTransmittance),
    bandNumbersKey("groundReflectance",
                   "part of the light that the ground reflects, in each band, or one number for all",
                   kBareGroundReflectance),
    ConfigurationKey{.name = "bandLimits",
                     .kind = KeyKind::Rows,
                     .description = "wavelengths at which each band begins and ends; bands then follow from spectra",
                     .unit = "nm",
                     .minimum = 1.0,
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{.name = "lightSpectrum",
                     .kind = KeyKind::Rows,
                     .description = "spectrum of the light: wavelength in nm, energy per nm in any unit",
                     .minimum = 0.0,
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{.name = "leafSpectrum",
                     .kind = KeyKind::Rows,
                     .description = "spectrum of leaves: wavelength in nm, reflectance, transmittance",
                     .minimum = 0.0,
                     .minimumCount = 3,
                     .maximumCount = 3},
    ConfigurationKey{.name = "groundSpectrum",
                     .kind = KeyKind::Rows,
                     .description = "spectrum of the ground: wavelength in nm, reflectance",
                     .minimum = 0.0,
                     .minimumCount = 2,
                     .maximumCount = 2},
};

/// µmol/s are this many mol/day.
inline constexpr double kMolesPerDay = 0.0864;

/// The number of a band, of a key with one number for each band or one for all.
[[nodiscard]] double numberOfBand(const std::vector<double>& numbers, std::size_t band);

/// The bands of a configuration. With `bandLimits` they follow from the spectra of light, leaves and ground: of each
/// band the part of the light's energy, the means weighted with the light's energy, and the photons λ/(N h c). Spectra
/// are linear between their rows and are summed in steps of 1 nm.
[[nodiscard]] std::vector<LightBand> bandsOf(const Configuration& configuration);

/// The errors of the keys of bands and spectra: numbers that do not fit the bands, also those of `more`,
/// a key of the process's own, and organs that scatter more than they get.
[[nodiscard]] std::vector<core::Diagnostic> checkBands(std::string_view process, const Configuration& configuration,
                                                       std::string_view more);

}  // namespace espalier::environment
