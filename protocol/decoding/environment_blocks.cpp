#include "protocol/decoding/environment_blocks.h"

#include "protocol/codec.h"
#include "protocol/decoding/column_reader.h"
#include "protocol/decoding/column_storage.h"

namespace espalier::protocol {
namespace {

void requireSymbols(std::span<const std::uint32_t> column, const char* name, std::size_t count, bool mayBeNone) {
  for (std::size_t i = 0; i < column.size(); ++i) {
    if (column[i] >= count && !(mayBeNone && column[i] == QueryColumns::kNoSymbol)) {
      failBlock(std::string(name) + "[" + std::to_string(i) + "]",
                "there is no symbol " + std::to_string(column[i]) + "; params.symbols has " + std::to_string(count));
    }
  }
}

}  // namespace

QueryColumns readQueryBlocks(const Member& params, const Payload& payload) {
  const ColumnReader reader(payload);
  auto storage = std::make_shared<QueryStorage>();
  QueryColumns queries;
  const Member symbols = params["symbols"];
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
    failBlock("parameters", "expected a row for each of the " + std::to_string(queryCount) +
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
      failBlock("set", "expected the shape " + shapeText(parameters) + " of 'parameters', found " + shapeText(*set));
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
