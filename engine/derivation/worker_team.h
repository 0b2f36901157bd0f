#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace espalier::derivation {

/// Threads that wait until they are given something to do together. The calling thread is one of them, so a team of one
/// starts no thread. One caller at a time.
class WorkerTeam {
 public:
  /// `size` at least 1.
  explicit WorkerTeam(unsigned size);
  ~WorkerTeam();
  WorkerTeam(const WorkerTeam&) = delete;
  WorkerTeam& operator=(const WorkerTeam&) = delete;

  /// Calls task(0) here and task(1), task(2), ... on the other threads at the same time, and returns when all are done.
  /// The first exception, by worker number, is thrown again here.
  void run(const std::function<void(unsigned)>& task);
  [[nodiscard]] unsigned size() const { return static_cast<unsigned>(failures_.size()); }

 private:
  void work(unsigned worker);
  void runTask(unsigned worker) noexcept;

  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable done_;
  const std::function<void(unsigned)>* task_ = nullptr;  // of the caller, while run is on
  std::uint64_t round_ = 0;                              // calls of run so far
  unsigned busy_ = 0;                                    // threads that have not finished this round
  bool isStopping_ = false;
  std::vector<std::exception_ptr> failures_;  // by worker
  std::vector<std::jthread> threads_;         // workers 1, 2, ...
};

}  // namespace espalier::derivation
