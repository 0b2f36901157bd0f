#include <array>
#include <cmath>

#include "protocol/codec.h"

namespace espalier::protocol {
namespace {

// bytes of text of a query and a reply, for an environment that needs little
constexpr std::size_t kUsualQueryBytes = 200;
constexpr std::size_t kUsualReplyBytes = 48;

void writeVector(JsonWriter& writer, std::string_view name, std::span<const double> vectors, std::size_t row) {
  if (!vectors.empty()) {
    writer.key(name).numbers(vectors.subspan(3 * row, 3));
  }
}

void writeQuery(JsonWriter& writer, const QueryColumns& queries, std::size_t i) {
  writer.beginObject().key("id").integer(std::uint64_t{i}).key("plant").integer(queries.plant[i]);
  if (!queries.module.empty()) {
    writer.key("module").integer(queries.module[i]);
  }
  if (!queries.isTransient.empty() && queries.isTransient[i] != 0) {
    writer.key("transient").boolean(true);
  }
  writer.key("symbol").text(queries.symbols[queries.symbol[i]]).key("parameters");
  writer.numbers(queries.parameters.subspan(queries.offset[i], queries.offset[i + 1] - queries.offset[i]));
  writeVector(writer, "position", queries.position, i);
  writeVector(writer, "heading", queries.heading, i);
  writeVector(writer, "left", queries.left, i);
  writeVector(writer, "up", queries.up, i);
  if (!queries.width.empty()) {
    writer.key("width").number(queries.width[i]);
  }
  if (!queries.scale.empty()) {
    writer.key("scale").number(queries.scale[i]);
  }
  if (!queries.following.empty() && queries.following[i] != QueryColumns::kNoSymbol) {
    const std::uint64_t begin = queries.followingOffset[i];
    writer.key("following").beginObject().key("symbol").text(queries.symbols[queries.following[i]]);
    writer.key("parameters")
        .numbers(queries.followingParameters.subspan(begin, queries.followingOffset[i + 1] - begin));
    writer.endObject();
  }
  writer.endObject();
}

void writeStep(JsonWriter& writer, const EnvironmentStepParams& params, bool isInBlocks) {
  writer.beginObject().key("simulation").text(params.simulation).key("step").integer(params.step);
  writer.key("iteration").integer(params.iteration).key("time").number(params.timeDays);
  if (params.geometry) {
    write(writer.key("geometry"), *params.geometry, isInBlocks);
  }
}

void requireFinite(std::span<const double> numbers) {
  for (const double number : numbers) {
    if (!std::isfinite(number)) {
      throw NonFiniteNumber();
    }
  }
}

void addColumn(BlockWriter& blocks, const char* name, std::span<const double> numbers, std::uint64_t rows,
               std::uint64_t width) {
  if (!numbers.empty()) {
    requireFinite(numbers);
    blocks.add(name, numbers, width == 0 ? std::vector<std::uint64_t>{rows} : std::vector<std::uint64_t>{rows, width});
  }
}

/// How many numbers every row has; nothing when the rows differ.
std::optional<std::uint64_t> commonWidth(std::span<const std::uint64_t> offset) {
  const std::uint64_t width = offset.size() > 1 ? offset[1] - offset[0] : 0;
  for (std::size_t i = 0; i < offset.size(); ++i) {
    if (offset[i] != i * width) {
      return std::nullopt;
    }
  }
  return width;
}

std::vector<std::uint32_t> narrowed(std::span<const std::uint64_t> numbers) {
  std::vector<std::uint32_t> result;
  result.reserve(numbers.size());
  for (const std::uint64_t number : numbers) {
    result.push_back(static_cast<std::uint32_t>(number));
  }
  return result;
}

/// Rows of numbers: [rows, width] when all have as many, else [total] with a block of offsets.
void addRows(BlockWriter& blocks, const char* name, const char* offsetName, std::span<const double> numbers,
             std::span<const std::uint64_t> offset) {
  requireFinite(numbers);
  if (const auto width = commonWidth(offset)) {
    blocks.add(name, numbers, {offset.size() - 1, *width});
  } else {
    blocks.keep(offsetName, narrowed(offset), {offset.size()});
    blocks.add(name, numbers, {numbers.size()});
  }
}

}  // namespace

std::string encode(const EnvironmentStepParams& params) {
  JsonWriter writer;
  writer.reserve(params.queries.count * kUsualQueryBytes + 200);
  writeStep(writer, params, false);
  writeQueries(writer, params.queries);
  return writer.endObject().take();
}

void writeQueries(JsonWriter& writer, const QueryColumns& queries) {
  writer.key("queries").beginArray();
  for (std::size_t i = 0; i < queries.count; ++i) {
    writeQuery(writer, queries, i);
  }
  writer.endArray();
}

Body encodeBlocks(const EnvironmentStepParams& params) {
  const QueryColumns& queries = params.queries;
  JsonWriter writer;
  writeStep(writer, params, true);
  Body body(writer.key("symbols").texts(queries.symbols).endObject().take());
  addBlocks(body.blocks, queries);
  if (params.geometry) {
    addBlocks(body.blocks, *params.geometry);
  }
  return body;
}

void addBlocks(BlockWriter& blocks, const QueryColumns& queries) {
  const std::uint64_t rows = queries.count;
  blocks.add("plant", queries.plant, {rows});
  if (!queries.module.empty()) {
    blocks.keep("module", narrowed(queries.module), {rows});
  }
  if (!queries.isTransient.empty()) {
    blocks.keep("transient", std::vector<std::uint32_t>(queries.isTransient.begin(), queries.isTransient.end()),
                {rows});
  }
  blocks.add("symbol", queries.symbol, {rows});
  addRows(blocks, "parameters", "parameterOffset", queries.parameters, queries.offset);
  addColumn(blocks, "position", queries.position, rows, 3);
  addColumn(blocks, "heading", queries.heading, rows, 3);
  addColumn(blocks, "left", queries.left, rows, 3);
  addColumn(blocks, "up", queries.up, rows, 3);
  addColumn(blocks, "width", queries.width, rows, 0);
  addColumn(blocks, "scale", queries.scale, rows, 0);
  if (!queries.following.empty()) {
    blocks.add("following", queries.following, {rows});
    addRows(blocks, "followingParameters", "followingOffset", queries.followingParameters, queries.followingOffset);
  }
}

std::string encode(const ReplyColumns& replies) {
  JsonWriter writer;
  writer.reserve(replies.count * kUsualReplyBytes + 20);
  writeReplies(writer.beginObject(), replies);
  if (!replies.notes.empty()) {
    writer.key("notes").texts(replies.notes);
  }
  return writer.endObject().take();
}

void writeReplies(JsonWriter& writer, const ReplyColumns& replies) {
  writer.key("replies").beginArray();
  for (std::size_t i = 0; i < replies.count; ++i) {
    const std::uint64_t id = replies.id.empty() ? i : replies.id[i];
    writer.beginObject().key("id").integer(id).key("parameters").beginArray();
    for (std::uint64_t k = replies.offset[i]; k < replies.offset[i + 1]; ++k) {
      if (replies.isSet.empty() || replies.isSet[k] != 0) {
        writer.number(replies.values[k]);
      } else {
        writer.null();
      }
    }
    writer.endArray().endObject();
  }
  writer.endArray();
}

Body encodeBlocks(const ReplyColumns& replies) {
  JsonWriter writer;
  writer.beginObject();
  if (!replies.notes.empty()) {
    writer.key("notes").texts(replies.notes);
  }
  Body body(writer.endObject().take());
  if (!replies.id.empty()) {
    body.blocks.add("id", replies.id, {replies.count});
  }
  addRows(body.blocks, "parameters", "parameterOffset", replies.values, replies.offset);
  if (!replies.isSet.empty()) {
    const std::vector<std::uint64_t> shape =
        commonWidth(replies.offset) ? std::vector<std::uint64_t>{replies.count, *commonWidth(replies.offset)}
                                    : std::vector<std::uint64_t>{replies.values.size()};
    body.blocks.keep("set", std::vector<std::uint32_t>(replies.isSet.begin(), replies.isSet.end()), shape);
  }
  return body;
}

}  // namespace espalier::protocol
