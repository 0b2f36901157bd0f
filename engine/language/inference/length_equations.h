#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace espalier::language {

/// What linear equations with whole coefficients say about whole unknowns that are at least 0 and less than 2^61 - 1.
struct SolvedLengths {
  bool isContradiction = false;                      // no such numbers exist
  std::vector<std::optional<std::uint64_t>> values;  // by unknown; nothing: not determined by the equations
};

/// Solves sum over j of coefficients[i][j] * x[j] = right[i] by elimination modulo the prime 2^61 - 1: what holds for
/// whole numbers holds modulo it, so a value found is the only one possible, and numbers never grow. It may overlook
/// that fractions or negative numbers would be needed: a caller tries the values. O(rows * columns * min(rows,
/// columns)).
[[nodiscard]] SolvedLengths solveLengths(const std::vector<std::vector<std::uint64_t>>& coefficients,
                                         const std::vector<std::uint64_t>& right);

}  // namespace espalier::language
