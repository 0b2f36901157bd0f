#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "protocol/errors.h"
#include "protocol/messages.h"
#include "server/running/hosted_simulation.h"
#include "server/running/worker_pool.h"
#include "server/stream/viewers.h"

namespace espalier::server {

class Log;
struct ServerLimits;
class SimulationRunner;

/// A piece of work on a simulation. `advance` runs on a worker and returns whether it wants another turn: a long
/// command makes one step a turn, so that other commands get in between. When the simulation goes away, `fail` is
/// called instead.
struct Command {
  std::function<bool(SimulationRunner&, Command&)> advance;
  std::function<void(const protocol::Error&)> fail;
  Lane lane = Lane::Short;  // of its turns
  std::string owner;        // the session whose share of the workers they take
  std::atomic<bool> isCancelled{false};
  bool isPaused = false;                 // it ends between two steps; for the worker that owns the simulation
  std::atomic<bool> isAnswered{false};   // the caller has the answer; the last turn may not be over
  std::atomic<bool> isOverLimit{false};  // this turn took longer than a call may
};

/// Gives a simulation its turns on the pool. One worker owns it at a time. Commands run in the order in which they
/// came. Other threads see the published information.
class SimulationRunner final : public std::enable_shared_from_this<SimulationRunner> {
 public:
  /// A turn that computes longer than the limit callSeconds is given up.
  SimulationRunner(std::unique_ptr<HostedSimulation> hosted, WorkerPool& pool, const Log& log,
                   const ServerLimits& limits);

  // thread-safe
  void submit(std::shared_ptr<Command> command);
  /// Gives a command up: at once when it runs, else when its turn comes.
  void cancel(const std::shared_ptr<Command>& command);
  /// Fails all commands that wait and all that come later. The running turn ends, or is given up (`isInterrupting`).
  void close(const protocol::Error& reason, bool isInterrupting);
  /// The same, giving up the running turn; then runs one last command.
  void closeWith(std::shared_ptr<Command> last, const protocol::Error& reason);
  [[nodiscard]] protocol::SimulationInformation information() const;
  [[nodiscard]] const std::string& id() const { return id_; }
  /// Bytes that its streams keep to find differences.
  [[nodiscard]] std::uint64_t streamBytes() const;
  /// Bytes of its strings after its last turn.
  [[nodiscard]] std::uint64_t stringBytes() const { return stringBytes_; }
  /// Shows the present state to streams that missed one and are ready again.
  void catchUp();
  /// Ends all streams with a reason.
  void endStreams(const std::string& reason);
  [[nodiscard]] bool isClosing() const;
  /// Saves the state if its policy has not saved it, unless a turn still runs. An error sentence, or nothing.
  [[nodiscard]] std::optional<std::string> saveAtEnd();

  // inside Command::advance only
  [[nodiscard]] HostedSimulation& hosted() { return *hosted_; }
  [[nodiscard]] std::uint32_t callSeconds() const { return callSeconds_; }
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

  const std::string id_;
  std::unique_ptr<HostedSimulation> hosted_;
  WorkerPool* pool_;
  const Log* log_;
  const std::uint32_t callSeconds_;
  const std::uint64_t streamBytesBound_;
  double milliseconds_ = 0.0;  // of the last step; for the worker that owns the simulation
  std::string lastError_;      // the same
  std::atomic<std::uint64_t> stringBytes_{0};

  mutable std::mutex mutex_;
  std::deque<std::shared_ptr<Command>> queue_;
  std::shared_ptr<Command> current_;
  bool isScheduled_ = false;
  std::uint64_t turnCount_ = 0;  // turns begun
  std::optional<protocol::Error> closed_;
  protocol::SimulationInformation information_;
  std::shared_ptr<Viewers> viewers_;  // null: there never was one
  bool isCatchingUp_ = false;         // such a command is queued
};

}  // namespace espalier::server
