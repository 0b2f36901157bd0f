#include "engine/turtle/environment_process.h"

#include "engine/turtle/field.h"

namespace espalier::turtle {

void QueryBatch::clear() {
  step = 0;
  iteration = 0;
  timeDays = 0.0;
  plant.clear();
  module.clear();
  symbol.clear();
  isTransient.clear();
  position.clear();
  heading.clear();
  left.clear();
  up.clear();
  width.clear();
  scale.clear();
  parameterOffset.assign(1, 0);
  parameters.clear();
  following.clear();
  followingPair.clear();
  followingOffset.assign(1, 0);
  followingParameters.clear();
  geometry.reset();
}

void ReplyBatch::prepare(const QueryBatch& queries) {
  values.assign(queries.parameters.size(), 0.0);
  isSet.assign(queries.parameters.size(), 0);
  answeredCount = 0;
  surplusCount = 0;
  notes.clear();
}

std::optional<EnvironmentError> EnvironmentProcess::tick(std::uint64_t /*step*/) {
  return std::nullopt;
}

std::string EnvironmentProcess::save() const {
  return {};
}

std::optional<EnvironmentError> EnvironmentProcess::restore(std::string_view state) {
  if (state.empty()) {
    return std::nullopt;
  }
  const EnvironmentDescription description = describe();
  return EnvironmentError{"environment '" + description.name + "' keeps no state but is given " +
                              std::to_string(state.size()) +
                              " bytes of it. Use the environment that the snapshot was made with.",
                          false};
}

std::vector<Field> EnvironmentProcess::fields() const {
  return {};
}

}  // namespace espalier::turtle
