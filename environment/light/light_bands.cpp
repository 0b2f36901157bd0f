#include "environment/light/light_bands.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "environment/base/number_text.h"

namespace espalier::environment {

namespace {

/// Photons per energy and wavelength, µmol J⁻¹ nm⁻¹: 1/(N h c) with the constants of the SI (2019).
constexpr double kPhotonsPerJouleAndNanometre = 1e-3 / 0.11962656582;

/// A column of a spectrum at a wavelength that its rows cover.
double at(const ConfigurationRows& rows, double wavelength, std::size_t column) {
  const auto next = std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row[0] > wavelength; });
  if (next == rows.begin() || next == rows.end()) {
    return (next == rows.end() ? rows.back() : *next)[column];
  }
  const auto& before = *(next - 1);
  const double part = (wavelength - before[0]) / ((*next)[0] - before[0]);
  return before[column] + part * ((*next)[column] - before[column]);
}

/// The sum over a range of wavelengths of `value`, weighted with the light.
template <typename Value>
double sumOf(const ConfigurationRows& light, double from, double to, const Value& value) {
  const int steps = std::max(1, static_cast<int>(std::ceil(to - from)));
  const double width = (to - from) / steps;
  double sum = 0.0;
  for (int i = 0; i < steps; ++i) {
    const double wavelength = from + (i + 0.5) * width;
    sum += at(light, wavelength, 1) * value(wavelength) * width;
  }
  return sum;
}

LightBand bandFromSpectra(const Configuration& configuration, const std::vector<double>& limits, double total) {
  const ConfigurationRows& light = configuration.rows("lightSpectrum");
  const ConfigurationRows& leaf = configuration.rows("leafSpectrum");
  const ConfigurationRows& ground = configuration.rows("groundSpectrum");
  const auto sum = [&](const auto& value) { return sumOf(light, limits[0], limits[1], value); };
  const double energy = sum([](double) { return 1.0; });
  LightBand band;
  band.part = energy / total;
  band.reflectance = sum([&](double wavelength) { return at(leaf, wavelength, 1); }) / energy;
  band.transmittance = sum([&](double wavelength) { return at(leaf, wavelength, 2); }) / energy;
  band.photonsPerJoule = kPhotonsPerJouleAndNanometre * sum([](double wavelength) { return wavelength; }) / energy;
  if (!ground.empty()) {
    band.groundReflectance = sum([&](double wavelength) { return at(ground, wavelength, 1); }) / energy;
  }
  return band;
}

/// The errors of the keys of spectra.
std::vector<core::Diagnostic> checkSpectra(std::string_view process, const Configuration& configuration) {
  std::vector<core::Diagnostic> errors;
  const auto add = [&](const std::string& sentence, const std::string& hint) {
    errors.push_back(wrongConfiguration(process, sentence, hint));
  };
  const auto& limits = configuration.rows("bandLimits");
  const auto& light = configuration.rows("lightSpectrum");
  const auto& leaf = configuration.rows("leafSpectrum");
  const auto& ground = configuration.rows("groundSpectrum");
  if (limits.empty()) {
    if (!light.empty() || !leaf.empty() || !ground.empty()) {
      add("a spectrum needs 'bandLimits', the wavelengths where each band begins and ends",
          "write for example \"bandLimits\": [[400, 700], [700, 1100]]");
    }
    return errors;
  }
  if (light.empty() || leaf.empty()) {
    add("'bandLimits' needs 'lightSpectrum' and 'leafSpectrum': means over a band depend on the light",
        "give rows of nm and energy, and rows of nm, reflectance and transmittance");
    return errors;
  }
  for (const char* key : {"bands", "reflectance", "transmittance", "photonsPerJoule"}) {
    if (configuration.isGiven(key)) {
      add("'" + std::string(key) + "' follows from the spectra", "leave it out, or leave out 'bandLimits'");
    }
  }
  if (!ground.empty() && configuration.isGiven("groundReflectance")) {
    add("'groundReflectance' follows from 'groundSpectrum'", "give one of the two");
  }
  double low = limits.front()[0];
  double high = limits.front()[1];
  for (const auto& band : limits) {
    if (!(band[0] < band[1])) {
      add("a row of 'bandLimits' does not go from a shorter to a longer wavelength", "write for example [400, 700]");
      return errors;
    }
    low = std::min(low, band[0]);
    high = std::max(high, band[1]);
  }
  for (const auto& [key, rows] : {std::pair<std::string, const ConfigurationRows&>{"lightSpectrum", light},
                                  {"leafSpectrum", leaf},
                                  {"groundSpectrum", ground}}) {
    const bool isAscending =
        std::is_sorted(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a[0] <= b[0]; });
    if (!isAscending) {
      add("the wavelengths of '" + key + "' do not ascend", "sort its rows, and leave out what comes twice");
    } else if (!rows.empty() && (rows.front()[0] > low || rows.back()[0] < high)) {
      add("'" + key + "' covers " + numberText(rows.front()[0]) + " to " + numberText(rows.back()[0]) +
              " nm, and the bands need " + numberText(low) + " to " + numberText(high) + " nm",
          "add rows, or make the bands narrower");
    }
  }
  for (const auto& row : leaf) {
    if (row[1] + row[2] > 1.0) {
      add("'leafSpectrum' scatters more light than comes in at " + numberText(row[0]) + " nm",
          "reflectance and transmittance are parts of 1");
      break;
    }
  }
  for (std::size_t k = 0; k < limits.size() && errors.empty(); ++k) {
    if (!(sumOf(light, limits[k][0], limits[k][1], [](double) { return 1.0; }) > 0.0)) {
      add("'lightSpectrum' has no light in band " + std::to_string(k + 1), "leave out that band");
    }
  }
  return errors;
}

}  // namespace

