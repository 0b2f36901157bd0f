#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "protocol/errors.h"
#include "server/access/access.h"
#include "server/log.h"
#include "server/metrics.h"
#include "server/remote/offered_environments.h"
#include "server/running/account.h"
#include "server/running/environment_builder.h"
#include "server/running/live_limits.h"
#include "server/running/simulation_runner.h"
#include "server/running/worker_pool.h"
#include "server/server.h"
#include "server/store/model_store.h"
#include "server/store/saved_models.h"
#include "server/store/store.h"

namespace espalier::server {

class Session;

/// The part of the server that all sessions share: simulations, models, offered environments, workers. Knows no
/// network. Thread-safe.
class ServerCore {
 public:
  explicit ServerCore(ServerOptions options);
  ~ServerCore();
  ServerCore(const ServerCore&) = delete;
  ServerCore& operator=(const ServerCore&) = delete;

  /// As the server was started. Of the limits, limits() has the present ones.
  [[nodiscard]] const ServerOptions& options() const { return options_; }
  [[nodiscard]] const ServerLimits& limits() const { return limits_.get(); }
  [[nodiscard]] const Log& log() const { return log_; }
  [[nodiscard]] Access& access() { return access_; }
  [[nodiscard]] const Access& access() const { return access_; }
  [[nodiscard]] WorkerPool& pool() { return pool_; }
  [[nodiscard]] const WorkerPool& pool() const { return pool_; }
  [[nodiscard]] ModelStore& models() { return models_; }
  [[nodiscard]] SavedModels& savedModels() { return savedModels_; }
  [[nodiscard]] OfferedEnvironments& offered() { return offered_; }
  [[nodiscard]] Accounts& accounts() { return accounts_; }
  [[nodiscard]] const Accounts& accounts() const { return accounts_; }
  [[nodiscard]] Store& store() { return store_; }
  [[nodiscard]] const Store& store() const { return store_; }
  /// Where the traces of an owner are.
  [[nodiscard]] TraceFolder tracesOf(Account& owner) const;
  /// For simulations of that owner.
  [[nodiscard]] EnvironmentServices environmentServices(Account& owner);
  /// Brings the memory of SQLite in the account of the server up to date. Nothing waits in it.
  void countDatabase();

  /// The text of `describe` for the environments of this program. It is asked once: to make them takes milliseconds.
  [[nodiscard]] const std::string& builtInEnvironments(const std::function<std::string()>& describe);

  /// Reads something more. The returned function puts that in place.
  using ReadMore = std::function<tl::expected<std::function<void()>, std::string>()>;
  /// Has a worker read tokens, limits and `more` (null: nothing) again. The log says what has changed. After a mistake
  /// in any of them nothing has. `whenChanged` is called on the worker after the limits have changed.
  void readAgain(ReadMore more, std::function<void()> whenChanged);

  /// Loads what the data folder has. An error sentence when the folder cannot be used.
  [[nodiscard]] std::optional<std::string> loadSaved();

  [[nodiscard]] std::shared_ptr<SimulationRunner> find(const std::string& simulation) const;
  /// The simulations in the data folder that could not be loaded, with the reason. They stay there until removed.
  [[nodiscard]] std::vector<protocol::SimulationInformation> damaged() const;
  /// The error that answers every request for it, but simulation.delete.
  [[nodiscard]] std::optional<protocol::Error> findDamaged(const std::string& simulation) const;
  [[nodiscard]] std::optional<std::string> removeDamaged(const std::string& simulation);
  /// Reserves an identifier for add(): `wanted`, or a new one when that is empty. It counts for the session until it is
  /// removed. An error when it is taken, or when the session, its account, or the server has as many simulations as it
  /// may have.
  [[nodiscard]] protocol::Expected<std::string> reserve(const std::string& session, const std::string& owner,
                                                        const std::string& wanted = {});
  void add(const std::string& simulation, std::unique_ptr<HostedSimulation> hosted);
  /// Forgets an identifier, and the simulation when there is one. It is not closed.
  void remove(const std::string& simulation);
  [[nodiscard]] std::vector<std::shared_ptr<SimulationRunner>> all() const;
  /// Makes idle, saved simulations passive, the one that was used least recently first, while the account or the server
  /// has more than three quarters of its memory.
  void keepRoom(const Account& account);
  /// The same, at least one and down to half of it, after the account was refused memory. False: none can be passive.
  [[nodiscard]] bool makeRoom(const Account& account);

  /// From now on no request begins anything new.
  void beginShutdown();
  [[nodiscard]] bool isShuttingDown() const { return isShuttingDown_; }
  /// Waits for running turns and gives up those that still run after `patience`. Then saves each unsaved simulation.
  /// False: something still computes, and does not ask whether it is given up.
  [[nodiscard]] bool finishRunning(std::chrono::milliseconds patience);
  /// Waits for everything that runs on the pool, however long it takes.
  void waitForWorkers();

  std::atomic<std::uint32_t> sessionCount{0};   // of peers that have said hello
  std::atomic<std::uint64_t> decodingBytes{0};  // of messages that have come and are not decoded yet
  Metrics metrics;
  /// Sessions say when they begin and end.
  void enter(const Session& session);
  void leave(const Session& session);
  /// Bytes that wait for peers to read them.
  [[nodiscard]] std::uint64_t outboxBytes() const;
  [[nodiscard]] std::chrono::steady_clock::time_point started() const { return started_; }

 private:
  /// An error sentence, and nothing has changed; or nothing.
  [[nodiscard]] std::optional<std::string> readAllAgain(const ReadMore& more, const std::function<void()>& whenChanged);
  /// Other limits from now on. False: they are the same.
  bool setLimits(const ServerLimits& fresh);
  /// Counts the traces that are in the data folder for the owners of their simulations.
  void countTraces(const std::vector<Store::Entry>& entries);
  void loadOne(const Store::Entry& entry);
  [[nodiscard]] protocol::Expected<std::unique_ptr<HostedSimulation>> loadAgain(const std::string& simulation);
  /// Makes simulations passive, of the account or, when it is null, of any: the one that was used least recently first,
  /// as long as `isWanted`. False: none could be.
  bool makePassive(const Account* account, const std::function<bool()>& isWanted);

  ServerOptions options_;
  Log log_;
  Access access_;
  LiveLimits limits_;
  std::mutex readingMutex_;  // one SIGHUP at a time
  Accounts accounts_;
  std::mutex databaseMutex_;
  Holding databaseMemory_{accounts_.server(), MemoryKind::Database};
  OfferedEnvironments offered_;
  Store store_;
  ModelStore models_;
  SavedModels savedModels_;
  const std::chrono::steady_clock::time_point started_ = std::chrono::steady_clock::now();
  mutable std::mutex sessionMutex_;
  std::set<const Session*> sessions_;
  mutable std::mutex mutex_;
  std::map<std::string, std::shared_ptr<SimulationRunner>> simulations_;  // null: reserved
  std::map<std::string, std::string> creators_;  // of simulations: the session; those from disk have none
  struct Damaged {
    protocol::SimulationInformation information;
    protocol::ErrorCode code = protocol::ErrorCode::Storage;
    std::string owner{};
  };
  std::map<std::string, Damaged> damaged_;
  std::once_flag areEnvironmentsDescribed_;
  std::string builtInEnvironments_;
  std::atomic<bool> isShuttingDown_{false};
  WorkerPool pool_;  // last: its threads use everything above
};

/// A random number for seeds, at most 2^53 so that every client can hold it.
[[nodiscard]] std::uint64_t drawSeed();

}  // namespace espalier::server
