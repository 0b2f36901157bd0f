#include <chrono>

#include "engine/language/checks/model_queries.h"
#include "environment/environment_entries.h"
#include "environment/idle_keys.h"
#include "protocol/codec.h"
#include "server/remote/translation/translate.h"
#include "server/running/limit_errors.h"
#include "server/running/turn_meter.h"
#include "server/server_core.h"
#include "server/session/gallery_forest.h"
#include "server/session/request_work.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

using protocol::ErrorCode;

/// The seed that a run uses: the caller's, else the model's, else one drawn now.
std::uint64_t effectiveSeed(const protocol::CreateParams& params, const simulation::Programs& programs) {
  if (params.seed) {
    return *params.seed;
  }
  for (const auto& program : programs) {
    const auto& model = program->systems.empty() ? std::optional<std::int64_t>() : program->systems.front().seed;
    if (model && *model >= 0) {
      return static_cast<std::uint64_t>(*model);
    }
  }
  return drawSeed();
}

/// The models of a simulation, compiled.
struct CompiledModels {
  simulation::Programs programs;
  files::Palette palette;                 // of all their folders
  std::optional<std::uint64_t> lastStep;  // that the folder of a single model asks for
  std::vector<core::Diagnostic> diagnostics;
  std::string environmentJson;  // that a gallery model brings; empty: none
};

protocol::Expected<CompiledModels> compileModels(ServerCore& core, const protocol::CreateParams& params) {
  std::vector<protocol::ModelParams> models;
  for (const protocol::NamedModel& model : params.models) {
    models.push_back(model.model);
  }
  if (models.empty()) {
    models.push_back(params.model);
  }
  CompiledModels result;
  std::vector<files::Palette> palettes;
  for (const protocol::ModelParams& model : models) {
    auto compiled = core.models().compile(model, core.limits().simulation);
    if (!compiled) {
      return tl::unexpected(std::move(compiled.error()));
    }
    auto& made = *compiled;
    const auto& entries = made.result.diagnostics.entries();
    if (made.result.program == nullptr) {
      return tl::unexpected(toError(entries));
    }
    if (!result.programs.empty() && made.result.program->compatibility != result.programs.front()->compatibility) {
      return tl::unexpected(protocol::memberError("params.models", "all models must have the same \"compatibility\""));
    }
    result.programs.push_back(made.result.program);
    palettes.push_back(std::move(made.palette));
    result.lastStep = models.size() == 1 ? made.lastStep : std::nullopt;
    result.diagnostics.insert(result.diagnostics.end(), entries.begin(), entries.end());
    if (result.environmentJson.empty()) {
      result.environmentJson = std::move(made.environmentJson);
    }
  }
  result.palette =
      palettes.size() == 1 ? std::move(palettes.front()) : simulation::joinedPalettes(result.programs, palettes);
  return result;
}

protocol::CreateResult createResultOf(HostedSimulation& hosted) {
  protocol::CreateResult result;
  result.simulation = hosted.record().id;
  result.step = hosted.simulation().completedSteps();
  result.seed = hosted.record().seed;
  result.derivationLength = hosted.simulation().derivationLength();
  result.plants = static_cast<std::uint32_t>(hosted.simulation().plantCount());
  result.isFinished = hosted.simulation().isFinished();
  result.statistics = toStatistics(hosted.simulation().statistics(), 0.0);
  return result;
}

protocol::Expected<std::string> forkSimulation(ServerCore& core, HostedSimulation& original, const std::string& session,
                                               const std::string& owner, const std::string& title) {
  auto reserved = core.reserve(session, owner);
  if (!reserved) {
    return tl::unexpected(std::move(reserved.error()));
  }
  const std::string& name = *reserved;
  SimulationRecord record = original.record();
  record.id = name;
  record.owner = owner;
  if (!title.empty()) {
    record.create.name = title;
  }
  protocol::Expected<std::unique_ptr<HostedSimulation>> made;
  try {
    made = HostedSimulation::fork(std::move(record), original, core.limits().simulation,
                                  core.environmentServices(core.accounts().of(owner)), core.store());
  } catch (...) {
    core.remove(name);
    throw;
  }
  if (!made) {
    core.remove(name);
    return tl::unexpected(std::move(made.error()));
  }
  auto& hosted = *made;
  const std::string result = protocol::encode(createResultOf(*hosted));
  core.add(name, std::move(hosted));
  return result;
}

