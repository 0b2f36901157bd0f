#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace espalier::core {

/// Threads that wait for work and then do it together. The calling thread is worker 0, so a team of one starts no
/// thread. Only one caller may use a team at a time, and a task must not use its own team.
///
///     core::WorkerTeam team(4);
///     team.forEach(rows.size(), [&](std::size_t row) { fill(rows[row]); });
class WorkerTeam {
 public:
  /// `size` workers, at least 1.
  explicit WorkerTeam(unsigned size);
  ~WorkerTeam();
  WorkerTeam(const WorkerTeam&) = delete;
  WorkerTeam& operator=(const WorkerTeam&) = delete;

  [[nodiscard]] unsigned size() const { return static_cast<unsigned>(failures_.size()); }

  /// Every worker calls task(its number) once, all at the same time. Returns when all have finished. Throws the
  /// exception of the worker with the lowest number.
  void onEveryWorker(const std::function<void(unsigned)>& task);

  /// The workers share the calls task(0), task(1), ... task(count - 1). Each takes the lowest number that is left, so
  /// the order of the calls is not determined: a task writes only to memory of its own. Returns when all calls have
  /// finished. After a failure no further task starts. Throws the exception of the lowest number that failed, as a loop
  /// on one thread does.
  void forEach(std::size_t count, const std::function<void(std::size_t)>& task);

 private:
  void work(unsigned worker);
  void runTask(unsigned worker) noexcept;
  void stop();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable done_;
  const std::function<void(unsigned)>* task_ = nullptr;  // of the caller, while onEveryWorker runs
  std::uint64_t round_ = 0;                              // calls of onEveryWorker so far
  unsigned busy_ = 0;                                    // threads that have not finished this round
  bool isStopping_ = false;
  std::vector<std::exception_ptr> failures_;  // by worker
  std::vector<std::jthread> threads_;         // of workers 1, 2, ...
};

}  // namespace espalier::core
