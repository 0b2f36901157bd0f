#include "server/stream/translate_stream.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "protocol/codec.h"
#include "server/remote/translation/translate_environment.h"
#include "server/stream/row_selection.h"

namespace espalier::server {
namespace {

float narrowed(double number) {
  if (std::fabs(number) > std::numeric_limits<float>::max()) {
    throw protocol::NonFiniteNumber();
  }
  return static_cast<float>(number);
}

/// Refers to the numbers, unless they have to be narrowed.
void addNumbers(protocol::BlockWriter& blocks, const char* name, const std::vector<double>& numbers,
                std::vector<std::uint64_t> shape, bool isSinglePrecision) {
  if (!isSinglePrecision) {
    blocks.add(name, std::span<const double>(numbers), std::move(shape));
    return;
  }
  std::vector<float> narrow(numbers.size());
  std::transform(numbers.begin(), numbers.end(), narrow.begin(), narrowed);
  blocks.keep(name, std::move(narrow), std::move(shape));
}

/// Records of a selection say their index.
bool hasIndex(const protocol::StreamOpenParams& params) {
  return !params.select.symbols.empty() || !params.select.plants.empty();
}

void addRows(protocol::BlockWriter& blocks, const std::shared_ptr<const TurtleFrame>& frame,
             const protocol::StreamOpenParams& params) {
  const bool isSinglePrecision = params.isSinglePrecision;
  const std::uint64_t rows = frame->rows();
  const auto addCounts = [&](const char* name, const std::vector<std::uint32_t>& column) {
    blocks.add(name, std::span<const std::uint32_t>(column), {column.size()});
  };
  if (hasIndex(params)) {
    addCounts("index", frame->index);
  }
  addCounts("plant", frame->plant);
  addCounts("module", frame->module);
  addCounts("symbol", frame->symbol);
  addCounts("parameterOffset", frame->parameterOffset);
  addNumbers(blocks, "parameters", frame->parameters, {frame->parameters.size()}, isSinglePrecision);
  addNumbers(blocks, "position", frame->position, {rows, 3}, isSinglePrecision);
  addNumbers(blocks, "heading", frame->heading, {rows, 3}, isSinglePrecision);
  addNumbers(blocks, "left", frame->left, {rows, 3}, isSinglePrecision);
  addNumbers(blocks, "up", frame->up, {rows, 3}, isSinglePrecision);
  addNumbers(blocks, "width", frame->width, {rows}, isSinglePrecision);
  addCounts("colour", frame->colour);
  addCounts("branchOrder", frame->branchOrder);
  addCounts("parent", frame->parent);
  blocks.own(frame);
}

void writeRecords(protocol::JsonWriter& writer, const TurtleFrame& frame, const protocol::StreamOpenParams& params) {
  const auto vectorOf = [](const std::vector<double>& column, std::size_t row) {
    return std::array<double, 3>{column[3 * row], column[3 * row + 1], column[3 * row + 2]};
  };
  writer.reserve(frame.rows() * 250 + 20);
  writer.key("records").beginArray();
  writer.useSinglePrecision(params.isSinglePrecision);
  protocol::TurtleStreamRecord record;
  for (std::size_t row = 0; row < frame.rows(); ++row) {
    record.index = frame.index.empty() ? row : frame.index[row];
    record.plant = frame.plant[row];
    record.module = frame.module[row];
    record.symbol = (*frame.symbols)[frame.symbol[row]];
    record.position = vectorOf(frame.position, row);
    record.heading = vectorOf(frame.heading, row);
    record.left = vectorOf(frame.left, row);
    record.up = vectorOf(frame.up, row);
    record.width = frame.width[row];
    record.colour = static_cast<std::int32_t>(frame.colour[row]);
    record.branchOrder = frame.branchOrder[row];
    record.parent.reset();
    if (frame.parent[row] != TurtleFrame::kNoParent) {
      record.parent = frame.parent[row];
    }
    record.parameters.assign(frame.parameters.begin() + frame.parameterOffset[row],
                             frame.parameters.begin() + frame.parameterOffset[row + 1]);
    write(writer, record, hasIndex(params));
  }
  writer.useSinglePrecision(false);
  writer.endArray();
}

void writeSymbols(protocol::JsonWriter& writer, const std::vector<std::string>& symbols) {
  writer.key("symbols").beginArray();
  for (const std::string& symbol : symbols) {
    writer.text(symbol);
  }
  writer.endArray();
}

/// The added number with its sign: 2^32 - 1 is -1.
std::int64_t signedOf(std::uint32_t number) {
  return static_cast<std::int32_t>(number);
}

turtle::QueryBatch emptyBatch() {
  turtle::QueryBatch batch;
  batch.clear();
  return batch;
}

/// The queries that a selection takes, with their replies.
QueryRecord selected(const QueryRecord& record, const std::vector<std::string>& symbols,
                     const protocol::StreamSelection& select) {
  const RowSelection selection(symbols, select);
  const turtle::QueryBatch& all = record.queries;
  QueryRecord result{emptyBatch(), {}};
  turtle::QueryBatch& some = result.queries;
  some.parameterOffset.assign(1, 0);
  some.followingOffset.assign(1, 0);
  const auto take = [](auto& to, const auto& from, std::size_t row, std::size_t count) {
    if (from.size() == count) {
      to.push_back(from[row]);
    }
  };
  for (std::size_t row = 0; row < all.size(); ++row) {
    if (!selection.takes(all.plant[row], all.symbol[row])) {
      continue;
    }
    some.plant.push_back(all.plant[row]);
    take(some.module, all.module, row, all.size());
    take(some.symbol, all.symbol, row, all.size());
    take(some.isTransient, all.isTransient, row, all.size());
    for (const auto column : {&turtle::QueryBatch::position, &turtle::QueryBatch::heading, &turtle::QueryBatch::left,
                              &turtle::QueryBatch::up}) {
      take(some.*column, all.*column, row, all.size());
    }
    take(some.width, all.width, row, all.size());
    take(some.scale, all.scale, row, all.size());
    const auto begin = static_cast<std::ptrdiff_t>(all.parameterOffset[row]);
    const auto end = static_cast<std::ptrdiff_t>(all.parameterOffset[row + 1]);
    some.parameters.insert(some.parameters.end(), all.parameters.begin() + begin, all.parameters.begin() + end);
    some.parameterOffset.push_back(some.parameters.size());
    result.replies.values.insert(result.replies.values.end(), record.replies.values.begin() + begin,
                                 record.replies.values.begin() + end);
    result.replies.isSet.insert(result.replies.isSet.end(), record.replies.isSet.begin() + begin,
                                record.replies.isSet.begin() + end);
    if (all.following.size() == all.size()) {
      some.following.push_back(all.following[row]);
      const auto following = all.followingParametersOf(row);
      some.followingParameters.insert(some.followingParameters.end(), following.begin(), following.end());
      some.followingOffset.push_back(some.followingParameters.size());
    }
  }
  return result;
}

}  // namespace

protocol::Body encodeTurtle(const std::shared_ptr<const TurtleFrame>& frame, const protocol::StreamOpenParams& params) {
  protocol::JsonWriter json;
  if (!params.isInBlocks) {
    writeRecords(json, *frame, params);
    return protocol::Body(json.take());
  }
  json.key("count").integer(std::uint64_t{frame->rows()});
  writeSymbols(json, *frame->symbols);
  protocol::Body body(json.take());
  addRows(body.blocks, frame, params);
  return body;
}

protocol::Body encodeTurtle(TurtleChange change, const protocol::StreamOpenParams& params) {
  protocol::JsonWriter json;
  json.key("count").integer(std::uint64_t{change.rows});
  if (!params.isInBlocks) {
    json.key("kept").beginArray();
    for (const KeptRows& run : change.kept) {
      json.beginArray().integer(run.to).integer(run.from).integer(run.rows).integer(signedOf(run.module));
      json.integer(signedOf(run.parent));
      if (hasIndex(params)) {
        json.integer(signedOf(run.index));
      }
      json.endArray();
    }
    json.endArray();
    writeRecords(json, *change.fresh, params);
    return protocol::Body(json.take());
  }
  writeSymbols(json, *change.fresh->symbols);
  protocol::Body body(json.take());
  std::vector<std::uint32_t> kept;
  kept.reserve(6 * change.kept.size());
  for (const KeptRows& run : change.kept) {
    kept.insert(kept.end(), {run.to, run.from, run.rows, run.module, run.parent, run.index});
  }
  body.blocks.keep("kept", std::move(kept), {change.kept.size(), 6});
  addRows(body.blocks, change.fresh, params);
  return body;
}

protocol::Body encodeQueries(const std::shared_ptr<const QueryRecord>& record, const std::vector<std::string>& symbols,
                             const protocol::StreamOpenParams& params) {
  auto shown = std::make_shared<const QueryRecord>(record == nullptr ? QueryRecord{emptyBatch(), {}}
                                                                     : selected(*record, symbols, params.select));
  // whatever the environment needed is there
  const protocol::NeedsRecord all{.position = true,
                                  .heading = true,
                                  .left = true,
                                  .up = true,
                                  .width = true,
                                  .scale = true,
                                  .parameters = true,
                                  .following = true,
                                  .geometry = false};
  const protocol::EnvironmentStepParams step = toStepParams({}, shown->queries, all, symbols);
  protocol::JsonWriter json;
  if (!params.isInBlocks) {
    writeQueries(json, step.queries);
    writeReplies(json, toReplies(shown->queries, shown->replies));
    return protocol::Body(json.take());
  }
  json.key("count").integer(std::uint64_t{shown->queries.size()}).key("symbols").texts(step.queries.symbols);
  protocol::Body body(json.take());
  addBlocks(body.blocks, step.queries);
  std::vector<double> values = shown->replies.values;
  for (std::size_t k = 0; k < values.size(); ++k) {
    values[k] = shown->replies.isSet[k] != 0 ? values[k] : 0.0;
  }
  const std::uint64_t count = values.size();
  body.blocks.keep("replies", std::move(values), {count});
  body.blocks.keep("set", std::vector<std::uint32_t>(shown->replies.isSet.begin(), shown->replies.isSet.end()),
                   {count});
  body.blocks.own(step.queries.owner);
  body.blocks.own(shown);
  return body;
}

}  // namespace espalier::server
