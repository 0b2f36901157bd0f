#include "engine/language/inference/length_equations.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace espalier::language {
namespace {

__extension__ using Wide = unsigned __int128;

constexpr std::uint64_t kPrime = (std::uint64_t{1} << 61U) - 1;

std::uint64_t times(std::uint64_t a, std::uint64_t b) {
  return static_cast<std::uint64_t>(Wide{a} * b % kPrime);
}

std::uint64_t minus(std::uint64_t a, std::uint64_t b) {
  return a >= b ? a - b : a + kPrime - b;
}

// a^(p-2) is 1/a (Fermat)
std::uint64_t inverse(std::uint64_t a) {
  std::uint64_t result = 1;
  for (std::uint64_t exponent = kPrime - 2; exponent > 0; exponent >>= 1U) {
    if (exponent & 1U) {
      result = times(result, a);
    }
    a = times(a, a);
  }
  return result;
}

using Row = std::vector<std::uint64_t>;

void addMultiple(Row& row, const Row& pivot, std::uint64_t factor) {
  for (std::size_t j = 0; j < row.size(); ++j) {
    row[j] = minus(row[j], times(factor, pivot[j]));
  }
}

}  // namespace

SolvedLengths solveLengths(const std::vector<std::vector<std::uint64_t>>& coefficients,
                           const std::vector<std::uint64_t>& right) {
  const std::size_t unknowns = coefficients.empty() ? 0 : coefficients.front().size();
  SolvedLengths result;
  result.values.resize(unknowns);

  // reduced rows, the right side as the last column
  std::vector<Row> rows;
  for (std::size_t i = 0; i < coefficients.size(); ++i) {
    Row row = coefficients[i];
    row.push_back(right[i]);
    rows.push_back(std::move(row));
  }
  std::size_t done = 0;
  for (std::size_t column = 0; column < unknowns && done < rows.size(); ++column) {
    const auto pivot = std::find_if(rows.begin() + static_cast<std::ptrdiff_t>(done), rows.end(),
                                    [column](const Row& row) { return row[column] != 0; });
    if (pivot == rows.end()) {
      continue;
    }
    std::swap(rows[done], *pivot);
    const std::uint64_t scale = inverse(rows[done][column]);
    for (std::uint64_t& value : rows[done]) {
      value = times(value, scale);
    }
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (i != done && rows[i][column] != 0) {
        addMultiple(rows[i], rows[done], rows[i][column]);
      }
    }
    ++done;
  }

  // a row with one unknown determines it, one with none must be 0 = 0
  for (const Row& row : rows) {
    const auto end = row.end() - 1;
    const auto first = std::find_if(row.begin(), end, [](std::uint64_t value) { return value != 0; });
    if (first == end) {
      result.isContradiction = result.isContradiction || row.back() != 0;
    } else if (std::all_of(first + 1, end, [](std::uint64_t value) { return value == 0; })) {
      result.values[static_cast<std::size_t>(first - row.begin())] = row.back();
    }
  }
  return result;
}

}  // namespace espalier::language
