#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/vec3.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"

namespace espalier::environment {

/// The outputs NAMEX, NAMEY, NAMEZ of a direction field.
[[nodiscard]] inline std::vector<turtle::EnvironmentVariable> vectorOutputs(const std::string& name,
                                                                            const std::string& unit) {
  return {{name + "X", unit, ""}, {name + "Y", unit, ""}, {name + "Z", unit, ""}};
}

/// Sets p1–p3 of every query, as far as it has them, to the vector of its place.
template <typename VectorAt>
void replyVectors(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies, const VectorAt& vectorAt) {
  for (std::size_t query = 0; query < queries.size(); ++query) {
    const core::Vec3 vector = vectorAt(queries.position[query]);
    const std::array<double, 3> components{vector.x, vector.y, vector.z};
    for (std::size_t k = 0; k < std::min<std::size_t>(queries.parametersOf(query).size(), 3); ++k) {
      replies.set(queries, query, k, components[k]);
    }
  }
  countAnswers(queries, replies);
}

/// Three numbers as a vector, no numbers as the zero vector; nothing for other counts and for a given zero vector.
[[nodiscard]] inline std::optional<core::Vec3> givenVector(const Configuration& configuration, std::string_view key) {
  const std::vector<double>& numbers = configuration.numbers(key);
  if (numbers.empty()) {
    return core::Vec3{};
  }
  if (numbers.size() != 3 || (numbers[0] == 0.0 && numbers[1] == 0.0 && numbers[2] == 0.0)) {
    return std::nullopt;
  }
  return core::Vec3{numbers[0], numbers[1], numbers[2]};
}

/// The error when givenVector() has nothing.
[[nodiscard]] inline auto refuseDirection(std::string_view process, std::string_view key) {
  return refuse(process, "'" + std::string(key) + "' must be three numbers that are not all 0",
                "write it as [x, y, z], or leave it out");
}

}  // namespace espalier::environment
