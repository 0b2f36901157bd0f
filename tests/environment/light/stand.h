#pragma once

#include <string>
#include <vector>

#include "clients/espalier/validation/canopy.h"
#include "engine/turtle/field.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment {

/// Leaves and the queries about them, for tests of stands.
class Stand : public Canopy {
 public:
  /// One query of so many parameters that stands before no organ.
  [[nodiscard]] turtle::QueryBatch sensor(std::size_t parameters, const core::Vec3& place = {}) const {
    QueryBuilder builder;
    builder.add(place, std::vector<double>(parameters, 0.0));
    builder.batch().module.back() = 2 * count() + 8;
    builder.batch().geometry = geometry();
    return builder.batch();
  }
  /// A query before each organ.
  [[nodiscard]] turtle::QueryBatch queries(std::size_t parameters = 4) const {
    QueryBuilder builder;
    for (std::size_t organ = 0; organ < count(); ++organ) {
      builder.add({}, std::vector<double>(parameters, 0.0));
      builder.batch().module.back() = 2 * organ;
    }
    builder.batch().geometry = geometry();
    return builder.batch();
  }
};

/// The fluxes of the light that comes in: to the sky, down on the ground, absorbed by plants and by the ground.
struct StandFluxes {
  double up = 0.0, down = 0.0, byPlants = 0.0, byGround = 0.0;
};

/// Of the process `light` with a sensor of fluxes.
inline StandFluxes fluxesOf(turtle::EnvironmentProcess& light, const Stand& stand) {
  const auto row = answersOf(light, stand.sensor(4))[0];
  return {*row[0], *row[1], *row[2], *row[3]};
}

/// Of the fields of a process.
inline double fieldValue(const turtle::EnvironmentProcess& process, const std::string& name) {
  for (const turtle::Field& field : process.fields()) {
    if (field.name == name) {
      return field.values.front();
    }
  }
  ADD_FAILURE() << "there is no field " << name;
  return 0.0;
}

}  // namespace espalier::environment
