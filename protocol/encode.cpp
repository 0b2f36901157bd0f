#include "protocol/base64.h"
#include "protocol/codec.h"

namespace espalier::protocol {
namespace {

void writeVector(JsonWriter& writer, std::string_view name, const std::array<double, 3>& vector) {
  writer.key(name).beginArray().number(vector[0]).number(vector[1]).number(vector[2]).endArray();
}

void writePosition(JsonWriter& writer, std::string_view name, const SourcePosition& position) {
  writer.key(name).beginObject().key("line").integer(position.line).key("column").integer(position.column).endObject();
}

void writeLimits(JsonWriter& writer, const std::vector<std::pair<std::string, std::uint64_t>>& limits) {
  writer.key("limits").beginObject();
  for (const auto& [name, bound] : limits) {
    writer.key(name).integer(bound);
  }
  writer.endObject();
}

void writeVariables(JsonWriter& writer, std::string_view name, const std::vector<VariableRecord>& variables) {
  writer.key(name).beginArray();
  for (const VariableRecord& variable : variables) {
    writer.beginObject().key("name").text(variable.name).key("unit").text(variable.unit);
    if (!variable.type.empty()) {
      writer.key("type").text(variable.type);
    }
    writer.endObject();
  }
  writer.endArray();
}

void writeNeeds(JsonWriter& writer, const NeedsRecord& needs) {
  writer.key("needs").beginArray();
  const auto add = [&](bool isNeeded, std::string_view name) {
    if (isNeeded) {
      writer.text(name);
    }
  };
  add(needs.position, "position");
  add(needs.heading, "heading");
  add(needs.left, "left");
  add(needs.up, "up");
  add(needs.width, "width");
  add(needs.scale, "scale");
  add(needs.parameters, "parameters");
  add(needs.following, "following");
  add(needs.geometry, "geometry");
  writer.endArray();
}

}  // namespace

void write(JsonWriter& writer, const std::vector<DiagnosticRecord>& diagnostics) {
  writer.key("diagnostics").beginArray();
  for (const DiagnosticRecord& diagnostic : diagnostics) {
    writer.beginObject().key("severity").text(diagnostic.severity).key("message").text(diagnostic.message);
    if (!diagnostic.file.empty()) {
      writer.key("file").text(diagnostic.file).key("range").beginObject();
      writePosition(writer, "begin", diagnostic.begin);
      writePosition(writer, "end", diagnostic.end);
      writer.endObject();
    }
    if (!diagnostic.hint.empty()) {
      writer.key("hint").text(diagnostic.hint);
    }
    writer.key("text").text(diagnostic.text).endObject();
  }
  writer.endArray();
}

void write(JsonWriter& writer, const Statistics& statistics) {
  writer.key("statistics").beginObject();
  writer.key("step").integer(statistics.step).key("modules").integer(statistics.modules);
  writer.key("parameters").integer(statistics.parameters).key("queries").integer(statistics.queries);
  writer.key("answers").integer(statistics.answers).key("bytes").integer(statistics.bytes);
  if (statistics.iterations > 1) {
    writer.key("iterations").integer(statistics.iterations);
  }
  // a simulation whose plants come and go says so
  if (statistics.births + statistics.deaths > 0 || statistics.plants > 1) {
    writer.key("plants").integer(statistics.plants).key("births").integer(statistics.births);
    writer.key("deaths").integer(statistics.deaths);
  }
  writer.key("milliseconds").number(statistics.milliseconds).endObject();
}

void write(JsonWriter& writer, const WorldRecord& world) {
  writer.key("world").beginObject().key("lengthUnit").text(world.lengthUnit);
  writeVector(writer, "up", world.up);
  writeVector(writer, "north", world.north);
  writer.key("stepDuration").number(world.stepDurationDays);
  if (world.latitudeDegrees) {
    writer.key("latitude").number(*world.latitudeDegrees);
  }
  if (world.longitudeDegrees) {
    writer.key("longitude").number(*world.longitudeDegrees);
  }
  if (!world.start.empty()) {
    writer.key("start").text(world.start);
  }
  if (world.baseTemperature != 0.0) {
    writer.key("baseTemperature").number(world.baseTemperature);
  }
  if (!world.weather.empty()) {
    writer.key("weather").text(world.weather);
  }
  writer.endObject();
}

void write(JsonWriter& writer, const BoundsRecord& bounds) {
  writer.key("bounds").beginArray().numbers(bounds[0]).numbers(bounds[1]).endArray();
}

void write(JsonWriter& writer, const SavePolicy& policy) {
  if (!policy.isKept || policy.every == 1) {
    writer.boolean(policy.isKept);
  } else if (policy.every == 0) {
    writer.text("request");
  } else {
    writer.integer(policy.every);
  }
}

void write(JsonWriter& writer, const SimulationInformation& information) {
  writer.beginObject().key("simulation").text(information.simulation).key("name").text(information.name);
  writer.key("step").integer(information.step).key("derivationLength").integer(information.derivationLength);
  writer.key("seed").integer(information.seed).key("plants").integer(information.plants);
  writer.key("finished").boolean(information.isFinished).key("running").boolean(information.isRunning);
  writer.key("saved").boolean(information.isSaved).key("environment").texts(information.environment);
  if (!information.lastError.empty()) {
    writer.key("lastError").text(information.lastError);
  }
  if (!information.damage.empty()) {
    writer.key("damaged").text(information.damage);
  }
  writer.endObject();
}

void write(JsonWriter& writer, const TurtleStreamRecord& record, bool hasIndex) {
  writer.beginObject();
  if (hasIndex) {
    writer.key("index").integer(record.index);
  }
  writer.key("plant").integer(record.plant).key("module").integer(record.module).key("symbol").text(record.symbol);
  writer.key("parameters").numbers(record.parameters);
  writeVector(writer, "position", record.position);
  writeVector(writer, "heading", record.heading);
  writeVector(writer, "left", record.left);
  writeVector(writer, "up", record.up);
  writer.key("width").number(record.width).key("colour").integer(record.colour);
  writer.key("branchOrder").integer(record.branchOrder).key("parent");
  if (record.parent) {
    writer.integer(*record.parent);
  } else {
    writer.null();
  }
  writer.endObject();
}

std::string encode(const HelloParams& params) {
  JsonWriter writer;
  writer.beginObject().key("protocol").beginArray();
  for (const std::int64_t version : params.protocol) {
    writer.integer(version);
  }
  writer.endArray().key("roles").texts(params.roles).key("name").text(params.name).key("version").text(params.version);
  writer.key("capabilities").texts(params.capabilities);
  if (!params.token.empty()) {
    writer.key("token").text(params.token);
  }
  if (!params.limits.empty()) {
    writeLimits(writer, params.limits);
  }
  return writer.endObject().take();
}

std::string encode(const HelloResult& result) {
  JsonWriter writer;
  writer.beginObject().key("protocol").integer(result.protocol).key("session").text(result.session);
  writer.key("server").text(result.server);
  if (!result.roles.empty()) {
    writer.key("roles").texts(result.roles);
  }
  writer.key("capabilities").texts(result.capabilities);
  writeLimits(writer, result.limits);
  return writer.endObject().take();
}

std::string encode(const ModelResult& result) {
  JsonWriter writer;
  writer.beginObject();
  if (!result.model.empty()) {
    writer.key("model").text(result.model);
  }
  writer.key("valid").boolean(result.isValid);
  if (result.isValid) {
    writer.key("derivationLength").integer(result.derivationLength).key("symbols").texts(result.symbols);
  }
  write(writer, result.diagnostics);
  return writer.endObject().take();
}

std::string encode(const CreateResult& result) {
  JsonWriter writer;
  writer.beginObject().key("simulation").text(result.simulation).key("step").integer(result.step);
  writer.key("seed").integer(result.seed).key("derivationLength").integer(result.derivationLength);
  writer.key("plants").integer(result.plants).key("finished").boolean(result.isFinished);
  write(writer, result.statistics);
  write(writer, result.diagnostics);
  return writer.endObject().take();
}

std::string encode(const StepResult& result) {
  JsonWriter writer;
  writer.reserve(300);
  writer.beginObject().key("step").integer(result.step).key("finished").boolean(result.isFinished);
  writer.key("truncated").boolean(result.isTruncated).key("saved").boolean(result.isSaved);
  write(writer, result.statistics);
  if (!result.printed.empty()) {
    writer.key("printed").text(result.printed);
  }
  return writer.endObject().take();
}

Body encode(StreamData data) {
  JsonWriter writer;
  writer.reserve(data.body.json.size() + 200);
  writer.beginObject().key("stream").text(data.stream).key("simulation").text(data.simulation);
  writer.key("step").integer(data.step).key("sequence").integer(data.sequence).key("key").boolean(data.isKey);
  writer.key("missed").integer(data.missed).key("finished").boolean(data.isFinished).raw(data.body.json);
  Body body(writer.endObject().take());
  body.blocks = std::move(data.body.blocks);
  return body;
}

std::string encode(const OpenParams& params) {
  JsonWriter writer;
  writer.beginObject().key("simulation").text(params.simulation).key("plants").integer(params.plants);
  writer.key("symbols").texts(params.symbols).key("configuration");
  writer.raw(params.configurationJson.empty() ? "{}" : params.configurationJson);
  writer.key("seed").integer(params.seed);
  if (params.resumeStep) {
    writer.key("resume").integer(*params.resumeStep);
  }
  write(writer, params.world);
  if (params.bounds) {
    write(writer, *params.bounds);
  }
  return writer.endObject().take();
}

std::string encode(const RestoreStateParams& params) {
  JsonWriter writer;
  writer.beginObject().key("simulation").text(params.simulation).key("state").text(toBase64(params.state));
  return writer.endObject().take();
}

std::string encode(const DescribeResult& result) {
  JsonWriter writer;
  writer.beginObject().key("name").text(result.name);
  if (!result.summary.empty()) {
    writer.key("summary").text(result.summary);
  }
  writeNeeds(writer, result.needs);
  writeVariables(writer, "inputs", result.inputs);
  writeVariables(writer, "outputs", result.outputs);
  writer.key("stateful").boolean(result.isStateful).key("checkpoint").boolean(result.canCheckpoint);
  if (result.needs.geometry) {
    writer.key("geometry").text(result.takesDifferences ? "difference" : "whole");
  }
  return writer.endObject().take();
}

std::string encodeSaveResult(std::string_view state) {
  JsonWriter writer;
  return writer.beginObject().key("state").text(toBase64(state)).endObject().take();
}

}  // namespace espalier::protocol
