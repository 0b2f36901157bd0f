#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace espalier::environment {

/// The number of objects over each cell of a raster, at most the largest Count. Emptying it costs the cells between the
/// outermost objects of each row, not the whole raster.
template <typename Count>
class StampedCounts {
 public:
  StampedCounts(std::size_t cellCount, std::size_t cellsInRow)
      : cellsInRow_(cellsInRow), counts_(cellCount, 0), rows_(cellCount / cellsInRow) {}

  void clear() {
    for (Row& row : rows_) {
      std::fill(counts_.data() + row.begin, counts_.data() + row.end, Count{0});
      row = {};
    }
  }
  /// One object more over the cells first to last of a row.
  void stamp(std::size_t first, std::size_t last) {
    Row& row = rows_[first / cellsInRow_];
    const bool isEmpty = row.begin == row.end;
    row = {isEmpty ? first : std::min(row.begin, first), isEmpty ? last + 1 : std::max(row.end, last + 1)};
    Count* const counts = counts_.data();
    for (std::size_t cell = first; cell <= last; ++cell) {
      counts[cell] = static_cast<Count>(counts[cell] + (counts[cell] < std::numeric_limits<Count>::max() ? 1 : 0));
    }
  }
  [[nodiscard]] Count of(std::size_t cell) const { return counts_[cell]; }

 private:
  /// The cells of a row between its outermost objects.
  struct Row {
    std::size_t begin = 0;
    std::size_t end = 0;
  };

  std::size_t cellsInRow_;
  std::vector<Count> counts_;  // (cellCount)
  std::vector<Row> rows_;      // (cellCount / cellsInRow)
};

}  // namespace espalier::environment
