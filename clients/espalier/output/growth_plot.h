#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace espalier::command {

/// The lengths of one model's strings, in modules, by step from 0.
struct GrowthCurve {
  std::string name;
  std::vector<std::uint64_t> lengths;
};

/// An SVG of lengths over steps: steps to the right, lengths upwards on a logarithmic axis with a line for each power
/// of ten; a curve and its name for each model. Lengths of 0 stand on the axis, as 1.
[[nodiscard]] std::string growthPlot(const std::vector<GrowthCurve>& curves);

}  // namespace espalier::command
