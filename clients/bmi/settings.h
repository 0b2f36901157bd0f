#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace espalier::bmi {

/// The configuration of a BMI model.
struct Settings {
  std::string file;         // as it was named, for messages
  std::string model;        // path of the file or folder, or the name of a model of the gallery
  bool isGallery = false;   // it is such a name
  std::string environment;  // JSON text: a text, an object or a list; empty: that of the model's folder
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> derivationLength;
  std::optional<double> stepDurationDays;  // nothing: that of the world of the model's folder, else 1
  std::vector<std::string> inputs;
  std::vector<double> inputValues;  // at the start (inputs)
  std::vector<std::string> outputs;
  std::vector<std::pair<std::string, std::string>> parameters;  // name, value as the text of a definition
};

/// Reads a configuration file. Throws BmiError.
[[nodiscard]] Settings readSettings(const std::string& file);

}  // namespace espalier::bmi
