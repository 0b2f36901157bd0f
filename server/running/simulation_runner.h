#pragma once

#include <atomic>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "protocol/errors.h"
#include "protocol/messages.h"
#include "server/running/account.h"
#include "server/running/hosted_simulation.h"
#include "server/running/live_limits.h"
#include "server/running/worker_pool.h"
#include "server/stream/viewers.h"

namespace espalier::server {

class Log;
class SimulationRunner;
class TurnMeter;

/// A piece of work on a simulation. `advance` runs on a worker and returns whether it wants another turn: a long
/// command makes one step a turn, so that other commands get in between. When the simulation goes away, `fail` is
/// called instead.
struct Command {
  std::function<bool(SimulationRunner&, Command&)> advance;
  std::function<void(const protocol::Error&)> fail;
  Lane lane = Lane::Short;      // of its turns
  bool needsSimulation = true;  // false: a passive simulation is not read again for it
  std::string owner;            // the session whose share of the workers they take
  std::atomic<bool> isCancelled{false};
  bool isPaused = false;                 // it ends between two steps; for the worker that owns the simulation
  std::atomic<bool> isAnswered{false};   // the caller has the answer; the last turn may not be over
  std::atomic<bool> isOverLimit{false};  // this turn took longer than a call may
};

/// The server as a runner sees it.
struct RunnerServices {
  WorkerPool* pool = nullptr;
  const Log* log = nullptr;
  const LiveLimits* limits = nullptr;
  Account* account = nullptr;  // that the simulation counts for
  /// Reads a passive simulation from the data folder again.
  std::function<protocol::Expected<std::unique_ptr<HostedSimulation>>(const std::string& id)> load;
  /// Makes other simulations passive, so that the account gets memory. False: none can be.
  std::function<bool(const SimulationRunner& needy)> makeRoom;
};

/// Gives a simulation its turns on the pool. One worker owns it at a time. Commands run in the order in which they
/// came. Other threads see the published information.
///
/// A simulation that is saved and idle can be passive: it is on disk only. The next command reads it again.
class SimulationRunner final : public std::enable_shared_from_this<SimulationRunner> {
 public:
  /// A turn that computes longer than the limit callSeconds is given up.
  SimulationRunner(std::unique_ptr<HostedSimulation> hosted, RunnerServices services);
  ~SimulationRunner();

  // thread-safe
  void submit(std::shared_ptr<Command> command);
  /// Gives a command up: at once when it runs, else when its turn comes.
  void cancel(const std::shared_ptr<Command>& command);
  /// Fails all commands that wait and all that come later. The running turn ends, or is given up (`isInterrupting`).
  void close(const protocol::Error& reason, bool isInterrupting);
  /// The same, giving up the running turn; then runs one last command.
  void closeWith(std::shared_ptr<Command> last, const protocol::Error& reason);
  /// Why commands are refused, or nothing.
  [[nodiscard]] std::optional<protocol::Error> closed() const;
  /// Takes commands again, or refuses them for this reason: the last command of closeWith() could not do its work.
  void reopen(const std::optional<protocol::Error>& reason);
  [[nodiscard]] protocol::SimulationInformation information() const;
  /// How often it has applied its productions, after the last turn.
  struct Productions {
    simulation::Programs programs;
    std::shared_ptr<const simulation::ProductionUses> uses;  // null: it does not count
  };
  [[nodiscard]] Productions productions() const;
  /// A step of it runs or waits.
  [[nodiscard]] bool isRunning() const;
  [[nodiscard]] const std::string& id() const { return id_; }
  /// Bytes that its streams keep to find differences.
  [[nodiscard]] std::uint64_t streamBytes() const;
  /// Makes it passive when it can be. True: it is now, and was not before.
  [[nodiscard]] bool makePassive();
  [[nodiscard]] bool isPassive() const { return isPassive_; }
  /// When its last turn ended.
  [[nodiscard]] std::chrono::steady_clock::time_point lastUse() const { return lastUse_; }
  [[nodiscard]] Account& account() const { return *services_.account; }
  /// It is no simulation of the account any more. Its memory still counts until a worker has destroyed it.
  void leaveAccount();
  /// Shows the present state to streams that missed one and are ready again.
  void catchUp();
  /// Ends all streams with a reason.
  void endStreams(const std::string& reason);
  [[nodiscard]] bool isClosing() const { return closed().has_value(); }
  /// Saves the state if its policy has not saved it, unless a turn still runs. An error sentence, or nothing.
  [[nodiscard]] std::optional<std::string> saveAtEnd();

