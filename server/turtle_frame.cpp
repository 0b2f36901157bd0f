#include "server/turtle_frame.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>

#include "protocol/json_writer.h"

namespace espalier::server {
namespace {

// where frames part: rows changed together, and rows added or taken away, that are looked for before all rows of the
// earlier frame are searched
constexpr std::size_t kChangedRows = 8;
constexpr std::size_t kAddedRows = 256;

template <typename T>
bool isIn(const std::vector<T>& list, const T& value) {
  return list.empty() || std::find(list.begin(), list.end(), value) != list.end();
}

void addVector(std::vector<double>& column, const core::Vec3& v) {
  if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z)) {
    throw protocol::NonFiniteNumber();
  }
  column.insert(column.end(), {v.x, v.y, v.z});
}

double finite(double number) {
  if (!std::isfinite(number)) {
    throw protocol::NonFiniteNumber();
  }
  return number;
}

bool haveSameBits(const double* a, const double* b, std::size_t count) {
  return std::memcmp(a, b, count * sizeof(double)) == 0;
}

/// Whether row `i` of one frame and row `j` of the other are the same up to what KeptRows adds.
bool areAlike(const TurtleFrame& a, std::size_t i, const TurtleFrame& b, std::size_t j) {
  const std::size_t count = a.parameterOffset[i + 1] - a.parameterOffset[i];
  return haveSameBits(&a.position[3 * i], &b.position[3 * j], 3) && a.symbol[i] == b.symbol[j] &&
         haveSameBits(&a.heading[3 * i], &b.heading[3 * j], 3) && haveSameBits(&a.left[3 * i], &b.left[3 * j], 3) &&
         haveSameBits(&a.up[3 * i], &b.up[3 * j], 3) && haveSameBits(&a.width[i], &b.width[j], 1) &&
         a.colour[i] == b.colour[j] && a.plant[i] == b.plant[j] && a.branchOrder[i] == b.branchOrder[j] &&
         (a.parent[i] == TurtleFrame::kNoParent) == (b.parent[j] == TurtleFrame::kNoParent) &&
         count == b.parameterOffset[j + 1] - b.parameterOffset[j] &&
         haveSameBits(a.parameters.data() + a.parameterOffset[i], b.parameters.data() + b.parameterOffset[j], count);
}

/// Finds a row of a frame by its content. Of rows with the same position and symbol only the first is known, so that
/// a search takes a bounded time.
class RowTable {
 public:
  explicit RowTable(const TurtleFrame& frame) : frame_(frame), slots_(std::bit_ceil(2 * frame.rows() + 2), kEmpty) {
    for (std::size_t row = 0; row < frame.rows(); ++row) {
      std::uint32_t& slot = slotOf(frame, row);
      if (slot == kEmpty) {
        slot = static_cast<std::uint32_t>(row);
      }
    }
  }

  [[nodiscard]] std::optional<std::size_t> find(const TurtleFrame& frame, std::size_t row) {
    const std::uint32_t found = slotOf(frame, row);
    return found != kEmpty && areAlike(frame_, found, frame, row) ? std::optional<std::size_t>(found) : std::nullopt;
  }

 private:
  static constexpr std::uint32_t kEmpty = 0xFFFFFFFF;

  /// The slot with a row of the same position and symbol, or the empty one where it would be.
  std::uint32_t& slotOf(const TurtleFrame& frame, std::size_t row) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = hash(frame, row) & mask;
    while (slots_[slot] != kEmpty && !(haveSameBits(&frame_.position[3 * slots_[slot]], &frame.position[3 * row], 3) &&
                                       frame_.symbol[slots_[slot]] == frame.symbol[row])) {
      slot = (slot + 1) & mask;
    }
    return slots_[slot];
  }

  static std::size_t hash(const TurtleFrame& frame, std::size_t row) {
    std::uint64_t hash = frame.symbol[row];
    for (std::size_t k = 0; k < 3; ++k) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(frame.position[3 * row + k])) * 0x9E3779B97F4A7C15U;
      hash ^= hash >> 29U;
    }
    return static_cast<std::size_t>(hash);
  }

  const TurtleFrame& frame_;
  std::vector<std::uint32_t> slots_;
};

