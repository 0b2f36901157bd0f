#include "server/server_core.h"

#include <algorithm>
#include <random>
#include <utility>

#include "engine/core/check.h"
#include "engine/core/hash.h"
#include "server/remote/freed_memory.h"
#include "server/session/session.h"
#include "server/store/database.h"

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

std::string listText(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) {
    text += (text.empty() ? "" : ", ") + part;
  }
  return text;
}

}  // namespace

std::uint64_t drawSeed() {
  std::random_device device;
  const std::uint64_t high = device();
  return ((high << 32U) | device()) >> 11U;
}

ServerCore::ServerCore(ServerOptions options)
    : options_(std::move(options)),
      log_(options_.logLevel, options_.logFormat),
      access_(options_.tokens),
      limits_(options_.limits),
      accounts_(options_.limits),
      store_(options_.dataFolder, options_.limits.storeBytes, options_.durability),
      models_(options_.galleryFolder, store_),
      savedModels_(options_.modelsFolder, options_.limits.savedModelBytes),
      pool_({.workers = options_.workers}) {
  boundHeaps(pool_.workers());
  for (WebFile& file : options_.pages) {
    core::Hasher hash;
    hash.bytes(file.content);
    file.tag = "W/\"" + std::to_string(hash.value()) + "\"";
  }
}

void ServerCore::countDatabase() {
  const std::lock_guard lock(databaseMutex_);
  databaseMemory_.set(Database::memoryBytes());
}

ServerCore::~ServerCore() {
  // workers destroy the simulations, so before the pool goes
  simulations_.clear();
}

TraceFolder ServerCore::tracesOf(Account& owner) const {
  return {options_.dataFolder.empty() ? std::string() : options_.dataFolder + "/traces", &owner.traceRoom()};
}

