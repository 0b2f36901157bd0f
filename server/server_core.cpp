#include "server/server_core.h"

#include <random>

namespace espalier::server {
namespace {

const protocol::Error kShuttingDown{
    protocol::ErrorCode::ShuttingDown,
    "The server is shutting down. Ask again when it is back; the simulation stays at its "
    "last completed step.",
    {}};

std::string randomName() {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::random_device device;
  std::string name = "sim-";
  for (int i = 0; i < 12; ++i) {
    name += kDigits[device() & 15U];
  }
  return name;
}

}  // namespace

std::uint64_t drawSeed() {
  std::random_device device;
  const std::uint64_t high = device();
  return ((high << 32U) | device()) >> 11U;
}

ServerCore::ServerCore(ServerOptions options)
    : options_(std::move(options)),
      log_(options_.logLevel),
      data_(options_.dataFolder),
      models_(options_.galleryFolder),
      pool_({.workers = options_.workers}) {}

EnvironmentServices ServerCore::environmentServices() {
  EnvironmentServices services;
  services.offered = &offered_;
  services.runWaiting = [this](const std::function<void()>& wait) { pool_.blockWhile(wait); };
  services.galleryFolder = options_.galleryFolder;
  services.stepTimeout = std::chrono::milliseconds(options_.limits.environmentStepMilliseconds);
  return services;
}

std::optional<std::string> ServerCore::loadSaved() {
  if (auto problem = data_.prepare()) {
    return problem;
  }
  std::vector<std::string> problems;
  auto saved = data_.loadAll(problems);
  for (auto& [record, snapshot] : saved) {
    const std::string id = record.id;
    const EnvironmentServices services = environmentServices();
    auto loaded = HostedSimulation::load(std::move(record), snapshot, options_.limits.simulation, services, data_);
    if (const auto* error = std::get_if<protocol::Error>(&loaded)) {
      problems.push_back("simulation '" + id + "' is not loaded: " + error->message);
      continue;
    }
    add(id, std::move(std::get<std::unique_ptr<HostedSimulation>>(loaded)));
  }
  for (const std::string& problem : problems) {
    log_.warn(problem);
  }
  if (!saved.empty()) {
    log_.info("loaded " + std::to_string(all().size()) + " simulations from " + options_.dataFolder);
  }
  return std::nullopt;
}

std::shared_ptr<SimulationRunner> ServerCore::find(const std::string& simulation) const {
  const std::lock_guard lock(mutex_);
  const auto found = simulations_.find(simulation);
  return found == simulations_.end() ? nullptr : found->second;
}

std::optional<std::string> ServerCore::reserve() {
  const std::lock_guard lock(mutex_);
  if (simulations_.size() >= options_.limits.simulations) {
    return std::nullopt;
  }
  std::string name = randomName();
  while (simulations_.contains(name)) {
    name = randomName();
  }
  simulations_.emplace(name, nullptr);
  return name;
}

void ServerCore::add(const std::string& simulation, std::unique_ptr<HostedSimulation> hosted) {
  auto runner = std::make_shared<SimulationRunner>(std::move(hosted), pool_, log_, options_.limits.callSeconds);
  const std::lock_guard lock(mutex_);
  simulations_.insert_or_assign(simulation, std::move(runner));
}

void ServerCore::remove(const std::string& simulation) {
  const std::lock_guard lock(mutex_);
  simulations_.erase(simulation);
}

std::vector<std::shared_ptr<SimulationRunner>> ServerCore::all() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<SimulationRunner>> runners;
  for (const auto& [name, runner] : simulations_) {
    if (runner != nullptr) {
      runners.push_back(runner);
    }
  }
  return runners;
}

void ServerCore::beginShutdown() {
  isShuttingDown_ = true;
  for (const auto& runner : all()) {
    runner->close(kShuttingDown, false);
  }
}

void ServerCore::finishRunning(std::chrono::milliseconds patience) {
  if (!pool_.waitUntilIdle(patience)) {
    for (const auto& runner : all()) {
      runner->close(kShuttingDown, true);
    }
    (void)pool_.waitUntilIdle(patience);
  }
  for (const auto& runner : all()) {
    runner->endStreams("the server is shutting down");
  }
}

}  // namespace espalier::server
