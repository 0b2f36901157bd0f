#include "server/running/hosted_simulation.h"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <new>

#include "engine/core/diagnostic.h"
#include "engine/language/redefinition.h"
#include "engine/simulation/snapshot.h"
#include "engine/simulation/snapshot_editing.h"
#include "protocol/json_writer.h"
#include "server/metrics.h"
#include "server/remote/models/gallery.h"
#include "server/remote/translation/translate.h"
#include "server/running/turn_meter.h"

namespace espalier::server {
namespace {

/// The end of a message about a name that no model has: the nearest one. Empty where none is near.
std::string nearestTo(const std::string& name, const simulation::Programs& programs) {
  // a client and an author of a model choose the names: their number and length are bounded
  constexpr std::size_t kMostNames = 1000;
  constexpr std::size_t kLongest = 100;
  std::vector<std::string_view> names;
  for (const auto& program : programs) {
    const auto& variables = program->systems.front().variables;
    names.insert(names.end(), variables.begin(), variables.end());
    const std::vector<std::string_view> defined = language::definedNames(*program);
    names.insert(names.end(), defined.begin(), defined.end());
  }
  names.resize(std::min(names.size(), kMostNames));
  const std::string_view nearest = name.size() > kLongest ? std::string_view{} : core::nearestName(name, names);
  return nearest.empty() ? std::string{} : ". Did you mean '" + std::string(nearest) + "'?";
}

}  // namespace

HostedSimulation::HostedSimulation(SimulationRecord record, const core::Limits& limits,
                                   const EnvironmentServices& services, Store& store)
    : record_(std::move(record)), limits_(limits), services_(services), store_(&store) {
  if (record_.create.maximumModules) {
    limits_.maximumModules = std::min(limits_.maximumModules, *record_.create.maximumModules);
  }
  if (record_.create.maximumQueries) {
    limits_.maximumQueries = std::min(limits_.maximumQueries, *record_.create.maximumQueries);
  }
}

std::optional<protocol::Error> HostedSimulation::build(simulation::Programs programs, files::Palette palette,
                                                       bool isAbsenceTolerated) {
  EnvironmentServices services = services_;
  services.bounds = record_.create.bounds;
  if (record_.create.isTraced) {
    if (services_.traces.path.empty()) {
      return protocol::memberError("params.trace", "this server keeps nothing; start it with --data to have traces");
    }
    // one from the data folder goes on without, and says so
    const DiskRoom* const room = services_.traces.room;
    if (const DiskRoom* const full = room == nullptr || isAbsenceTolerated ? nullptr : room->full()) {
      return protocol::limitError(std::string(full->limit()), full->used(), full->bound(),
                                  "Delete simulations with traces, or make this one without.");
    }
    auto trace = SimulationTrace::create(services_.traces, record_.id);
    if (!trace) {
      return protocol::Error{protocol::ErrorCode::Storage, trace.error(), {}};
    }
    trace_ = std::move(*trace);
    services.onFailure = [trace = trace_](std::uint64_t step, const std::string& message) {
      trace->note(step, message);
    };
  }
  turtle::World world;
  if (record_.create.world) {
    auto read = toWorld(*record_.create.world);
    if (!read) {
      return protocol::memberError("params.world", read.error());
    }
    world = std::move(*read);
  }
  PartMeter environmentMemory;
  const auto buildMetered = [&] {
    const core::WorkMeter::Scope scope(&environmentMemory);
    return buildEnvironment(record_.create.environmentJson, programs.front()->compatibility, isAbsenceTolerated,
                            services);
  };
  auto built = buildMetered();
  if (!built) {
    return std::move(built.error());
  }
  auto& environment = *built;
  std::vector<simulation::PlantOrigin> plants = plantOrigins(record_.create.models, record_.create.plants);
  if (plants.empty()) {
    plants.emplace_back();
  }
  simulation::SimulationOptions options;
  options.name = record_.id;
  options.palette = std::move(palette);
  options.seed = record_.seed;
  options.hasSeed = record_.hasSeed;
  options.derivationLength = record_.create.derivationLength;
  options.limits = limits_;
  options.coupling = {record_.create.iterations, record_.create.tolerance};
  options.threads = services_.threads;
  options.world = std::move(world);
  options.seeds = seedRules(record_.create.seeds);
  options.environmentOrigin = std::move(environment.origin);
  options.messages = RunMessages::sinkOf(messages_, services_.galleryFolder);
  for (const core::Diagnostic& warning : environment.warnings) {
    options.messages(core::MessageKind::Warning, core::formatDiagnostic(warning));
  }
  *environmentBytes_ = environmentMemory.net();
  auto process = countMemory(std::move(environment.process), environmentBytes_);
  if (trace_ != nullptr) {
    process = trace_->record(std::move(process));
  }
  auto made = std::make_unique<simulation::Simulation>(
      std::move(programs), std::move(plants), QueryRecorder::record(std::move(process), queries_), std::move(options));
  made->countProductions(record_.create.countsProductions);
  const std::lock_guard lock(cancelMutex_);
  simulation_.swap(made);
  links_ = std::move(environment.links);
  environmentNames_ = std::move(environment.names);
  processNames_ = std::move(environment.processNames);
  return std::nullopt;
}

protocol::Expected<std::unique_ptr<HostedSimulation>> HostedSimulation::create(
    SimulationRecord record, simulation::Programs programs, files::Palette palette, const core::Limits& limits,
    const EnvironmentServices& services, Store& store, Interruption& interruption) {
  std::unique_ptr<HostedSimulation> hosted(new HostedSimulation(std::move(record), limits, services, store));
  if (auto error = hosted->build(std::move(programs), std::move(palette), false)) {
    return tl::unexpected(std::move(*error));
  }
  {
    const Interruption::Scope scope(interruption, [&hosted] { hosted->setCancelled(true); });
    if (auto error = hosted->simulation_->rewind()) {
      return tl::unexpected(hosted->errorOf(*error));
    }
  }
  hosted->setCancelled(false);
  hosted->beginTrace();
  if (auto error = hosted->saveNew()) {
    return tl::unexpected(std::move(*error));
  }
  return hosted;
}

protocol::Expected<std::unique_ptr<HostedSimulation>> HostedSimulation::fork(SimulationRecord record,
                                                                             const HostedSimulation& original,
                                                                             const core::Limits& limits,
                                                                             const EnvironmentServices& services,
                                                                             Store& store) {
  std::unique_ptr<HostedSimulation> hosted(new HostedSimulation(std::move(record), limits, services, store));
  if (auto error = hosted->build(original.simulation_->programs(), original.simulation_->options().palette, false)) {
    return tl::unexpected(std::move(*error));
  }
  if (auto error = hosted->simulation_->restore(original.snapshot())) {
    return tl::unexpected(hosted->errorOf(*error));
  }
  hosted->beginTrace();
  if (auto error = hosted->saveNew()) {
    return tl::unexpected(std::move(*error));
  }
  return hosted;
}

protocol::Expected<std::unique_ptr<HostedSimulation>> HostedSimulation::load(SimulationRecord record,
                                                                             std::string_view snapshot,
                                                                             const core::Limits& limits,
                                                                             const EnvironmentServices& services,
                                                                             Store& store) {
  auto read = simulation::readSnapshotInfo(snapshot);
  if (!read) {
    return tl::unexpected(toError(read.error(), 0, limits));
  }
  auto& info = *read;
  PartMeter modelMemory;
  auto compiled = [&] {
    const core::WorkMeter::Scope scope(&modelMemory);
    return simulation::compileModels(info, limits);
  }();
  if (!compiled) {
    return tl::unexpected(toError(compiled.error().entries()));
  }
  std::unique_ptr<HostedSimulation> hosted(new HostedSimulation(std::move(record), limits, services, store));
  hosted->setModelBytes(modelMemory.net());
  if (auto error = hosted->build(std::move(*compiled), info.palette, true)) {
    return tl::unexpected(std::move(*error));
  }
  if (auto error = hosted->simulation_->restore(snapshot)) {
    return tl::unexpected(hosted->errorOf(*error));
  }
  hosted->beginTrace();
  hosted->isSaved_ = true;
  return hosted;
}

protocol::Error HostedSimulation::errorOf(const core::SimulationError& error) const {
  protocol::Error said = toError(error, simulation_->completedSteps(), limits_, environmentNames_);
  said.message = withinGallery(services_.galleryFolder, std::move(said.message));
  return said;
}

protocol::Error HostedSimulation::storageError(const std::string& problem) const {
  protocol::JsonWriter data;
  data.beginObject().key("step").integer(simulation_->completedSteps()).key("retryable").boolean(true).endObject();
  return {protocol::ErrorCode::Storage, problem, data.take()};
}

std::optional<std::string> HostedSimulation::write(bool withRecord) {
  isSaved_ = false;
  if (!isKept()) {
    return std::nullopt;
  }
  const std::uint64_t step = simulation_->completedSteps();
  // also when there is not enough memory for it
  isSaveDue_ = true;
  std::optional<std::string> problem;
  try {
    const std::string state = snapshot();
    problem = withRecord ? store_->save({record_.id, toText(record_), step, record_.owner}, state)
                         : store_->saveState(record_.id, step, state);
  } catch (const std::bad_alloc&) {
    problem = "there is not enough memory to save it. Delete simulations, or use smaller ones.";
  }
  isSaveDue_ = problem.has_value();
  isSaved_ = !isSaveDue_;
  return problem;
}

std::optional<protocol::Error> HostedSimulation::save(bool withRecord) {
  const auto problem = write(withRecord);
  return problem ? std::optional(storageError("Step " + std::to_string(simulation_->completedSteps()) +
                                              " is complete, but " + *problem +
                                              " No further step is made before it is saved."))
                 : std::nullopt;
}

std::optional<protocol::Error> HostedSimulation::change(
    const std::string& before, const std::function<std::optional<core::SimulationError>()>& make) {
  const bool wasSaved = isSaved_;
  const bool wasSaveDue = isSaveDue_;
  if (const auto error = make()) {
    return errorOf(*error);
  }
  isSaved_ = false;
  const auto problem = savesChanges() ? write(false) : std::nullopt;
  const auto lost = problem ? simulation_->restore(before) : std::nullopt;
  beginTrace();
  if (!problem) {
    return std::nullopt;
  }
  if (lost) {
    return storageError("The change is made, but " + *problem +
                        " The state before cannot be restored: " + lost->message);
  }
  isSaved_ = wasSaved;
  isSaveDue_ = wasSaveDue;
  return storageError("Nothing was changed: " + *problem);
}

std::optional<protocol::Error> HostedSimulation::replaceBy(HostedSimulation& fresh, bool isRecordNew) {
  if (const auto problem = isRecordNew || savesChanges() ? fresh.write(isRecordNew) : std::nullopt) {
    return storageError("Nothing was changed: " + *problem);
  }
  adopt(fresh);
  return std::nullopt;
}

std::optional<protocol::Error> HostedSimulation::keep() {
  return isSaved_ ? std::nullopt : save(isSaveDue_);
}

std::optional<protocol::Error> HostedSimulation::step(double& milliseconds) {
  milliseconds = 0.0;
  if (isSaveDue_) {
    if (auto error = save(true)) {
      return error;
    }
  }
  const auto start = std::chrono::steady_clock::now();
  const auto error = simulation_->step();
  milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (Metrics* metrics = services_.metrics) {
    metrics->stepSeconds.observe(milliseconds * 1e-3);
    metrics->queries += simulation_->statistics().queries;
    ++(error ? metrics->failedSteps : metrics->steps);
    metrics->modules += error ? 0 : simulation_->statistics().modules;
  }
  if (error) {
    return errorOf(*error);
  }
  if (trace_ != nullptr) {
    trace_->complete(*simulation_);
  }
  isSaved_ = false;
  const std::uint64_t every = record_.create.save.every;
  const bool isDue = every > 0 && (simulation_->completedSteps() % every == 0 || simulation_->isFinished());
  return isDue ? save(false) : std::nullopt;
}

void HostedSimulation::beginTrace() {
  if (trace_ != nullptr) {
    trace_->begin(*simulation_);
  }
}

void HostedSimulation::closeTrace() {
  if (trace_ != nullptr) {
    trace_->close();
  }
}

std::optional<protocol::Error> HostedSimulation::saveNew() {
  auto error = save(true);
  if (error && trace_ != nullptr) {
    trace_->discard();
  }
  return error;
}

std::optional<protocol::Error> HostedSimulation::reset(std::optional<std::uint64_t> seed) {
  if (!seed) {
    messages_->forgetWarnings();
    return change(stateBefore(), [this] { return simulation_->rewind(); });
  }
  // a simulation has its seed for life: make another, which takes the place of the old one when it is ready
  SimulationRecord record = record_;
  record.seed = *seed;
  record.hasSeed = true;
  HostedSimulation fresh(std::move(record), limits_, services_, *store_);
  if (auto error = fresh.build(simulation_->programs(), simulation_->options().palette, false)) {
    return error;
  }
  if (const auto failure = fresh.simulation_->rewind()) {
    return errorOf(*failure);
  }
  return replaceBy(fresh, true);
}

void HostedSimulation::adopt(HostedSimulation& fresh) {
  record_ = fresh.record_;
  {
    const std::lock_guard lock(cancelMutex_);
    simulation_.swap(fresh.simulation_);
    links_.swap(fresh.links_);
  }
  environmentBytes_.swap(fresh.environmentBytes_);
  queries_.swap(fresh.queries_);
  messages_.swap(fresh.messages_);
  isSaved_ = fresh.isSaved_;
  isSaveDue_ = fresh.isSaveDue_;
  trace_ = fresh.trace_;
  beginTrace();
}

std::optional<protocol::Error> HostedSimulation::edit(const protocol::EditParams& params) {
  simulation::StringEdit edit;
  edit.kind = params.action == "prune"     ? simulation::StringEdit::Kind::Prune
              : params.action == "replace" ? simulation::StringEdit::Kind::Replace
                                           : simulation::StringEdit::Kind::Insert;
  edit.plant = params.plant;
  edit.module = params.module;
  for (const protocol::ModuleRecord& module : params.modules) {
    core::pollWork();
    edit.modules.push_back({module.symbol, module.parameters});
  }
  const std::string before = snapshot();
  const auto edited = simulation::editString(before, edit);
  if (!edited) {
    return errorOf(edited.error());
  }
  return change(before, [&] { return simulation_->restore(*edited); });
}

std::optional<protocol::Error> HostedSimulation::set(const std::vector<std::pair<std::string, std::string>>& values) {
  const simulation::Programs& programs = simulation_->programs();
  const auto isVariable = [&programs](const std::string& name) {
    return std::any_of(programs.begin(), programs.end(), [&name](const auto& program) {
      const auto& names = program->systems.front().variables;
      return std::find(names.begin(), names.end(), name) != names.end();
    });
  };
  std::vector<std::pair<std::string, double>> variables;
  std::vector<std::pair<std::string, std::string>> defines;
  for (const auto& [name, text] : values) {
    if (!isVariable(name)) {
      defines.emplace_back(name, text);
      continue;
    }
    double number = 0.0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (problem != std::errc() || end != text.data() + text.size()) {
      return protocol::memberError("params.parameters." + name, "expected a number for a variable");
    }
    variables.emplace_back(name, number);
  }
  // definitions first: they are what can fail
  if (!defines.empty()) {
    if (!variables.empty()) {
      return protocol::memberError(
          "params.parameters", "variables and #defines in one call could fail half-way; set them one after the other");
    }
    return define(defines);
  }
  const std::string before = snapshot();
  const auto edited = simulation::setVariables(before, programs, variables);
  if (!edited) {
    return errorOf(edited.error());
  }
  return change(before, [&] { return simulation_->restore(*edited); });
}

std::optional<protocol::Error> HostedSimulation::define(
    const std::vector<std::pair<std::string, std::string>>& defines) {
  for (const auto& [name, value] : defines) {
    const auto hasName = [&name = name](const auto& program) { return language::definesName(*program, name); };
    if (std::none_of(simulation_->programs().begin(), simulation_->programs().end(), hasName)) {
      return protocol::memberError(
          "params.parameters." + name,
          "the model has neither a variable nor a #define of that name" + nearestTo(name, simulation_->programs()));
    }
  }
  // each model that defines a name takes the new value
  simulation::Programs programs;
  for (const auto& program : simulation_->programs()) {
    auto compiled = language::withDefinitions(*program, defines, limits_);
    if (compiled.program == nullptr) {
      return toError(compiled.diagnostics.entries());
    }
    programs.push_back(std::move(compiled.program));
  }
  HostedSimulation fresh(record_, limits_, services_, *store_);
  if (auto error = fresh.build(programs, simulation_->options().palette, false)) {
    return error;
  }
  const auto edited = simulation::withPrograms(snapshot(), programs);
  if (!edited) {
    return errorOf(edited.error());
  }
  if (const auto error = fresh.simulation_->restore(*edited)) {
    return errorOf(*error);
  }
  return replaceBy(fresh, false);
}

std::string HostedSimulation::snapshot() const {
  core::StringSink sink;
  simulation_->save(sink);
  return sink.take();
}

std::optional<protocol::Error> HostedSimulation::restore(std::string_view snapshot) {
  return change(stateBefore(), [this, snapshot] { return simulation_->restore(snapshot); });
}

std::optional<protocol::Error> HostedSimulation::saveCheckpoint(const std::string& name) {
  if (!store_->isKept()) {
    return storageError("This server keeps no checkpoints. Start it with --data DIR, or ask for the snapshot itself.");
  }
  const auto problem = store_->saveCheckpoint(record_.id, name, simulation_->completedSteps(), snapshot());
  return problem ? std::optional(storageError(*problem)) : std::nullopt;
}

std::optional<protocol::Error> HostedSimulation::restoreCheckpoint(const std::string& name) {
  const Store::State state = readCheckpoint(name);
  if (!state.problem.empty()) {
    return storageError("The simulation stays as it is: " + state.problem + ".");
  }
  return restore(state.bytes);
}

std::optional<protocol::Error> HostedSimulation::setTraced(bool isTraced) {
  if (isTraced == this->isTraced()) {
    return std::nullopt;
  }
  // the recorder stands between the simulation and its environment: make another simulation in the same state
  SimulationRecord record = record_;
  record.create.isTraced = isTraced;
  HostedSimulation fresh(std::move(record), limits_, services_, *store_);
  if (auto error = fresh.build(simulation_->programs(), simulation_->options().palette, false)) {
    return error;
  }
  if (const auto error = fresh.simulation_->restore(snapshot())) {
    return errorOf(*error);
  }
  if (auto error = replaceBy(fresh, true)) {
    return error;
  }
  return traceProblem().empty() ? std::nullopt : std::optional(storageError(traceProblem()));
}

void HostedSimulation::closeEnvironments() {
  protocol::JsonWriter params;
  params.beginObject().key("simulation").text(record_.id).endObject();
  const protocol::Body body(params.take());
  for (const auto& link : links_) {
    if (link->generation() == 0) {
      continue;
    }
    // whatever it answers: it may not know the method
    const auto tell = [&] { (void)link->call("environment.close", body, std::chrono::seconds(1)); };
    services_.runWaiting ? services_.runWaiting(tell) : tell();
  }
}

void HostedSimulation::setCancelled(bool isCancelled) {
  const std::lock_guard lock(cancelMutex_);
  simulation_->setCancelled(isCancelled);
  if (isCancelled) {
    for (const auto& link : links_) {
      link->interrupt();
    }
  }
}

}  // namespace espalier::server
