#include <algorithm>
#include <array>

#include "engine/core/check.h"
#include "engine/derivation/explanation.h"
#include "engine/turtle/export/palette.h"
#include "protocol/base64.h"
#include "protocol/codec.h"
#include "server/remote/translation/translate.h"
#include "server/running/environment_builder.h"
#include "server/server_core.h"
#include "server/session/request_work.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

// of a trace in an answer; base64 makes a third more of it
constexpr std::uint64_t kMostTraceBytes = 40'000'000;

// Each function writes the members of one `what`, and returns an error or nothing.
using Problem = std::optional<protocol::Error>;

Problem writeString(SimulationRunner& runner, const protocol::GetParams& params, protocol::JsonWriter& result) {
  result.key("string").text(runner.hosted().simulation().stringText(params.plant));
  return std::nullopt;
}

Problem writeStatistics(SimulationRunner& runner, const protocol::GetParams&, protocol::JsonWriter& result) {
  const simulation::Simulation& simulation = runner.hosted().simulation();
  write(result, toStatistics(simulation.statistics(), runner.milliseconds()));
  result.key("finished").boolean(simulation.isFinished());
  return std::nullopt;
}

Problem writeStateHash(SimulationRunner& runner, const protocol::GetParams&, protocol::JsonWriter& result) {
  // 64 bits do not fit a JSON number
  constexpr std::string_view kDigits = "0123456789abcdef";
  const std::uint64_t hash = runner.hosted().simulation().stateHash();
  std::string text;
  for (unsigned shift = 64; shift > 0; shift -= 4) {
    text += kDigits[(hash >> (shift - 4U)) & 15U];
  }
  result.key("stateHash").text(text);
  return std::nullopt;
}

Problem writeModel(SimulationRunner& runner, const protocol::GetParams&, protocol::JsonWriter& result) {
  const language::Program& program = runner.hosted().simulation().program();
  result.key("model").beginObject().key("main").text(program.modelFile).key("files").beginObject();
  std::string files;
  for (const auto& file : program.sources) {
    protocol::JsonWriter name;
    protocol::JsonWriter text;
    files += (files.empty() ? "" : ",") + name.text(file.name).take() + ":" + text.text(file.text).take();
  }
  if (!files.empty()) {
    result.raw(files);
  }
  result.endObject().endObject();
  return std::nullopt;
}

Problem writeInformation(SimulationRunner& runner, const protocol::GetParams&, protocol::JsonWriter& result) {
  write(result.key("information"), runner.information());
  return std::nullopt;
}

Problem writeEnvironment(SimulationRunner& runner, const protocol::GetParams&, protocol::JsonWriter& result) {
  result.key("environment").raw(readableEnvironment(runner.hosted().record().create.environmentJson));
  return std::nullopt;
}

Problem writeCheckpoints(SimulationRunner& runner, const protocol::GetParams&, protocol::JsonWriter& result) {
  result.key("checkpoints").beginArray();
  for (const Store::Checkpoint& checkpoint : runner.hosted().checkpoints()) {
    result.beginObject().key("checkpoint").text(checkpoint.name).key("step").integer(checkpoint.step);
    result.key("bytes").integer(checkpoint.bytes).endObject();
  }
  result.endArray();
  return std::nullopt;
}

Problem writeTraces(SimulationRunner& runner, const protocol::GetParams&, protocol::JsonWriter& result) {
  result.key("traces").beginArray();
  for (const StoredTrace& trace : runner.hosted().traces()) {
    result.beginObject().key("trace").integer(trace.number).key("bytes").integer(trace.bytes).endObject();
  }
  result.endArray();
  return std::nullopt;
}

Problem writeTrace(SimulationRunner& runner, const protocol::GetParams& params, protocol::JsonWriter& result) {
  const auto trace = runner.hosted().readTrace(params.trace, kMostTraceBytes);
  if (!trace) {
    return protocol::memberError("params.trace", "there is no trace " + std::to_string(params.trace) +
                                                     " of this simulation, or it is too large for an answer; ask for "
                                                     "its traces, or download it over HTTP");
  }
  result.key("trace").integer(params.trace).key("content").text(protocol::toBase64(*trace));
  return std::nullopt;
}

