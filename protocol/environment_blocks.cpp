#include "protocol/environment_blocks.h"

#include <cmath>

#include "protocol/codec.h"
#include "protocol/column_storage.h"

namespace espalier::protocol {
namespace {

[[noreturn]] void fail(const std::string& place, const std::string& what) {
  throw FieldFailure{fieldError("bin." + place, what)};
}

std::string shapeText(const BlockDescription& block) {
  std::string text = "[";
  for (const std::uint64_t extent : block.shape) {
    text += (text.size() > 1 ? "," : "") + std::to_string(extent);
  }
  return text + "]";
}

/// Reads the blocks of one message.
class ColumnReader {
 public:
  explicit ColumnReader(const Payload& payload) : blocks_(payload.blocks()) {}

  /// The block, or null. Its shape must be [rows], or [rows, width].
  [[nodiscard]] const BlockDescription* column(std::string_view name, std::uint64_t rows,
                                               std::optional<std::uint64_t> width = std::nullopt) const {
    const BlockDescription* block = blocks_->find(name);
    if (block == nullptr) {
      return nullptr;
    }
    const std::vector<std::uint64_t> expected =
        width ? std::vector<std::uint64_t>{rows, *width} : std::vector<std::uint64_t>{rows};
    if (block->shape != expected) {
      fail(block->name,
           "expected the shape " + shapeText({"", block->type, expected, 0, 0}) + ", found " + shapeText(*block));
    }
    return block;
  }
  [[nodiscard]] const BlockDescription& required(std::string_view name) const {
    const BlockDescription* block = blocks_->find(name);
    if (block == nullptr) {
      fail(std::string(name), "the block is missing");
    }
    return *block;
  }

  [[nodiscard]] std::span<const std::uint32_t> integers(const BlockDescription* block) const {
    if (block == nullptr) {
      return {};
    }
    if (block->type != BlockType::Unsigned32) {
      fail(block->name, "expected the dtype <u4, found " + std::string(nameOf(block->type)));
    }
    return blocks_->integers(*block);
  }

  /// Finite numbers; single precision is widened into `storage`.
  [[nodiscard]] std::span<const double> numbers(const BlockDescription* block, std::vector<double>& storage) const {
    if (block == nullptr) {
      return {};
    }
    std::span<const double> numbers;
    if (block->type == BlockType::Float64) {
      numbers = blocks_->doubles(*block);
    } else if (block->type == BlockType::Float32) {
      const auto floats = blocks_->floats(*block);
      storage.assign(floats.begin(), floats.end());
      numbers = storage;
    } else {
      fail(block->name, "expected the dtype <f8 or <f4, found " + std::string(nameOf(block->type)));
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (!std::isfinite(numbers[i])) {
        fail(block->name + "[" + std::to_string(i) + "]", "NaN and infinity are not numbers of the protocol");
      }
    }
    return numbers;
  }

  /// Where each row's numbers lie in a block of the shape [rows, width], or of the shape [total] together with the
  /// block `offsetName` of the shape [rows + 1].
  [[nodiscard]] std::span<const std::uint64_t> offsets(const BlockDescription& block, std::string_view offsetName,
                                                       std::uint64_t rows, std::vector<std::uint64_t>& storage) const {
    storage.resize(rows + 1);
    if (block.shape.size() == 2) {
      (void)column(block.name, rows, block.shape[1]);
      for (std::uint64_t i = 0; i <= rows; ++i) {
        storage[i] = i * block.shape[1];
      }
      return storage;
    }
    if (block.shape.size() != 1) {
      fail(block.name, "expected the shape [rows, numbers] or [numbers], found " + shapeText(block));
    }
    (void)required(offsetName);
    const auto given = integers(column(offsetName, rows + 1));
    std::uint64_t before = 0;
    for (std::uint64_t i = 0; i <= rows; ++i) {
      const bool isRight = given[i] >= before && (i > 0 || given[i] == 0) && (i < rows || given[i] == block.count());
      if (!isRight) {
        fail(std::string(offsetName) + "[" + std::to_string(i) + "]", "expected offsets that rise from 0 to " +
                                                                          std::to_string(block.count()) + ", found " +
                                                                          std::to_string(given[i]));
      }
      before = given[i];
      storage[i] = before;
    }
    return storage;
  }

