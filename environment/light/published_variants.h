#pragma once

#include <memory>
#include <string>

#include "environment/base/configuration.h"

namespace espalier::turtle {
class EnvironmentProcess;
struct EnvironmentDescription;
}  // namespace espalier::turtle

namespace espalier::environment {

// The processes of this room as the published programs compute them. A process makes its variant when `compatible` is
// set. Both have one description.

[[nodiscard]] turtle::EnvironmentDescription describeChiba(const std::string& lengthUnit);
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makePublishedChiba(const Configuration& configuration);

[[nodiscard]] turtle::EnvironmentDescription describeClover(const std::string& lengthUnit);
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makePublishedClover(const Configuration& configuration);

[[nodiscard]] turtle::EnvironmentDescription describeShadow(const std::string& lengthUnit);
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makePublishedShadow(const Configuration& configuration);

[[nodiscard]] turtle::EnvironmentDescription describeTakenaka(const std::string& lengthUnit);
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> makePublishedTakenaka(const Configuration& configuration);

}  // namespace espalier::environment
