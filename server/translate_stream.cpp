#include <algorithm>
#include <cmath>
#include <limits>

#include "protocol/json_writer.h"
#include "server/translate.h"

namespace espalier::server {
namespace {

constexpr std::uint32_t kNoParent = 0xFFFFFFFF;

template <typename T>
bool isIn(const std::vector<T>& list, const T& value) {
  return list.empty() || std::find(list.begin(), list.end(), value) != list.end();
}

/// The columns of the records of a frame.
struct Columns {
  std::vector<std::uint32_t> index, plant, module, symbol, offset{0}, colour, branchOrder, parent;
  std::vector<double> parameters, position, heading, left, up, width;

  void reserve(std::size_t count) {
    for (auto* column : {&plant, &module, &symbol, &colour, &branchOrder, &parent}) {
      column->reserve(count);
    }
    for (auto* column : {&position, &heading, &left, &up}) {
      column->reserve(3 * count);
    }
    width.reserve(count);
  }

  void add(std::size_t i, const turtle::TurtleRecord& record) {
    index.push_back(static_cast<std::uint32_t>(i));
    plant.push_back(record.plant);
    module.push_back(static_cast<std::uint32_t>(record.module));
    symbol.push_back(record.symbol);
    parameters.insert(parameters.end(), record.parameters.begin(), record.parameters.end());
    offset.push_back(static_cast<std::uint32_t>(parameters.size()));
    addVector(position, record.position);
    addVector(heading, record.frame.heading);
    addVector(left, record.frame.left);
    addVector(up, record.frame.up);
    width.push_back(record.width);
    colour.push_back(static_cast<std::uint32_t>(record.colour));
    branchOrder.push_back(record.branchOrder);
    parent.push_back(record.parent == turtle::kNoParent ? kNoParent : static_cast<std::uint32_t>(record.parent));
  }

  static void addVector(std::vector<double>& column, const core::Vec3& v) {
    column.insert(column.end(), {v.x, v.y, v.z});
  }
};

void keepNumbers(protocol::BlockWriter& blocks, const char* name, std::vector<double> numbers,
                 std::vector<std::uint64_t> shape, bool isSinglePrecision) {
  for (const double number : numbers) {
    if (!std::isfinite(number)) {
      throw protocol::NonFiniteNumber();
    }
  }
  if (isSinglePrecision) {
    std::vector<float> narrow;
    narrow.reserve(numbers.size());
    for (const double number : numbers) {
      if (std::fabs(number) > std::numeric_limits<float>::max()) {
        throw protocol::NonFiniteNumber();
      }
      narrow.push_back(static_cast<float>(number));
    }
    blocks.keep(name, std::move(narrow), std::move(shape));
  } else {
    blocks.keep(name, std::move(numbers), std::move(shape));
  }
}

}  // namespace

protocol::Body encodeTurtleBlocks(const std::vector<turtle::TurtleRecord>& records, const language::Program& program,
                                  const protocol::StreamOpenParams& params) {
  const bool isSelective = !params.select.symbols.empty() || !params.select.plants.empty();
  Columns columns;
  columns.reserve(records.size());
  for (std::size_t i = 0; i < records.size(); ++i) {
    const turtle::TurtleRecord& record = records[i];
    if (!isSelective || (isIn(params.select.symbols, program.symbols[record.symbol].name) &&
                         isIn(params.select.plants, record.plant))) {
      columns.add(i, record);
    }
  }
  const std::uint64_t rows = columns.plant.size();
  protocol::JsonWriter json;
  json.key("count").integer(rows).key("symbols").beginArray();
  for (const language::Symbol& symbol : program.symbols) {
    json.text(symbol.name);
  }
  protocol::Body body(json.endArray().take());
  protocol::BlockWriter& blocks = body.blocks;
  if (isSelective) {
    blocks.keep("index", std::move(columns.index), {rows});
  }
  blocks.keep("plant", std::move(columns.plant), {rows});
  blocks.keep("module", std::move(columns.module), {rows});
  blocks.keep("symbol", std::move(columns.symbol), {rows});
  const std::uint64_t parameterCount = columns.parameters.size();
  blocks.keep("parameterOffset", std::move(columns.offset), {rows + 1});
  keepNumbers(blocks, "parameters", std::move(columns.parameters), {parameterCount}, params.isSinglePrecision);
  keepNumbers(blocks, "position", std::move(columns.position), {rows, 3}, params.isSinglePrecision);
  keepNumbers(blocks, "heading", std::move(columns.heading), {rows, 3}, params.isSinglePrecision);
  keepNumbers(blocks, "left", std::move(columns.left), {rows, 3}, params.isSinglePrecision);
  keepNumbers(blocks, "up", std::move(columns.up), {rows, 3}, params.isSinglePrecision);
  keepNumbers(blocks, "width", std::move(columns.width), {rows}, params.isSinglePrecision);
  blocks.keep("colour", std::move(columns.colour), {rows});
  blocks.keep("branchOrder", std::move(columns.branchOrder), {rows});
  blocks.keep("parent", std::move(columns.parent), {rows});
  return body;
}

}  // namespace espalier::server