/// Collects the difference row by row.
class Collector {
 public:
  Collector(const TurtleFrame& base, const TurtleFrame& frame) : base_(base), frame_(frame) {}

  void keep(std::size_t from, std::size_t to) {
    const std::uint32_t module = frame_.module[to] - base_.module[from];
    const std::uint32_t index = indexOf(frame_, to) - indexOf(base_, from);
    const bool isRoot = frame_.parent[to] == TurtleFrame::kNoParent;
    const std::uint32_t parent = isRoot ? 0 : frame_.parent[to] - base_.parent[from];
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
  [[nodiscard]] TurtleDifference take() { return std::move(difference_); }

 private:
  static std::uint32_t indexOf(const TurtleFrame& frame, std::size_t row) {
    return frame.index.empty() ? static_cast<std::uint32_t>(row) : frame.index[row];
  }

  const TurtleFrame& base_;
  const TurtleFrame& frame_;
  TurtleDifference difference_;
};

/// Where both frames go on alike: how many rows of each are left out. Nothing within the rows that are looked at.
std::optional<std::pair<std::size_t, std::size_t>> meetingPlace(const TurtleFrame& base, std::size_t i,
                                                                const TurtleFrame& frame, std::size_t j) {
  const auto isMeeting = [&](std::size_t removed, std::size_t added) {
    return i + removed < base.rows() && j + added < frame.rows() && areAlike(base, i + removed, frame, j + added);
  };
  for (std::size_t sum = 1; sum <= kAddedRows; ++sum) {
    // nearest first; far away only where one of them has rows that the other has not
    const std::size_t stride = sum <= kChangedRows ? 1 : sum;
    for (std::size_t added = 0; added <= sum; added += stride) {
      if (isMeeting(sum - added, added)) {
        return std::pair(sum - added, added);
      }
    }
  }
  return std::nullopt;
}

template <typename T>
void appendRows(std::vector<T>& out, const std::vector<T>& column, const std::vector<std::uint32_t>& rows,
                std::size_t width) {
  out.reserve(width * rows.size());
  for (const std::uint32_t row : rows) {
    const auto begin = column.begin() + static_cast<std::ptrdiff_t>(width * row);
    out.insert(out.end(), begin, begin + static_cast<std::ptrdiff_t>(width));
  }
}

template <typename T>
std::uint64_t bytesOf(const std::vector<T>& column) {
  return column.capacity() * sizeof(T);
}

}  // namespace

std::uint64_t TurtleFrame::bytes() const {
  std::uint64_t sum = 0;
  for (const auto* column : {&index, &plant, &module, &symbol, &colour, &branchOrder, &parent, &parameterOffset}) {
    sum += bytesOf(*column);
  }
  for (const auto* column : {&parameters, &position, &heading, &left, &up, &width}) {
    sum += bytesOf(*column);
  }
  return sum;
}

void appendRecord(TurtleFrame& frame, const turtle::TurtleRecord& record, std::uint64_t module, std::uint32_t parent) {
  frame.plant.push_back(record.plant);
  frame.module.push_back(static_cast<std::uint32_t>(module));
  frame.symbol.push_back(record.symbol);
  for (const double parameter : record.parameters) {
    frame.parameters.push_back(finite(parameter));
  }
  frame.parameterOffset.push_back(static_cast<std::uint32_t>(frame.parameters.size()));
  addVector(frame.position, record.position);
  addVector(frame.heading, record.frame.heading);
  addVector(frame.left, record.frame.left);
  addVector(frame.up, record.frame.up);
  frame.width.push_back(finite(record.width));
  frame.colour.push_back(static_cast<std::uint32_t>(record.colour));
  frame.branchOrder.push_back(record.branchOrder);
  frame.parent.push_back(parent == turtle::kNoParent ? TurtleFrame::kNoParent : parent);
}