Problem writeTurtle(SimulationRunner& runner, const protocol::GetParams& params, protocol::JsonWriter& result) {
  protocol::StreamOpenParams all;
  all.what = "turtle";
  all.select = params.select;
  const auto body = turtleBody(runner.hosted().simulation(), all);
  if (const auto* error = std::get_if<core::SimulationError>(&body)) {
    return runner.hosted().errorOf(*error);
  }
  result.raw(std::get<protocol::Body>(body).json);
  return std::nullopt;
}

Problem writePalette(SimulationRunner& runner, const protocol::GetParams&, protocol::JsonWriter& result) {
  const simulation::Simulation& simulation = runner.hosted().simulation();
  const files::Palette& ofFolder = simulation.options().palette;
  const files::Palette ofModel = turtle::paletteOf(simulation.view(), ofFolder);
  const turtle::Scene nothing;
  const turtle::Palette palette(nothing, simulation.view(), &ofFolder);
  const auto write = [&result](turtle::Colour colour) {
    result.beginArray().integer(std::uint32_t{colour.red}).integer(std::uint32_t{colour.green});
    result.integer(std::uint32_t{colour.blue}).endArray();
  };
  result.key("isOfModel").boolean(!ofModel.empty()).key("colours").beginArray();
  for (std::int32_t index = 0; index < files::Palette::kBlockSize; ++index) {
    write(palette.ofIndex(index));
  }
  result.endArray().key("background");
  write(palette.background());
  return std::nullopt;
}

Problem writeExplanation(SimulationRunner& runner, const protocol::GetParams& params, protocol::JsonWriter& result) {
  const simulation::Simulation& simulation = runner.hosted().simulation();
  const auto explained =
      derivation::explain(simulation.program(params.plant), simulation.derivationOptions(params.plant),
                          simulation.plantState(params.plant), params.module);
  if (const auto* error = std::get_if<core::SimulationError>(&explained)) {
    return runner.hosted().errorOf(*error);
  }
  std::string text = std::get<std::string>(explained);
  // the replies of the next exchange are not known before the step
  if (!simulation.isAnswered() && !runner.hosted().processNames().empty()) {
    text += "The environment has not answered yet: this uses the values that the modules hold now.\n";
  }
  result.key("explanation").text(text);
  return std::nullopt;
}

struct Part {
  std::string_view what;
  Problem (*write)(SimulationRunner&, const protocol::GetParams&, protocol::JsonWriter&);
};

// the decoder accepts no other value of `what`
constexpr std::array kParts{
    Part{"string", writeString},           Part{"statistics", writeStatistics},
    Part{"state-hash", writeStateHash},    Part{"model", writeModel},
    Part{"information", writeInformation}, Part{"checkpoints", writeCheckpoints},
    Part{"traces", writeTraces},           Part{"trace", writeTrace},
    Part{"turtle", writeTurtle},           Part{"palette", writePalette},
    Part{"explanation", writeExplanation}, Part{"environment", writeEnvironment},
};

protocol::Expected<std::string> readPart(SimulationRunner& runner, const protocol::GetParams& params) {
  const simulation::Simulation& simulation = runner.hosted().simulation();
  if (params.plant >= simulation.plantCount()) {
    return tl::unexpected(protocol::memberError(
        "params.plant", "there is no plant " + std::to_string(params.plant) + "; this simulation has " +
                            std::to_string(simulation.plantCount()) + ", numbered from 0"));
  }
  protocol::JsonWriter result;
  result.beginObject().key("step").integer(simulation.completedSteps());
  const auto part =
      std::find_if(kParts.begin(), kParts.end(), [&](const Part& known) { return known.what == params.what; });
  ESPALIER_CHECK(part != kParts.end());
  if (auto problem = part->write(runner, params, result)) {
    return tl::unexpected(std::move(*problem));
  }
  return result.endObject().take();
}

}  // namespace

namespace methods {

void simulationGet(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::GetParams params) {
  // only drawing can take long
  const auto inTurn = params.what == "turtle" ? computeInTurn : doInTurn;
  inTurn(request, std::move(runner),
         [params = std::move(params)](SimulationRunner& self) { return readPart(self, params); });
}

}  // namespace methods
}  // namespace espalier::server
