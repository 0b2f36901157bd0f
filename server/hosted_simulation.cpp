#include "server/hosted_simulation.h"

#include <algorithm>
#include <chrono>

#include "engine/simulation/snapshot.h"
#include "server/translate.h"

namespace espalier::server {

HostedSimulation::HostedSimulation(SimulationRecord record, const core::Limits& limits,
                                   const EnvironmentServices& services, const DataFolder& data)
    : record_(std::move(record)), limits_(limits), services_(services), data_(&data) {
  if (record_.create.maximumModules) {
    limits_.maximumModules = std::min(limits_.maximumModules, *record_.create.maximumModules);
  }
  if (record_.create.maximumQueries) {
    limits_.maximumQueries = std::min(limits_.maximumQueries, *record_.create.maximumQueries);
  }
}

std::optional<protocol::Error> HostedSimulation::build(std::shared_ptr<const language::Program> program,
                                                       bool isAbsenceTolerated) {
  auto built = buildEnvironment(record_.create.environmentJson, program->compatibility, isAbsenceTolerated, services_);
  if (auto* error = std::get_if<protocol::Error>(&built)) {
    return std::move(*error);
  }
  auto& environment = std::get<BuiltEnvironment>(built);
  std::vector<turtle::PlantPlacement> placements;
  for (const protocol::PlantPosition& plant : record_.create.plants) {
    placements.push_back({{plant.position[0], plant.position[1], plant.position[2]}, {}});
  }
  if (placements.empty()) {
    placements.emplace_back();
  }
  simulation::SimulationOptions options;
  options.name = record_.id;
  options.seed = record_.seed;
  options.hasSeed = record_.hasSeed;
  options.derivationLength = record_.create.derivationLength;
  options.limits = limits_;
  options.environmentOrigin = std::move(environment.origin);
  auto made = std::make_unique<simulation::Simulation>(std::move(program), std::move(placements),
                                                       std::move(environment.process), std::move(options));
  const std::lock_guard lock(cancelMutex_);
  simulation_.swap(made);
  links_ = std::move(environment.links);
  environmentNames_ = std::move(environment.names);
  processNames_ = std::move(environment.processNames);
  return std::nullopt;
}

std::variant<std::unique_ptr<HostedSimulation>, protocol::Error> HostedSimulation::create(
    SimulationRecord record, std::shared_ptr<const language::Program> program, const core::Limits& limits,
    const EnvironmentServices& services, const DataFolder& data, Interruption& interruption) {
  std::unique_ptr<HostedSimulation> hosted(new HostedSimulation(std::move(record), limits, services, data));
  if (auto error = hosted->build(std::move(program), false)) {
    return std::move(*error);
  }
  {
    const Interruption::Scope scope(interruption, [&hosted] { hosted->setCancelled(true); });
    if (auto error = hosted->simulation_->rewind()) {
      return hosted->errorOf(*error);
    }
  }
  hosted->setCancelled(false);
  if (data.isKept() && hosted->record_.create.isSaved) {
    if (auto problem = data.saveRecord(hosted->record_)) {
      return protocol::Error{protocol::ErrorCode::Storage, *problem, {}};
    }
  }
  if (auto error = hosted->save()) {
    data.remove(hosted->record_.id);
    return std::move(*error);
  }
  return hosted;
}

std::variant<std::unique_ptr<HostedSimulation>, protocol::Error> HostedSimulation::load(
    SimulationRecord record, std::string_view snapshot, const core::Limits& limits, const EnvironmentServices& services,
    const DataFolder& data) {
  auto read = simulation::readSnapshotInfo(snapshot);
  if (const auto* error = std::get_if<core::SimulationError>(&read)) {
    return toError(*error, 0, limits);
  }
  auto& info = std::get<simulation::SnapshotInfo>(read);
  info.compileInput.limits = limits;
  auto compiled = language::compile(info.compileInput, info.files);
  if (compiled.program == nullptr) {
    return toError(compiled.diagnostics.entries());
  }
  std::unique_ptr<HostedSimulation> hosted(new HostedSimulation(std::move(record), limits, services, data));
  if (auto error = hosted->build(std::move(compiled.program), true)) {
    return std::move(*error);
  }
  if (auto error = hosted->simulation_->restore(snapshot)) {
    return hosted->errorOf(*error);
  }
  hosted->isSaved_ = true;
  return hosted;
}

protocol::Error HostedSimulation::errorOf(const core::SimulationError& error) const {
  return toError(error, simulation_->completedSteps(), limits_, environmentNames_);
}

std::optional<protocol::Error> HostedSimulation::save() {
  isSaved_ = false;
  if (!data_->isKept() || !record_.create.isSaved) {
    return std::nullopt;
  }
  if (auto problem = data_->saveSnapshot(record_.id, snapshot())) {
    return protocol::Error{protocol::ErrorCode::Storage, *problem, {}};
  }
  isSaved_ = true;
  return std::nullopt;
}

std::optional<protocol::Error> HostedSimulation::step(double& milliseconds) {
  const auto start = std::chrono::steady_clock::now();
  const auto error = simulation_->step();
  milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  if (error) {
    return errorOf(*error);
  }
  return save();
}

std::optional<protocol::Error> HostedSimulation::reset(std::optional<std::uint64_t> seed) {
  if (seed) {
    // a simulation has its seed for life: make another, which takes the place of the old one when it is ready
    SimulationRecord record = record_;
    record.seed = *seed;
    record.hasSeed = true;
    HostedSimulation fresh(std::move(record), limits_, services_, *data_);
    if (auto error = fresh.build(simulation_->sharedProgram(), false)) {
      return error;
    }
    if (const auto failure = fresh.simulation_->rewind()) {
      return errorOf(*failure);
    }
    record_ = fresh.record_;
    {
      const std::lock_guard lock(cancelMutex_);
      simulation_.swap(fresh.simulation_);
      links_.swap(fresh.links_);
    }
    if (data_->isKept() && record_.create.isSaved) {
      if (auto problem = data_->saveRecord(record_)) {
        return protocol::Error{protocol::ErrorCode::Storage, *problem, {}};
      }
    }
    return save();
  }
  if (const auto error = simulation_->rewind()) {
    return errorOf(*error);
  }
  return save();
}

std::string HostedSimulation::snapshot() const {
  core::StringSink sink;
  simulation_->save(sink);
  return sink.take();
}

std::optional<protocol::Error> HostedSimulation::restore(std::string_view snapshot) {
  if (const auto error = simulation_->restore(snapshot)) {
    return errorOf(*error);
  }
  return save();
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