/// Warnings that need more than the text of a model: queries without an environment, files that a server does not
/// write.
std::vector<core::Diagnostic> warningsOfRun(const language::Program& program, const HostedSimulation& hosted) {
  std::vector<core::Diagnostic> warnings = language::unwrittenFiles(program);
  // a single environment takes all queries, whatever they are called
  if (hosted.processNames().size() != 1) {
    for (core::Diagnostic& warning : language::unansweredQueries(program, hosted.processNames())) {
      warnings.push_back(std::move(warning));
    }
  }
  return warnings;
}

/// Warnings about keys of the environments that other keys switch off.
std::vector<core::Diagnostic> warningsOfKeys(const std::string& environmentJson) {
  std::vector<core::Diagnostic> warnings;
  const auto entries = environment::parseEnvironmentEntries(environmentJson.empty() ? "[]" : environmentJson);
  for (const environment::EnvironmentEntry& entry : entries.value_or(std::vector<environment::EnvironmentEntry>())) {
    for (core::Diagnostic& warning : environment::idleKeys(entry.type, entry.configuration)) {
      warnings.push_back(std::move(warning));
    }
  }
  return warnings;
}

/// The record from which a restarted server makes the simulation again.
SimulationRecord recordOf(protocol::CreateParams params, const CompiledModels& models, std::string id,
                          std::string owner) {
  SimulationRecord record;
  record.id = std::move(id);
  record.owner = std::move(owner);
  record.seed = effectiveSeed(params, models.programs);
  record.hasSeed = params.seed.has_value();
  record.create = std::move(params);
  if (!record.create.derivationLength) {
    record.create.derivationLength = models.lastStep;
  }
  if (record.create.name.empty()) {
    record.create.name = record.create.model.model.gallery.value_or(models.programs.front()->modelFile);
  }
  record.create.model = {};
  for (protocol::NamedModel& model : record.create.models) {
    model.model = {};
  }
  if (record.create.environmentJson.empty()) {
    record.create.environmentJson = models.environmentJson;
  }
  return record;
}

/// The answer, with all warnings.
protocol::CreateResult resultWithWarnings(HostedSimulation& hosted, const CompiledModels& models) {
  protocol::CreateResult result = createResultOf(hosted);
  result.diagnostics = toRecords(models.diagnostics);
  // in a forest other plants may ask
  if (models.programs.size() == 1 && !hosted.processNames().empty()) {
    if (const auto unasked = language::unaskedEnvironment(*models.programs.front())) {
      result.diagnostics.push_back(toRecords({*unasked}).front());
    }
  }
  for (const auto& program : models.programs) {
    for (protocol::DiagnosticRecord& warning : toRecords(warningsOfRun(*program, hosted))) {
      result.diagnostics.push_back(std::move(warning));
    }
  }
  for (protocol::DiagnosticRecord& warning : toRecords(warningsOfKeys(hosted.record().create.environmentJson))) {
    result.diagnostics.push_back(std::move(warning));
  }
  return result;
}

/// The plants and the world that the folder of a model brings; the mistake in its files, or nothing.
std::optional<protocol::Error> expandFolder(const std::string& galleryFolder, protocol::CreateParams& params) {
  auto problem = expandForest(galleryFolder, params);
  return problem ? problem : expandWorld(galleryFolder, params);
}

