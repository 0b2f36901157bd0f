#include <algorithm>
#include <array>
#include <map>

#include "engine/core/check.h"
#include "engine/derivation/explanation.h"
#include "engine/turtle/export/palette.h"
#include "protocol/base64.h"
#include "protocol/codec.h"
#include "server/remote/translation/translate.h"
#include "server/running/environment_builder.h"
#include "server/server_core.h"
#include "server/session/production_counts.h"
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

std::string lastPart(const std::string& path) {
  return path.substr(path.find_last_of('/') + 1);
}

/// The name of a source without the folder, which is the server's own affair; two files of one name keep it.
std::string nameOfSource(const language::Program& program, const std::string& path) {
  const std::string name = lastPart(path);
  const auto count = std::count_if(program.sources.begin(), program.sources.end(),
                                   [&name](const auto& file) { return lastPart(file.name) == name; });
  return count > 1 ? path : name;
}

/// Adds to the files of a simulation of several models or plants the `forest.json` that makes it again. `mains` has the
/// file of each model.
void writeForest(HostedSimulation& hosted, const std::vector<std::string>& mains, protocol::JsonWriter& result) {
  const protocol::CreateParams& create = hosted.record().create;
  result.key("forest").beginObject().key("models").beginArray();
  for (std::size_t i = 0; i < mains.size(); ++i) {
    const bool isNamed = i < create.models.size();
    result.beginObject().key("name").text(isNamed ? create.models[i].name : "plant").key("file").text(mains[i]);
    result.key("colour").integer(isNamed ? create.models[i].colour : 0).endObject();
  }
  result.endArray();
  writePlants(result, create.plants.empty() ? std::vector<protocol::PlantParams>(1) : create.plants);
  writeSeeds(result, create.seeds);
  result.key("derivationLength").integer(hosted.simulation().derivationLength()).endObject();
}

/// The files of all models by name. A model whose files another one has with other texts has its name before theirs.
Problem writeModel(SimulationRunner& runner, const protocol::GetParams&, protocol::JsonWriter& result) {
  HostedSimulation& hosted = runner.hosted();
  const protocol::CreateParams& create = hosted.record().create;
  const simulation::Programs& programs = hosted.simulation().programs();
  std::map<std::string, std::string> files;
  std::vector<std::string> mains;
  for (const auto& program : programs) {
    const auto nameOf = [&program](const std::string& path) { return nameOfSource(*program, path); };
    const bool hasOther = std::any_of(program->sources.begin(), program->sources.end(), [&](const auto& file) {
      const auto found = files.find(nameOf(file.name));
      return found != files.end() && found->second != file.text;
    });
    const std::string prefix = hasOther ? create.models[mains.size()].name + "-" : "";
    for (const auto& file : program->sources) {
      files.emplace(prefix + nameOf(file.name), file.text);
    }
    mains.push_back(prefix + nameOf(program->modelFile));
  }
  result.key("model").beginObject().key("main").text(mains.front()).key("files").beginObject();
  for (const auto& [name, text] : files) {
    result.key(name).text(text);
  }
  // they win over #define
  result.endObject().key("parameters").beginObject();
  std::map<std::string, std::string> defines;
  for (const auto& program : programs) {
    defines.insert(program->defines.begin(), program->defines.end());
  }
  for (const auto& [name, value] : defines) {
    result.key(name).text(value);
  }
  result.endObject();
  // that the request or the folder gave, not the text
  if (create.derivationLength) {
    result.key("derivationLength").integer(*create.derivationLength);
  }
  if (!create.models.empty() || !create.plants.empty()) {
    writeForest(hosted, mains, result);
  }
  result.endObject();
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
                                                     " of this simulation, it cannot be read now, or it is too large "
                                                     "for an answer; ask for its traces, or download it over HTTP");
  }
  result.key("trace").integer(params.trace).key("content").text(protocol::toBase64(*trace));
  return std::nullopt;
}

Problem writeTurtle(SimulationRunner& runner, const protocol::GetParams& params, protocol::JsonWriter& result) {
  protocol::StreamOpenParams all;
  all.what = "turtle";
  all.select = params.select;
  const auto body = turtleBody(runner.hosted().simulation(), all);
  if (!body) {
    return runner.hosted().errorOf(body.error());
  }
  result.raw(body->json);
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
  if (!explained) {
    return runner.hosted().errorOf(explained.error());
  }
  std::string text = *explained;
  // the replies of the next exchange are not known before the step
  if (!simulation.isAnswered() && !runner.hosted().processNames().empty()) {
    text += "The environment has not answered yet: this uses the values that the modules hold now.\n";
  }
  result.key("explanation").text(text);
  return std::nullopt;
}

Problem writeProductions(SimulationRunner& runner, const protocol::GetParams&, protocol::JsonWriter& result) {
  const simulation::Simulation& simulation = runner.hosted().simulation();
  const auto uses = simulation.productionUses();
  if (uses == nullptr) {
    return protocol::memberError("params.what",
                                 "this simulation does not count; make it with \"countProductions\":true");
  }
  const RunCounts counts = runCounts(simulation.programs(), *uses);
  result.key("since").integer(counts.since).key("productions").beginArray();
  for (const RunCounts::Production& production : counts.productions) {
    result.beginObject().key("production").text(production.text).key("file").text(lastPart(production.place.file));
    result.key("line").integer(production.place.line).key("last").integer(production.last);
    result.key("total").integer(production.total).endObject();
  }
  result.endArray();
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
    Part{"productions", writeProductions},
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
