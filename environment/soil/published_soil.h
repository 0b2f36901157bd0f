#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "environment/base/configuration.h"
#include "environment/soil/soil_field.h"

namespace espalier::turtle {
class EnvironmentProcess;
struct EnvironmentDescription;
}  // namespace espalier::turtle

namespace espalier::environment {

/// The cells of the process `soil`: concentrations, and maps of 0 and 1 that may be empty.
struct SoilCells {
  SoilField::Shape shape;
  std::vector<double> concentrations;
  std::vector<std::uint8_t> isObstacle;
  std::vector<std::uint8_t> isSource;
};

/// The process `soil` as the published program computes it. Both variants have one description.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makePublishedSoil(SoilCells cells,
                                                                            const Configuration& configuration);
[[nodiscard]] turtle::EnvironmentDescription describeSoil(const std::string& lengthUnit, bool isInSpace);

}  // namespace espalier::environment