/// Compiles, builds, saves and answers. On a worker.
void createSimulation(const Request& request, protocol::CreateParams params, Interruption& interruption) {
  Session& session = request.session;
  const protocol::MessageId& id = request.id;
  ServerCore& core = session.core();
  if (const auto problem = expandFolder(core.options().galleryFolder, params)) {
    session.respondError(id, *problem);
    return;
  }
  core.keepRoom(session.account());
  PartMeter modelMemory;
  auto compiled = [&] {
    const core::WorkMeter::Scope scope(&modelMemory);
    return compileModels(core, params);
  }();
  if (!compiled) {
    session.respondError(id, compiled.error());
    return;
  }
  const CompiledModels& models = *compiled;
  const auto reserved = core.reserve(session.id(), session.account().owner(), params.simulation);
  if (!reserved) {
    session.respondError(id, reserved.error());
    return;
  }
  const std::string& name = *reserved;
  SimulationRecord record = recordOf(std::move(params), models, name, session.account().owner());
  protocol::Expected<std::unique_ptr<HostedSimulation>> made;
  try {
    made = HostedSimulation::create(std::move(record), models.programs, models.palette, core.limits().simulation,
                                    core.environmentServices(session.account()), core.store(), interruption);
  } catch (...) {
    core.remove(name);
    throw;
  }
  if (!made) {
    core.remove(name);
    switch (interruption.reason()) {
      case Interruption::Reason::None:
        session.respondError(id, made.error());
        break;
      case Interruption::Reason::Cancelled:
        session.respondError(id, {ErrorCode::Cancelled, "Cancelled; nothing was created.", {}});
        break;
      case Interruption::Reason::CallSeconds:
        session.respondError(id, callSecondsError(core.limits().callSeconds, "Nothing was created.", {}));
        break;
    }
    return;
  }
  auto& hosted = *made;
  hosted->setModelBytes(modelMemory.net());
  const protocol::CreateResult result = resultWithWarnings(*hosted, models);
  core.add(name, std::move(hosted));
  core.log().info("created", {.session = session.id(), .simulation = name, .token = session.tokenName()});
  session.respond(id, protocol::encode(result));
}

/// The same in the place of a simulation that is there. In its turn; on failure it stays as it is.
protocol::Expected<std::string> replaceSimulation(ServerCore& core, SimulationRunner& runner,
                                                  protocol::CreateParams params) {
  if (auto problem = expandFolder(core.options().galleryFolder, params)) {
    return tl::unexpected(std::move(*problem));
  }
  PartMeter modelMemory;
  auto compiled = [&] {
    const core::WorkMeter::Scope scope(&modelMemory);
    return compileModels(core, params);
  }();
  if (!compiled) {
    return tl::unexpected(compiled.error());
  }
  Interruption ofTurn;  // the runner gives the turn up
  auto made = HostedSimulation::create(
      recordOf(std::move(params), *compiled, runner.id(), runner.hosted().record().owner), compiled->programs,
      compiled->palette, core.limits().simulation, core.environmentServices(runner.account()), core.store(), ofTurn);
  if (!made) {
    return tl::unexpected(std::move(made.error()));
  }
  auto& hosted = *made;
  hosted->setModelBytes(modelMemory.net());
  if (!hosted->record().create.save.isKept) {
    // else the old one would be there again after a restart
    if (auto problem = core.store().remove(runner.id())) {
      return tl::unexpected(protocol::Error{ErrorCode::Storage, "Nothing was changed: " + *problem, {}});
    }
  }
  runner.replace(std::move(hosted));
  return protocol::encode(resultWithWarnings(runner.hosted(), *compiled));
}

}  // namespace

namespace methods {

void simulationCreate(const Request& request, protocol::CreateParams params) {
  ServerCore& core = request.session.core();
  if (const auto damaged = core.findDamaged(params.simulation)) {
    request.session.respondError(request.id, *damaged);
    return;
  }
  if (auto runner = core.find(params.simulation)) {
    computeInTurn(request, std::move(runner), [&core, create = std::move(params)](SimulationRunner& self) {
      return replaceSimulation(core, self, create);
    });
    return;
  }
  const auto interruption = std::make_shared<Interruption>();
  runOnWorker(
      request,
      [create = std::move(params), interruption](const Request& self) mutable {
        createSimulation(self, std::move(create), *interruption);
      },
      interruption);
}

void simulationFork(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::ForkParams params) {
  computeInTurn(request, std::move(runner),
                [core = &request.session.core(), creator = request.session.id(),
                 owner = request.session.account().owner(), name = std::move(params.name)](SimulationRunner& self) {
                  return forkSimulation(*core, self.hosted(), creator, owner, name);
                });
}

}  // namespace methods
}  // namespace espalier::server
