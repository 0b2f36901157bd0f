#include "server/stream/turtle_frame.h"

#include <cmath>

#include "protocol/json_writer.h"
#include "server/stream/row_difference.h"
#include "server/stream/row_selection.h"

namespace espalier::server {
namespace {

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

/// The rows of a frame for RowDifference.
class FrameRows {
 public:
  explicit FrameRows(const TurtleFrame& frame) : frame_(frame) {}

  [[nodiscard]] std::size_t rows() const { return frame_.rows(); }
  [[nodiscard]] RowView row(std::size_t i) const {
    return {.position = &frame_.position[3 * i],
            .heading = &frame_.heading[3 * i],
            .left = &frame_.left[3 * i],
            .up = &frame_.up[3 * i],
            .width = frame_.width[i],
            .plant = frame_.plant[i],
            .module = frame_.module[i],
            .symbol = frame_.symbol[i],
            .colour = frame_.colour[i],
            .branchOrder = frame_.branchOrder[i],
            .parent = frame_.parent[i],
            .index = frame_.index.empty() ? static_cast<std::uint32_t>(i) : frame_.index[i],
            .parameters = {frame_.parameters.data() + frame_.parameterOffset[i],
                           frame_.parameters.data() + frame_.parameterOffset[i + 1]}};
  }

 private:
  const TurtleFrame& frame_;
};

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
  const RowSelection selection(*frame.symbols, select);
  for (std::size_t i = 0; i < records.size(); ++i) {
    const turtle::TurtleRecord& record = records[i];
    if (isSelective) {
      if (!selection.takes(record.plant, record.symbol)) {
        continue;
      }
      frame.index.push_back(static_cast<std::uint32_t>(i));
    }
    appendRecord(frame, record, record.module, record.parent);
  }
  return frame;
}

TurtleDifference differenceOf(const TurtleFrame& base, const TurtleFrame& frame) {
  const FrameRows before(base);
  const FrameRows after(frame);
  return RowDifference(before, after).make();
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
