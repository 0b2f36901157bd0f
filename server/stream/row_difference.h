#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/turtle/scene/meeting_place.h"
#include "server/stream/turtle_frame.h"

namespace espalier::server {

/// A row of a turtle stream, wherever it lies. Valid while what it refers to is.
struct RowView {
  const void* position = nullptr;  // three doubles each
  const void* heading = nullptr;
  const void* left = nullptr;
  const void* up = nullptr;
  double width = 0.0;
  std::uint32_t plant = 0;
  std::uint32_t module = 0;
  std::uint32_t symbol = 0;
  std::uint32_t colour = 0;
  std::uint32_t branchOrder = 0;
  std::uint32_t parent = TurtleFrame::kNoParent;
  std::uint32_t index = 0;
  std::span<const double> parameters;
};

/// Whether rows are the same up to what KeptRows adds: bits are compared.
inline bool areAlike(const RowView& a, const RowView& b) {
  constexpr std::size_t kVector = 3 * sizeof(double);
  return std::memcmp(a.position, b.position, kVector) == 0 && a.symbol == b.symbol &&
         std::memcmp(a.heading, b.heading, kVector) == 0 && std::memcmp(a.left, b.left, kVector) == 0 &&
         std::memcmp(a.up, b.up, kVector) == 0 &&
         std::bit_cast<std::uint64_t>(a.width) == std::bit_cast<std::uint64_t>(b.width) && a.colour == b.colour &&
         a.plant == b.plant && a.branchOrder == b.branchOrder &&
         (a.parent == TurtleFrame::kNoParent) == (b.parent == TurtleFrame::kNoParent) &&
         a.parameters.size() == b.parameters.size() &&
         (a.parameters.empty() ||
          std::memcmp(a.parameters.data(), b.parameters.data(), a.parameters.size_bytes()) == 0);
}

/// Finds the rows of an earlier state again. `Rows` has rows() and row(i), a RowView. O(rows): one pass over both when
/// most are kept. Where the lists differ for long, a table of the earlier rows resynchronises them.
template <typename Rows>
class RowDifference {
 public:
  /// Both must outlive the object.
  RowDifference(const Rows& base, const Rows& rows) : base_(base), rows_(rows) {}

  [[nodiscard]] TurtleDifference make() {
    std::size_t i = 0;  // the row of the base that is expected next
    for (std::size_t j = 0; j < rows_.rows();) {
      if (i < base_.rows() && areAlike(base_.row(i), rows_.row(j))) {
        keep(i++, j++);
        continue;
      }
      // a few rows were taken away, added or changed
      if (slots_.empty()) {
        if (i == base_.rows()) {
          add(j++);
          continue;
        }
        if (const auto place = meetingPlace(i, j)) {
          for (std::size_t row = j; row < j + place->second; ++row) {
            add(row);
          }
          i += place->first;
          j += place->second;
          continue;
        }
        buildTable();
      }
      // many rows were: the row is anywhere, or new
      if (const auto found = find(rows_.row(j))) {
        i = *found;
        keep(i++, j);
      } else {
        add(j);
      }
      ++j;
    }
    return std::move(difference_);
  }

 private:
  // how many added or removed rows are tried, where the lists differ, before all rows of the base are searched
  static constexpr std::size_t kAddedRows = 256;
  static constexpr std::uint32_t kEmpty = 0xFFFFFFFF;

  void keep(std::size_t from, std::size_t to) {
    const RowView before = base_.row(from);
    const RowView after = rows_.row(to);
    const std::uint32_t module = after.module - before.module;
    const std::uint32_t index = after.index - before.index;
    const bool isRoot = after.parent == TurtleFrame::kNoParent;
    const std::uint32_t parent = isRoot ? 0 : after.parent - before.parent;
    if (!difference_.kept.empty()) {
      KeptRows& last = difference_.kept.back();
      if (last.to + last.rows == to && last.from + last.rows == from && last.module == module && last.index == index &&
          (isRoot || last.parent == parent)) {
        ++last.rows;
        return;
      }
    }
    difference_.kept.push_back(
        {static_cast<std::uint32_t>(to), static_cast<std::uint32_t>(from), 1, module, parent, index});
  }
  void add(std::size_t row) { difference_.fresh.push_back(static_cast<std::uint32_t>(row)); }

  [[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> meetingPlace(std::size_t i, std::size_t j) const {
    return turtle::meetingPlace(kAddedRows, [&](std::size_t removed, std::size_t added) {
      return i + removed < base_.rows() && j + added < rows_.rows() &&
             areAlike(base_.row(i + removed), rows_.row(j + added));
    });
  }

  /// The table knows only the first of several rows with the same position and symbol, so that a search takes a bounded
  /// time.
  void buildTable() {
    slots_.assign(std::bit_ceil(2 * base_.rows() + 2), kEmpty);
    for (std::size_t row = 0; row < base_.rows(); ++row) {
      std::uint32_t& slot = slotOf(base_.row(row));
      if (slot == kEmpty) {
        slot = static_cast<std::uint32_t>(row);
      }
    }
  }

  [[nodiscard]] std::optional<std::size_t> find(const RowView& row) {
    const std::uint32_t found = slotOf(row);
    return found != kEmpty && areAlike(base_.row(found), row) ? std::optional<std::size_t>(found) : std::nullopt;
  }

  /// The slot with a row of the same position and symbol, or the empty one where it would be.
  std::uint32_t& slotOf(const RowView& row) {
    const std::size_t mask = slots_.size() - 1;
    const auto isThere = [&](const RowView& other) {
      return std::memcmp(other.position, row.position, 3 * sizeof(double)) == 0 && other.symbol == row.symbol;
    };
    std::size_t slot = hash(row) & mask;
    while (slots_[slot] != kEmpty && !isThere(base_.row(slots_[slot]))) {
      slot = (slot + 1) & mask;
    }
    return slots_[slot];
  }

  static std::size_t hash(const RowView& row) {
    std::array<std::uint64_t, 3> position{};
    std::memcpy(position.data(), row.position, sizeof position);
    std::uint64_t hash = row.symbol;
    for (const std::uint64_t bits : position) {
      hash = (hash ^ bits) * 0x9E3779B97F4A7C15U;
      hash ^= hash >> 29U;
    }
    return static_cast<std::size_t>(hash);
  }

  const Rows& base_;
  const Rows& rows_;
  TurtleDifference difference_;
  std::vector<std::uint32_t> slots_;  // rows of the base by their content (a power of two); empty: not needed yet
};

}  // namespace espalier::server
