#pragma once

#include <memory>
#include <string>

#include "environment/base/configuration.h"
#include "environment/geometry/plane.h"

namespace espalier::turtle {
class EnvironmentProcess;
struct EnvironmentDescription;
}  // namespace espalier::turtle

namespace espalier::environment {

// The processes of this room as the published programs compute them. A process makes its variant when `compatible` is
// set. Both have one description.

[[nodiscard]] turtle::EnvironmentDescription describeHonda();
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makePublishedHonda(double radius, Plane plane);

[[nodiscard]] turtle::EnvironmentDescription describeEcosystem(const std::string& lengthUnit, bool hasVigor);
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makePublishedEcosystem(bool hasVigor, Plane plane);

[[nodiscard]] turtle::EnvironmentDescription describeOrnament(const std::string& lengthUnit);
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makePublishedOrnament(const Configuration& configuration);

}  // namespace espalier::environment