void reserveRows(TurtleFrame& frame, std::size_t rows) {
  const std::size_t all = frame.rows() + rows;
  for (auto* column : {&frame.plant, &frame.module, &frame.symbol, &frame.colour, &frame.branchOrder, &frame.parent}) {
    column->reserve(all);
  }
  frame.parameterOffset.reserve(all + 1);
  for (auto* column : {&frame.position, &frame.heading, &frame.left, &frame.up}) {
    column->reserve(3 * all);
  }
  frame.width.reserve(all);
}

TurtleFrame makeTurtleFrame(const std::vector<turtle::TurtleRecord>& records,
                            std::shared_ptr<const std::vector<std::string>> symbols,
                            const protocol::StreamSelection& select) {
  const bool isSelective = !select.symbols.empty() || !select.plants.empty();
  TurtleFrame frame;
  frame.symbols = std::move(symbols);
  if (!isSelective) {
    reserveRows(frame, records.size());
  }
  for (std::size_t i = 0; i < records.size(); ++i) {
    const turtle::TurtleRecord& record = records[i];
    if (isSelective) {
      if (!isIn(select.symbols, (*frame.symbols)[record.symbol]) || !isIn(select.plants, record.plant)) {
        continue;
      }
      frame.index.push_back(static_cast<std::uint32_t>(i));
    }
    appendRecord(frame, record, record.module, record.parent);
  }
  return frame;
}

TurtleDifference differenceOf(const TurtleFrame& base, const TurtleFrame& frame) {
  Collector collector(base, frame);
  std::optional<RowTable> table;
  std::size_t i = 0;  // the row of the base that is expected next
  for (std::size_t j = 0; j < frame.rows();) {
    if (i < base.rows() && areAlike(base, i, frame, j)) {
      collector.keep(i++, j++);
      continue;
    }
    // a few rows were taken away, added or changed
    if (!table) {
      if (i == base.rows()) {
        collector.add(j++);
        continue;
      }
      if (const auto place = meetingPlace(base, i, frame, j)) {
        for (std::size_t row = j; row < j + place->second; ++row) {
          collector.add(row);
        }
        i += place->first;
        j += place->second;
        continue;
      }
      table.emplace(base);
    }
    // many were: the row is anywhere, or new
    if (const auto found = table->find(frame, j)) {
      i = *found;
      collector.keep(i++, j);
    } else {
      collector.add(j);
    }
    ++j;
  }
  return collector.take();
}

TurtleFrame rowsOf(const TurtleFrame& frame, const std::vector<std::uint32_t>& rows) {
  TurtleFrame result;
  result.symbols = frame.symbols;
  if (!frame.index.empty()) {
    appendRows(result.index, frame.index, rows, 1);
  }
  appendRows(result.plant, frame.plant, rows, 1);
  appendRows(result.module, frame.module, rows, 1);
  appendRows(result.symbol, frame.symbol, rows, 1);
  appendRows(result.colour, frame.colour, rows, 1);
  appendRows(result.branchOrder, frame.branchOrder, rows, 1);
  appendRows(result.parent, frame.parent, rows, 1);
  appendRows(result.position, frame.position, rows, 3);
  appendRows(result.heading, frame.heading, rows, 3);
  appendRows(result.left, frame.left, rows, 3);
  appendRows(result.up, frame.up, rows, 3);
  appendRows(result.width, frame.width, rows, 1);
  result.parameterOffset.reserve(rows.size() + 1);
  for (const std::uint32_t row : rows) {
    result.parameters.insert(result.parameters.end(), frame.parameters.begin() + frame.parameterOffset[row],
                             frame.parameters.begin() + frame.parameterOffset[row + 1]);
    result.parameterOffset.push_back(static_cast<std::uint32_t>(result.parameters.size()));
  }
  return result;
}

}  // namespace espalier::server