 private:
  const Blocks* blocks_;
};

std::uint64_t rowsOf(const BlockDescription& block) {
  if (block.shape.empty()) {
    fail(block.name, "expected an array, found one number");
  }
  return block.shape[0];
}

void requireSymbols(std::span<const std::uint32_t> column, const char* name, std::size_t count, bool mayBeNone) {
  for (std::size_t i = 0; i < column.size(); ++i) {
    if (column[i] >= count && !(mayBeNone && column[i] == QueryColumns::kNoSymbol)) {
      fail(std::string(name) + "[" + std::to_string(i) + "]",
           "there is no symbol " + std::to_string(column[i]) + "; params.symbols has " + std::to_string(count));
    }
  }
}

}  // namespace

QueryColumns readQueryBlocks(const Field& params, const Payload& payload) {
  const ColumnReader reader(payload);
  auto storage = std::make_shared<QueryStorage>();
  QueryColumns queries;
  const Field symbols = params["symbols"];
  const std::size_t symbolCount = symbols.arraySize();
  for (std::size_t i = 0; i < symbolCount; ++i) {
    queries.symbols.push_back(symbols.element(i).text());
  }
  const std::uint64_t rows = rowsOf(reader.required("plant"));
  queries.count = rows;
  queries.plant = reader.integers(reader.column("plant", rows));
  (void)reader.required("symbol");
  queries.symbol = reader.integers(reader.column("symbol", rows));
  requireSymbols(queries.symbol, "symbol", symbolCount, false);
  const auto modules = reader.integers(reader.column("module", rows));
  storage->module.assign(modules.begin(), modules.end());
  queries.module = storage->module;
  const auto transient = reader.integers(reader.column("transient", rows));
  storage->isTransient.reserve(transient.size());
  for (const std::uint32_t value : transient) {
    storage->isTransient.push_back(value != 0 ? 1 : 0);
  }
  queries.isTransient = storage->isTransient;
  const BlockDescription& parameters = reader.required("parameters");
  queries.offset = reader.offsets(parameters, "parameterOffset", rows, storage->offset);
  queries.parameters = reader.numbers(&parameters, storage->parameters);
  queries.position = reader.numbers(reader.column("position", rows, 3), storage->position);
  queries.heading = reader.numbers(reader.column("heading", rows, 3), storage->heading);
  queries.left = reader.numbers(reader.column("left", rows, 3), storage->left);
  queries.up = reader.numbers(reader.column("up", rows, 3), storage->up);
  queries.width = reader.numbers(reader.column("width", rows), storage->width);
  queries.scale = reader.numbers(reader.column("scale", rows), storage->scale);
  if (const BlockDescription* following = reader.column("following", rows)) {
    queries.following = reader.integers(following);
    requireSymbols(queries.following, "following", symbolCount, true);
    const BlockDescription& values = reader.required("followingParameters");
    queries.followingOffset = reader.offsets(values, "followingOffset", rows, storage->followingOffset);
    queries.followingParameters = reader.numbers(&values, storage->followingParameters);
  }
  queries.owner = std::make_shared<std::pair<Payload, std::shared_ptr<QueryStorage>>>(payload, std::move(storage));
  return queries;
}

ReplyColumns readReplyBlocks(const Payload& payload, std::size_t queryCount) {
  const ColumnReader reader(payload);
  auto storage = std::make_shared<ReplyStorage>();
  ReplyColumns replies;
  const BlockDescription& parameters = reader.required("parameters");
  const Blocks& blocks = *payload.blocks();
  if (const BlockDescription* id = blocks.find("id")) {
    replies.count = rowsOf(*id);
    replies.id = reader.integers(reader.column("id", replies.count));
  } else if (const BlockDescription* offset = blocks.find("parameterOffset")) {
    const std::uint64_t extent = rowsOf(*offset);
    replies.count = extent == 0 ? 0 : extent - 1;
  } else {
    replies.count = rowsOf(parameters);
  }
  if (replies.id.data() == nullptr && replies.count != queryCount && replies.count != 0) {
    fail("parameters", "expected a row for each of the " + std::to_string(queryCount) +
                           " queries, or a block 'id' that says which are answered, found " +
                           std::to_string(replies.count) + " rows");
  }
  // one number a query may come as a plain column
  if (parameters.shape.size() == 1 && blocks.find("parameterOffset") == nullptr) {
    (void)reader.column("parameters", replies.count);
    storage->offset.resize(replies.count + 1);
    for (std::size_t i = 0; i <= replies.count; ++i) {
      storage->offset[i] = i;
    }
    replies.offset = storage->offset;
  } else {
    replies.offset = reader.offsets(parameters, "parameterOffset", replies.count, storage->offset);
  }
  replies.values = reader.numbers(&parameters, storage->values);
  if (const BlockDescription* set = blocks.find("set")) {
    if (set->shape != parameters.shape) {
      fail("set", "expected the shape " + shapeText(parameters) + " of 'parameters', found " + shapeText(*set));
    }
    for (const std::uint32_t value : reader.integers(set)) {
      storage->isSet.push_back(value != 0 ? 1 : 0);
    }
    replies.isSet = storage->isSet;
  }
  replies.owner = std::make_shared<std::pair<Payload, std::shared_ptr<ReplyStorage>>>(payload, std::move(storage));
  return replies;
}

}  // namespace espalier::protocol