  // inside Command::advance only
  [[nodiscard]] HostedSimulation& hosted() { return *hosted_; }
  /// It is on disk only: hosted() is not there, in a command that does not need it.
  [[nodiscard]] bool isOnDiskOnly() const { return hosted_ == nullptr; }
  /// Another simulation takes the place of this one. The streams go on with it.
  void replace(std::unique_ptr<HostedSimulation> other);
  [[nodiscard]] std::uint32_t callSeconds() const { return services_.limits->get().callSeconds; }
  /// After a failure in this turn: the error of the account when the turn was refused memory, else `error`.
  [[nodiscard]] protocol::Error reasonOf(protocol::Error error) const;
  /// After a failure in this turn: true when it was refused memory, and there is room now. It can be tried again.
  [[nodiscard]] bool hasRoomNow();
  /// Publishes the information as it is after this command. To be called before the answer is sent: a caller that has
  /// received an answer never sees an older state.
  void publishEndOf(Command& command);
  /// Hands the present state over to the viewers. `isDue`: a step was just completed.
  void publishState(bool isDue);
  /// A new viewer, which gets the present state at once.
  void addStream(std::shared_ptr<Stream> stream);
  /// Marks every command that waits for a turn as paused. Returns how many steps or runs there are.
  std::size_t pauseWaiting();
  void setMilliseconds(double milliseconds) { milliseconds_ = milliseconds; }
  [[nodiscard]] double milliseconds() const { return milliseconds_; }
  void setLastError(std::string error) { lastError_ = std::move(error); }

 private:
  void publishInformation();
  void schedule(bool isAtEndOfTurn);  // with mutex_ held
  void takeTurn();
  void giveUpTurn(std::uint64_t turn);
  void runGuarded(Command& command, bool& wantsMore);
  /// `first`: only for this viewer; null: for all.
  void handOver(bool isDue, std::shared_ptr<Stream> first);
  [[nodiscard]] Viewers& viewers();
  void advance(Command& command, bool& wantsMore);
  /// Reads a passive simulation again. An error when it cannot be read.
  [[nodiscard]] std::optional<protocol::Error> activate();
  void interrupt();                     // with mutex_ held: gives up what the turn computes
  [[nodiscard]] bool hasSteps() const;  // with mutex_ held: steps run or wait

  const std::string id_;
  const RunnerServices services_;
  std::unique_ptr<HostedSimulation> hosted_;  // null: passive. Changes with mutex_ held
  double milliseconds_ = 0.0;                 // of the last step; for the worker that owns the simulation
  std::string lastError_;                     // the same
  Holding strings_;                           // the same, as the next one
  Holding environments_;
  Holding models_;
  std::atomic<bool> isPassive_{false};
  std::atomic<bool> isCounted_{true};  // among the simulations of the account
  std::atomic<std::chrono::steady_clock::time_point> lastUse_{std::chrono::steady_clock::now()};

  mutable std::mutex mutex_;
  TurnMeter* meter_ = nullptr;  // of the turn that runs
  std::deque<std::shared_ptr<Command>> queue_;
  std::shared_ptr<Command> current_;
  bool isScheduled_ = false;
  std::uint64_t turnCount_ = 0;  // turns begun
  std::optional<protocol::Error> closed_;
  protocol::SimulationInformation information_;
  Productions productions_;
  std::shared_ptr<Viewers> viewers_;  // null: there never was one
  bool isCatchingUp_ = false;         // such a command is queued
};

}  // namespace espalier::server
