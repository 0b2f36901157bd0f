#include "server/remote/translation/translate.h"

#include <algorithm>
#include <unordered_map>

#include "engine/turtle/weather.h"
#include "protocol/codec.h"
#include "protocol/errors.h"
#include "server/remote/limits.h"

namespace espalier::server {
namespace {

std::array<double, 3> toArray(const core::Vec3& v) {
  return {v.x, v.y, v.z};
}

std::vector<protocol::VariableRecord> toVariables(const std::vector<turtle::EnvironmentVariable>& variables) {
  std::vector<protocol::VariableRecord> records;
  for (const auto& variable : variables) {
    records.push_back({variable.name, variable.unit, variable.type});
  }
  return records;
}

std::vector<turtle::EnvironmentVariable> fromVariables(const std::vector<protocol::VariableRecord>& records) {
  std::vector<turtle::EnvironmentVariable> variables;
  for (const auto& record : records) {
    variables.push_back({record.name, record.unit, record.type});
  }
  return variables;
}

}  // namespace

core::Vec3 toVec3(const std::array<double, 3>& numbers) {
  return {numbers[0], numbers[1], numbers[2]};
}

protocol::DiagnosticRecord toRecord(const core::Diagnostic& diagnostic) {
  protocol::DiagnosticRecord record;
  switch (diagnostic.severity) {
    case core::Severity::Error:
      record.severity = "error";
      break;
    case core::Severity::Warning:
      record.severity = "warning";
      break;
    case core::Severity::Note:
      record.severity = "note";
      break;
  }
  record.message = diagnostic.message;
  record.file = diagnostic.location.file;
  record.begin = {diagnostic.location.line, diagnostic.location.column};
  record.end = {diagnostic.location.line, diagnostic.location.column + diagnostic.location.length};
  record.hint = diagnostic.hint;
  record.text = core::formatDiagnostic(diagnostic);
  return record;
}

std::vector<protocol::DiagnosticRecord> toRecords(const std::vector<core::Diagnostic>& diagnostics) {
  std::vector<protocol::DiagnosticRecord> records;
  for (const auto& diagnostic : diagnostics) {
    records.push_back(toRecord(diagnostic));
  }
  return records;
}

protocol::Error toError(const core::SimulationError& error, std::uint64_t completedSteps, const core::Limits& limits,
                        const std::vector<std::string>& environment) {
  protocol::Error result;
  switch (error.code) {
    case core::SimulationErrorCode::LimitExceeded:
      result.code = protocol::ErrorCode::Limit;
      break;
    case core::SimulationErrorCode::NonFinite:
      result.code = protocol::ErrorCode::NonFinite;
      break;
    case core::SimulationErrorCode::Model:
      result.code = protocol::ErrorCode::Model;
      break;
    case core::SimulationErrorCode::EnvironmentFailed:
      result.code = protocol::ErrorCode::EnvironmentFailed;
      break;
    case core::SimulationErrorCode::Cancelled:
      result.code = protocol::ErrorCode::Cancelled;
      break;
    case core::SimulationErrorCode::Snapshot:
      result.code = protocol::ErrorCode::Snapshot;
      break;
  }
  result.message = error.message;
  protocol::JsonWriter data;
  data.beginObject().key("step").integer(completedSteps).key("plant").integer(error.plant);
  if (error.code == core::SimulationErrorCode::LimitExceeded) {
    if (const LimitEntry* limit = limitNamedIn(result.message)) {
      data.key("limit").text(limit->name).key("bound").integer(limit->get({.simulation = limits}));
    }
  }
  if (error.code == core::SimulationErrorCode::EnvironmentFailed) {
    std::string names;
    for (const std::string& name : environment) {
      names += (names.empty() ? "" : ", ") + name;
    }
    data.key("environment").text(names);
  }
  if (error.module) {
    data.key("module").integer(*error.module);
  }
  if (!error.location.file.empty()) {
    data.key("file").text(error.location.file).key("line").integer(error.location.line);
    data.key("column").integer(error.location.column);
  }
  result.data = data.key("retryable").boolean(error.isRetryable).endObject().take();
  return result;
}

protocol::Error toError(const std::vector<core::Diagnostic>& diagnostics) {
  std::size_t errorCount = 0;
  std::string first;
  for (const auto& diagnostic : diagnostics) {
    if (diagnostic.severity == core::Severity::Error) {
      ++errorCount;
      if (first.empty()) {
        first = core::formatDiagnostic(diagnostic);
      }
    }
  }
  protocol::JsonWriter data;
  data.beginObject();
  write(data, toRecords(diagnostics));
  data.endObject();
  return {protocol::ErrorCode::Model,
          "The model has " + std::to_string(errorCount) + (errorCount == 1 ? " error" : " errors") +
              "; correct it and send it again. The first: " + first,
          data.take()};
}

protocol::Statistics toStatistics(const simulation::StepStatistics& statistics, double milliseconds) {
  return {.step = statistics.step,
          .modules = statistics.modules,
          .parameters = statistics.parameters,
          .queries = statistics.queries,
          .answers = statistics.answers,
          .bytes = statistics.bytes,
          .plants = statistics.plants,
          .births = statistics.births,
          .deaths = statistics.deaths,
          .milliseconds = milliseconds,
          .iterations = statistics.iterations};
}

protocol::NeedsRecord toNeeds(const turtle::EnvironmentNeeds& needs) {
  return {.position = needs.position,
          .heading = needs.heading,
          .left = needs.left,
          .up = needs.up,
          .width = needs.width,
          .scale = needs.scale,
          .parameters = needs.parameters,
          .following = needs.following,
          .geometry = needs.geometry};
}

protocol::DescribeResult toDescribeResult(const turtle::EnvironmentDescription& description) {
  return {.name = description.name,
          .summary = description.summary,
          .needs = toNeeds(description.needs),
          .inputs = toVariables(description.inputs),
          .outputs = toVariables(description.outputs),
          .isStateful = description.isStateful,
          .canCheckpoint = description.isStateful,
          .takesDifferences = description.needs.geometry};
}

turtle::EnvironmentDescription toDescription(const protocol::DescribeResult& result) {
  turtle::EnvironmentDescription description;
  description.name = result.name;
  description.summary = result.summary;
  description.needs = {.position = result.needs.position,
                       .heading = result.needs.heading,
                       .left = result.needs.left,
                       .up = result.needs.up,
                       .width = result.needs.width,
                       .scale = result.needs.scale,
                       .parameters = result.needs.parameters,
                       .following = result.needs.following,
                       .geometry = result.needs.geometry};
  description.inputs = fromVariables(result.inputs);
  description.outputs = fromVariables(result.outputs);
  description.isStateful = result.isStateful;
  return description;
}

protocol::OpenParams toOpenParams(const turtle::EnvironmentContext& context, const std::string& configurationJson) {
  protocol::OpenParams params;
  params.simulation = context.simulation;
  params.plants = context.plantCount;
  params.symbols = context.symbols;
  params.configurationJson = configurationJson;
  params.seed = context.seed;
  const turtle::World& world = context.world;
  params.world = {.lengthUnit = world.lengthUnit,
                  .up = toArray(world.up),
                  .north = toArray(world.north),
                  .stepDurationDays = world.stepDurationDays,
                  .latitudeDegrees = world.latitudeDegrees,
                  .longitudeDegrees = world.longitudeDegrees,
                  .start = world.start,
                  .baseTemperature = world.baseTemperature,
                  .weather = world.weather ? std::string(world.weather->table()) : std::string()};
  return params;
}

tl::expected<turtle::World, std::string> toWorld(const protocol::WorldRecord& record) {
  turtle::World world{.lengthUnit = record.lengthUnit,
                      .up = toVec3(record.up),
                      .north = toVec3(record.north),
                      .stepDurationDays = record.stepDurationDays,
                      .latitudeDegrees = record.latitudeDegrees,
                      .longitudeDegrees = record.longitudeDegrees,
                      .start = record.start,
                      .baseTemperature = record.baseTemperature,
                      .weather = nullptr};
  if (auto problem = turtle::problemOfWorld(world)) {
    return tl::unexpected(std::move(*problem));
  }
  if (!record.weather.empty()) {
    auto weather = turtle::Weather::read(record.weather, record.start);
    if (!weather) {
      return tl::unexpected("the weather's table, " + weather.error());
    }
    world.weather = std::make_shared<const turtle::Weather>(std::move(*weather));
  }
  return world;
}

tl::expected<turtle::EnvironmentContext, std::string> toContext(const protocol::OpenParams& params) {
  auto world = toWorld(params.world);
  if (!world) {
    return tl::unexpected(std::move(world.error()));
  }
  return turtle::EnvironmentContext{.simulation = params.simulation,
                                    .plantCount = params.plants,
                                    .symbols = params.symbols,
                                    .seed = params.seed,
                                    .world = std::move(*world)};
}

core::Compatibility toCompatibility(const std::string& name) {
  return name == "cpfg"         ? core::Compatibility::Cpfg
         : name == "cpfg-batch" ? core::Compatibility::CpfgBatch
                                : core::Compatibility::Espalier;
}

}  // namespace espalier::server