double numberOfBand(const std::vector<double>& numbers, std::size_t band) {
  return numbers[std::min(band, numbers.size() - 1)];
}

std::vector<LightBand> bandsOf(const Configuration& configuration) {
  std::vector<LightBand> bands;
  const auto& limits = configuration.rows("bandLimits");
  const ConfigurationRows& light = configuration.rows("lightSpectrum");
  const std::size_t count = limits.empty() ? configuration.numbers("bands").size() : limits.size();
  const double total =
      limits.empty() ? 0.0 : sumOf(light, light.front()[0], light.back()[0], [](double) { return 1.0; });
  for (std::size_t k = 0; k < count; ++k) {
    const auto number = [&](const char* key) { return numberOfBand(configuration.numbers(key), k); };
    LightBand band;
    if (limits.empty()) {
      band.part = number("bands");
      band.reflectance = number("reflectance");
      band.transmittance = number("transmittance");
      band.photonsPerJoule = number("photonsPerJoule");
    } else {
      band = bandFromSpectra(configuration, limits[k], total);
    }
    if (limits.empty() || configuration.rows("groundSpectrum").empty()) {
      band.groundReflectance = number("groundReflectance");
    }
    bands.push_back(band);
  }
  return bands;
}

std::vector<core::Diagnostic> checkBands(std::string_view process, const Configuration& configuration,
                                         std::string_view more) {
  std::vector<core::Diagnostic> errors = checkSpectra(process, configuration);
  const auto add = [&](const std::string& sentence, const std::string& hint) {
    errors.push_back(wrongConfiguration(process, sentence, hint));
  };
  const std::size_t limits = configuration.rows("bandLimits").size();
  const std::size_t bands = limits > 0 ? limits : configuration.numbers("bands").size();
  for (const std::string_view key : {std::string_view("photonsPerJoule"), std::string_view("reflectance"),
                                     std::string_view("transmittance"), more, std::string_view("groundReflectance")}) {
    const std::size_t count = configuration.numbers(key).size();
    if (count != 1 && count != bands) {
      add("'" + std::string(key) + "' has " + std::to_string(count) + " numbers for " + std::to_string(bands) +
              " bands",
          "give one number for each band, or one for all");
    }
  }
  for (std::size_t band = 0; band < bands && limits == 0 && errors.empty(); ++band) {
    if (numberOfBand(configuration.numbers("reflectance"), band) +
            numberOfBand(configuration.numbers("transmittance"), band) >
        1.0) {
      add("'reflectance' and 'transmittance' add up to more than 1 in band " + std::to_string(band + 1),
          "organs cannot scatter more light than they get");
    }
  }
  return errors;
}

}  // namespace espalier::environment
