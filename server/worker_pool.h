#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace espalier::server {

/// Threads that compute: compiling, stepping, saving. `workers` of them compute at a time. One that waits for a remote
/// environment says so (blockWhile) and another takes its place, so that a slow environment starves nobody.
class WorkerPool {
 public:
  using Task = std::function<void()>;

  explicit WorkerPool(unsigned workers);
  /// Waits for everything posted.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// Thread-safe. Tasks must not throw.
  void post(Task task);

  /// Runs `wait`, which blocks, on the calling thread while another computes in its place.
  void blockWhile(const std::function<void()>& wait);

  /// Waits until nothing is posted or running; false when the time is over before.
  [[nodiscard]] bool waitUntilIdle(std::chrono::milliseconds time);

  [[nodiscard]] unsigned workers() const { return workers_; }

 private:
  void work();
  // with mutex_ held
  void startThreadIfNeeded();
  [[nodiscard]] std::size_t computing() const;

  static constexpr std::size_t kMaximumThreads = 1024;

  const unsigned workers_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable idle_;
  std::deque<Task> tasks_;
  std::size_t running_ = 0;  // tasks being run, blocked ones included
  std::size_t blocked_ = 0;  // of them, inside blockWhile
  std::size_t waiting_ = 0;  // threads without a task
  bool isStopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace espalier::server