EnvironmentServices ServerCore::environmentServices(Account& owner) {
  EnvironmentServices services;
  services.offered = &offered_;
  services.permissions = &options_.remote;
  services.runWaiting = [this](const std::function<void()>& wait) {
    const auto start = std::chrono::steady_clock::now();
    pool_.blockWhile(wait);
    metrics.environmentSeconds.observe(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  };
  services.metrics = &metrics;
  services.traces = tracesOf(owner);
  services.galleryFolder = options_.galleryFolder;
  services.threads = options_.threads;
  services.connectTimeout = std::chrono::milliseconds(limits().environmentConnectMilliseconds);
  services.frames = {.lineBytes = limits().lineBytes, .blockBytes = limits().blockBytes};
  services.stepTimeout = std::chrono::milliseconds(limits().environmentStepMilliseconds);
  return services;
}

const std::string& ServerCore::builtInEnvironments(const std::function<std::string()>& describe) {
  std::call_once(areEnvironmentsDescribed_, [&] { builtInEnvironments_ = describe(); });
  return builtInEnvironments_;
}

void ServerCore::readAgain(ReadMore more, std::function<void()> whenChanged) {
  pool_.post({.run =
                  [this, more = std::move(more), whenChanged = std::move(whenChanged)] {
                    const std::lock_guard lock(readingMutex_);
                    if (const auto problem = readAllAgain(more, whenChanged)) {
                      log_.error("tokens, limits and certificate stay as they are: " + *problem);
                    }
                  },
              .owner = "reading again"});
}

std::optional<std::string> ServerCore::readAllAgain(const ReadMore& more, const std::function<void()>& whenChanged) {
  // everything that can fail before anything changes
  std::function<void()> putMore;
  if (more) {
    auto read = more();
    if (!read) {
      return std::move(read.error());
    }
    putMore = std::move(*read);
  }
  ServerOptions::ReadAgain fresh;
  if (options_.readAgain) {
    auto read = options_.readAgain();
    if (!read) {
      return std::move(read.error());
    }
    fresh = std::move(*read);
    if (fresh.tokens.empty() && access_.hasTokens()) {
      return "without any token the server would be open. Stop it instead.";
    }
    if (const auto problem = fresh.limits ? store_.setMaximumBytes(fresh.limits->storeBytes) : std::nullopt) {
      return "the limit storeBytes: " + *problem;
    }
    const std::size_t count = fresh.tokens.size();
    ESPALIER_CHECK(access_.replace(std::move(fresh.tokens)));
    log_.info("read the tokens again: " + std::to_string(count));
  }
  if (!fresh.restartKeys.empty()) {
    log_.warn("changed in the configuration, and read only when the server starts: " + listText(fresh.restartKeys));
  }
  if (fresh.limits && setLimits(*fresh.limits)) {
    whenChanged();
  }
  if (putMore) {
    putMore();
  }
  return std::nullopt;
}

bool ServerCore::setLimits(const ServerLimits& fresh) {
  std::vector<std::string> now;
  std::vector<std::string> later;
  for (const LimitEntry& entry : limitEntries()) {
    const std::uint64_t before = entry.get(limits());
    if (const std::uint64_t after = entry.get(fresh); after != before) {
      (entry.isOfSimulation ? later : now)
          .push_back(std::string(entry.name) + " " + std::to_string(before) + " -> " + std::to_string(after));
    }
  }
  if (now.empty() && later.empty()) {
    log_.info("read the limits again: none has changed");
    return false;
  }
  limits_.set(fresh);
  accounts_.setLimits(fresh);
  savedModels_.setMostBytes(fresh.savedModelBytes);
  if (!now.empty()) {
    log_.info("read the limits again: " + listText(now));
  }
  if (!later.empty()) {
    log_.info("read the limits again, for simulations that are made or loaded from now on: " + listText(later));
  }
  return true;
}

void ServerCore::countTraces(const std::vector<Store::Entry>& entries) {
  const std::string folder = tracesOf(accounts_.server()).path;
  // those of simulations that are no more count for the server only
  std::uint64_t others = SimulationTrace::bytesIn(folder);
  for (const Store::Entry& entry : entries) {
    const std::uint64_t bytes = SimulationTrace::bytesOf(folder, entry.id);
    accounts_.of(entry.owner).traceRoom().add(static_cast<std::int64_t>(bytes));
    others -= std::min(others, bytes);
  }
  accounts_.server().traceRoom().add(static_cast<std::int64_t>(others));
}

std::optional<std::string> ServerCore::loadSaved() {
  if (auto problem = store_.open()) {
    return problem;
  }
  models_.loadKept();
  const auto saved = store_.simulations();
  if (!saved) {
    return saved.error();
  }
  const auto& entries = *saved;
  countTraces(entries);
  for (const Store::Entry& entry : entries) {
    loadOne(entry);
  }
  if (!entries.empty()) {
    log_.info("loaded " + std::to_string(entries.size() - damaged_.size()) + " of " + std::to_string(entries.size()) +
              " simulations from " + options_.dataFolder);
  }
  return std::nullopt;
}

void ServerCore::loadOne(const Store::Entry& entry) {
  protocol::SimulationInformation information;
  information.simulation = entry.id;
  information.step = entry.step;
  information.isSaved = true;
  // a stored environment that the operator no longer permits is refused, also to the client that stored it
  protocol::ErrorCode code = protocol::ErrorCode::Storage;
  auto record = toRecord(entry.id, entry.record);
  if (record) {
    record->owner = entry.owner;
    information.name = record->create.name;
    information.seed = record->seed;
    const Store::State state = store_.readState(entry.id);
    information.damage = state.problem;
    if (state.problem.empty()) {
      Account& owner = accounts_.of(entry.owner);
      auto loaded = HostedSimulation::load(std::move(*record), state.bytes, limits().simulation,
                                           environmentServices(owner), store_);
      if (loaded) {
        add(entry.id, std::move(*loaded));
        keepRoom(owner);
        return;
      }
      const auto& error = loaded.error();
      information.damage = error.message;
      code = error.code == protocol::ErrorCode::Unauthorised ? error.code : code;
    }
  } else {
    information.damage = "The data folder's record of it cannot be read (" + record.error() + ").";
  }
  log_.warn("is not loaded: " + information.damage, {.simulation = entry.id});
  const std::lock_guard lock(mutex_);
  damaged_.emplace(entry.id, Damaged{std::move(information), code, entry.owner});
}

std::vector<protocol::SimulationInformation> ServerCore::damaged() const {
  const std::lock_guard lock(mutex_);
  std::vector<protocol::SimulationInformation> all;
  for (const auto& [name, damaged] : damaged_) {
    all.push_back(damaged.information);
  }
  return all;
}

std::optional<protocol::Error> ServerCore::findDamaged(const std::string& simulation) const {
  const std::lock_guard lock(mutex_);
  const auto found = damaged_.find(simulation);
  if (found == damaged_.end()) {
    return std::nullopt;
  }
  const auto& [information, code, owner] = found->second;
  return protocol::Error{
      code,
      "Simulation '" + simulation + "' could not be loaded: " + information.damage + " simulation.delete removes it.",
      {}};
}

std::optional<std::string> ServerCore::removeDamaged(const std::string& simulation) {
  if (auto problem = store_.remove(simulation)) {
    return problem;
  }
  const std::lock_guard lock(mutex_);
  if (const auto found = damaged_.find(simulation); found != damaged_.end()) {
    SimulationTrace::removeAll(tracesOf(accounts_.of(found->second.owner)), simulation);
    damaged_.erase(found);
  }
  return std::nullopt;
}

std::shared_ptr<SimulationRunner> ServerCore::find(const std::string& simulation) const {
  const std::lock_guard lock(mutex_);
  const auto found = simulations_.find(simulation);
  return found == simulations_.end() ? nullptr : found->second;
}

protocol::Expected<std::string> ServerCore::reserve(const std::string& session, const std::string& owner,
                                                    const std::string& wanted) {
  const Account& account = accounts_.of(owner);
  const std::lock_guard lock(mutex_);
  if (const std::uint64_t bound = limits().simulations; simulations_.size() >= bound) {
    return tl::unexpected(protocol::limitError("simulations", bound + 1, bound, "Delete one first."));
  }
  if (const std::uint64_t bound = account.bounds().simulations; account.simulations() >= bound) {
    return tl::unexpected(
        protocol::limitError("accountSimulations", bound + 1, bound, "Delete one of this account first."));
  }
  const auto own = std::count_if(creators_.begin(), creators_.end(),
                                 [&session](const auto& entry) { return entry.second == session; });
  if (const std::uint64_t bound = limits().simulationsPerSession; static_cast<std::uint64_t>(own) >= bound) {
    return tl::unexpected(
        protocol::limitError("simulationsPerSession", bound + 1, bound, "Delete one that this connection made first."));
  }
  if (simulations_.contains(wanted)) {
    return tl::unexpected(
        protocol::memberError("params.simulation", "another request makes this simulation now; ask again"));
  }
  std::string name = wanted.empty() ? randomName() : wanted;
  while (simulations_.contains(name)) {
    name = randomName();
  }
  simulations_.emplace(name, nullptr);
  creators_.emplace(name, session);
  return name;
}

void ServerCore::add(const std::string& simulation, std::unique_ptr<HostedSimulation> hosted) {
  // the thread that drops it last may be the network's, and a spawned environment takes long to end
  const auto destroyOnWorker = [this](SimulationRunner* done) {
    pool_.post({.run = [this, done] { pool_.blockWhile([done] { delete done; }); }, .owner = "closing"});
  };
  RunnerServices services{.pool = &pool_,
                          .log = &log_,
                          .limits = &limits_,
                          .account = &accounts_.of(hosted->record().owner),
                          .load = [this](const std::string& id) { return loadAgain(id); },
                          .makeRoom = [this](const SimulationRunner& needy) { return makeRoom(needy.account()); }};
  std::shared_ptr<SimulationRunner> runner(new SimulationRunner(std::move(hosted), std::move(services)),
                                           destroyOnWorker);
  const std::lock_guard lock(mutex_);
  simulations_.insert_or_assign(simulation, std::move(runner));
}

protocol::Expected<std::unique_ptr<HostedSimulation>> ServerCore::loadAgain(const std::string& simulation) {
  const auto entry = store_.simulation(simulation);
  if (!entry) {
    return tl::unexpected(protocol::Error{protocol::ErrorCode::Storage, entry.error(), {}});
  }
  auto record = toRecord(entry->id, entry->record);
  if (!record) {
    return tl::unexpected(protocol::Error{
        protocol::ErrorCode::Storage, "The data folder's record of it cannot be read (" + record.error() + ").", {}});
  }
  auto& known = *record;
  known.owner = entry->owner;
  const Store::State state = store_.readState(simulation);
  if (!state.problem.empty()) {
    return tl::unexpected(protocol::Error{protocol::ErrorCode::Storage, state.problem + ".", {}});
  }
  return HostedSimulation::load(std::move(known), state.bytes, limits().simulation,
                                environmentServices(accounts_.of(entry->owner)), store_);
}

bool ServerCore::makePassive(const Account* account, const std::function<bool()>& isWanted) {
  if (!isWanted()) {
    return false;
  }
  // the times as they are now: others change them meanwhile
  std::vector<std::pair<std::chrono::steady_clock::time_point, std::shared_ptr<SimulationRunner>>> candidates;
  for (auto& runner : all()) {
    if (!runner->isPassive() && (account == nullptr || &runner->account() == account)) {
      const auto used = runner->lastUse();
      candidates.emplace_back(used, std::move(runner));
    }
  }
  std::sort(candidates.begin(), candidates.end());
  bool isMade = false;
  for (const auto& [used, runner] : candidates) {
    if (runner->makePassive()) {
      isMade = true;
      log_.debug("is kept on disk only, to make room in memory", {.simulation = runner->id()});
      if (!isWanted()) {
        break;
      }
    }
  }
  return isMade;
}

void ServerCore::keepRoom(const Account& account) {
  const auto isTight = [](const Account& one) { return one.memoryBytes() > one.bounds().memoryBytes / 4 * 3; };
  // the owner's own first: another owner's simulations rest only for the sake of the whole server
  makePassive(&account, [&] { return isTight(account); });
  makePassive(nullptr, [&] { return isTight(accounts_.server()); });
}

bool ServerCore::makeRoom(const Account& account) {
  const auto isHalfFull = [](const Account& one) { return one.memoryBytes() > one.bounds().memoryBytes / 2; };
  bool isFirst = true;
  const bool isOwn = makePassive(&account, [&] { return std::exchange(isFirst, false) || isHalfFull(account); });
  return makePassive(nullptr, [&] { return isHalfFull(accounts_.server()); }) || isOwn;
}

void ServerCore::remove(const std::string& simulation) {
  const std::lock_guard lock(mutex_);
  const auto found = simulations_.find(simulation);
  if (found != simulations_.end()) {
    if (found->second != nullptr) {
      found->second->leaveAccount();
    }
    simulations_.erase(found);
  }
  creators_.erase(simulation);
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

void ServerCore::enter(const Session& session) {
  const std::lock_guard lock(sessionMutex_);
  sessions_.insert(&session);
}

void ServerCore::leave(const Session& session) {
  const std::lock_guard lock(sessionMutex_);
  sessions_.erase(&session);
}

std::uint64_t ServerCore::outboxBytes() const {
  const std::lock_guard lock(sessionMutex_);
  std::uint64_t sum = 0;
  for (const Session* session : sessions_) {
    sum += session->outboxBytes();
  }
  return sum;
}

void ServerCore::beginShutdown() {
  isShuttingDown_ = true;
  for (const auto& runner : all()) {
    runner->close(kShuttingDown, false);
  }
}

void ServerCore::waitForWorkers() {
  while (!pool_.waitUntilIdle(std::chrono::hours(1))) {
  }
}

bool ServerCore::finishRunning(std::chrono::milliseconds patience) {
  bool isIdle = pool_.waitUntilIdle(patience);
  if (!isIdle) {
    for (const auto& runner : all()) {
      runner->close(kShuttingDown, true);
    }
    isIdle = pool_.waitUntilIdle(patience);
  }
  for (const auto& runner : all()) {
    runner->endStreams("the server is shutting down");
    if (const auto problem = runner->saveAtEnd()) {
      log_.error(*problem, {.simulation = runner->id()});
    }
  }
  return isIdle;
}

}  // namespace espalier::server
