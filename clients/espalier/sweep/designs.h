#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "clients/espalier/result.h"
#include "clients/espalier/sweep/plan.h"

namespace espalier::command {

/// Points of a design, row by row: `columns` values of a point, one for each parameter. In unit designs a value is a
/// probability in (0, 1), or in [0, 1] for Morris.
struct DesignPoints {
  std::size_t columns = 0;
  std::vector<double> values{};
  [[nodiscard]] std::size_t count() const { return columns == 0 ? 0 : values.size() / columns; }
};

/// The largest number of columns of Sobol' points.
inline constexpr std::size_t kSobolColumns = 256;

/// The first `count` points of Sobol' (Gray-code order of Antonov & Saleev 1979) with the direction numbers
/// new-joe-kuo-6.21201 (Joe & Kuo 2008, BSD licence; sobol_numbers.inc). Each point lies in the middle of its cell of
/// 2^-32, so that no value is 0. `shift` is the seed of a random digital shift, other for each column.
[[nodiscard]] DesignPoints sobolPoints(std::uint64_t count, std::size_t columns, std::optional<std::uint64_t> shift);

/// One point in each of `count` equal strata of every column (McKay, Beckman & Conover 1979).
[[nodiscard]] DesignPoints latinHypercube(std::uint64_t count, std::size_t columns, std::uint64_t seed);

/// `count` independent uniform points.
[[nodiscard]] DesignPoints randomPoints(std::uint64_t count, std::size_t columns, std::uint64_t seed);

/// The design for first-order and total indices (Saltelli et al. 2010): for each of `count` pairs A, B of Sobol' points
/// of 2d columns the d + 2 points A, AB(1) ... AB(d), B. AB(i) is A with column i of B.
[[nodiscard]] DesignPoints saltelliPoints(std::uint64_t count, std::size_t columns, std::optional<std::uint64_t> shift);

/// `trajectories` random walks of d + 1 points on a grid of `levels` values in [0, 1]. Each walk changes every column
/// once by levels / (2 (levels - 1)), up or down (Morris 1991).
[[nodiscard]] DesignPoints morrisPoints(std::uint64_t trajectories, std::size_t columns, std::uint64_t levels,
                                        std::uint64_t seed);

/// The values of the parameters at all points that `design` makes, which is no table and no list of rows.
[[nodiscard]] Result<DesignPoints> designValues(const Design& design, const std::vector<SweepParameter>& parameters);

}  // namespace espalier::command
