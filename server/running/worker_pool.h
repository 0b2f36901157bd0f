#pragma once

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace espalier::server {

/// Kinds of work with workers of their own: short requests never wait behind steps, nor messages behind either, nor
/// anything behind frames.
enum class Lane : std::uint8_t {
  Short,   // compiling, creating, reading, saving
  Step,    // steps of simulations
  Decode,  // big messages
  Frame,   // frames for viewers
};

struct WorkerPoolOptions {
  unsigned workers = 0;  // tasks of a lane that compute at a time; 0: processorCount(). Short has at least two
  /// A task that computes longer goes on, and another task begins beside it.
  std::chrono::milliseconds overtime{250};
};

/// Threads that compute. In each lane `workers` tasks compute at a time. Owners take turns, so an owner with many tasks
/// does not make others wait. A task cannot be interrupted: when it computes longer than `overtime`, it is no longer
/// counted and another task begins. So an endless step keeps a core busy, but never the server. One owner has at most
/// `workers` computing tasks in a lane; all owners together have at most kMaximumOvertime more than that. A task that
/// waits for an environment in another process says so (blockWhile), and another task takes its place.
class WorkerPool {
 public:
  struct Task {
    std::function<void()> run{};  // must not throw
    Lane lane = Lane::Short;
    std::string owner{};  // the session whose share it takes; empty: the server's own
    /// After so much computing time (blockWhile not counted) another thread calls onLimit, once. The task may have just
    /// ended then. 0: never.
    std::chrono::milliseconds limit{0};
    std::function<void()> onLimit{};
  };

  explicit WorkerPool(const WorkerPoolOptions& options);
  /// Waits until all tasks have run.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Thread-safe.
  void post(Task task);
  /// The same for the last act of a task: its thread is free in a moment, so no other is woken.
  void postAtEnd(Task task);

  /// Runs `wait`, which blocks, on the calling thread; another task computes meanwhile. In a task only.
  void blockWhile(const std::function<void()>& wait);

  /// Waits until no task waits or runs. False: the time was over first.
  [[nodiscard]] bool waitUntilIdle(std::chrono::milliseconds time);

  [[nodiscard]] unsigned workers() const { return workers_; }

 private:
  using Clock = std::chrono::steady_clock;

  /// A task that runs on a thread.
  struct Running {
    Task task;
    Clock::time_point start;  // moved forward by the time spent in blockWhile
    bool isBlocked = false;   // in blockWhile
    bool isOvertime = false;
    bool isLimitReached = false;
  };
  struct Owner {
    std::deque<Task> tasks;
    std::size_t computing = 0;     // running and not blocked
    std::size_t blocked = 0;       // in blockWhile
    std::uint64_t lastServed = 0;  // when a task was last begun, in numbers of begun tasks
  };
  struct LaneState {
    unsigned workers = 1;
    std::map<std::string, Owner> owners;  // those with tasks or running ones
    std::size_t waiting = 0;              // tasks without a thread
    std::size_t counted = 0;              // computing and not in overtime
    std::size_t computing = 0;            // running and not blocked
  };

  void work();
  /// Runs a task on this thread, without the lock, and destroys it without the lock: a destructor may post.
  void carryOut(Task task, std::unique_lock<std::mutex>& lock);
  void keepTime();
  // with mutex_ held
  void enqueue(Task task);
  [[nodiscard]] Owner* nextOwner(LaneState& lane);
  [[nodiscard]] LaneState* readyLane();
  void startThreadIfNeeded();
  [[nodiscard]] LaneState& laneOf(const Task& task) { return lanes_[static_cast<std::size_t>(task.lane)]; }
  void begin(Running& running);
  void end(Running& running);
  [[nodiscard]] bool isIdle() const;
  /// Marks tasks in overtime; true: there are new ones. Fills `reached` with the onLimit of tasks beyond their limit.
  [[nodiscard]] bool look(Clock::time_point now, std::vector<std::function<void()>>& reached);

  static constexpr std::size_t kMaximumThreads = 1024;
  static constexpr std::size_t kMaximumOvertime = 64;          // of each lane
  static constexpr std::size_t kMaximumBlockedPerOwner = 256;  // of each lane
  static thread_local Running* current_;                       // of this thread; null: none

  const unsigned workers_;
  const std::chrono::milliseconds overtime_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable idle_;
  std::condition_variable time_;
  std::array<LaneState, 4> lanes_;
  std::list<Running> running_;
  std::uint64_t begunCount_ = 0;
  std::size_t freeThreads_ = 0;   // threads that look for a task
  bool isKeeperResting_ = false;  // nothing runs: it sleeps until a task begins
  bool isStopping_ = false;
  std::vector<std::thread> threads_;
  std::thread keeper_;
};

}  // namespace espalier::server
