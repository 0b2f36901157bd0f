#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/vec3.h"

namespace espalier::roots {

/// A function of a root in the Root System Markup Language, as the file has it.
struct RsmlFunction {
  struct Sample {
    double value = 0.0;
    std::optional<double> position;  // along the root from its first point, in lengths of the file
  };
  std::string name;
  std::string domain;  // in small letters; empty: not given
  std::size_t line = 0;
  std::optional<double> origin, step;  // of the positions of samples that have none
  std::vector<Sample> samples;         // at least one
};

/// The values of a function at the points of a root (points), at least one. One sample is the value of the whole root.
/// Otherwise the domain says where the samples are: "polyline", or none: one at each point,
/// and the last points may have none (not a number); "uniform": equally spread
/// from the first point to the last; "length": at their positions, or at origin + i · step. Between two samples values
/// are interpolated linearly along the root, and before the first and behind the last they are constant. The error is
/// a sentence that names the function and the root. O(points + samples · log samples).
[[nodiscard]] tl::expected<std::vector<double>, std::string> valuesAt(const RsmlFunction& function,
                                                                      std::span<const core::Vec3> points,
                                                                      std::string_view rootName);

}  // namespace espalier::roots
