#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace espalier::language {

/// The solution of linear equations with whole coefficients and whole unknowns from 0 to 2^61 - 2.
struct SolvedLengths {
  bool isContradiction = false;                      // no such numbers exist
  std::vector<std::optional<std::uint64_t>> values;  // by unknown; nothing: the equations do not determine it
};

/// Solves sum over j of coefficients[i][j] * x[j] = right[i] by elimination modulo the prime 2^61 - 1. A solution in
/// whole numbers is also a solution modulo the prime, so a value found is the only possible one; and numbers never
/// grow. The function may overlook that fractions or negative numbers would be needed: the caller tests the values.
/// O(rows * columns * min(rows, columns)).
[[nodiscard]] SolvedLengths solveLengths(const std::vector<std::vector<std::uint64_t>>& coefficients,
                                         const std::vector<std::uint64_t>& right);

}  // namespace espalier::language
