#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace espalier::turtle {

/// Threads that share out the tasks 0 to n-1 of one job after another. Which thread does which task is not determined:
/// tasks must write to places of their own. With one thread the caller does everything.
class WorkerTeam {
 public:
  explicit WorkerTeam(unsigned threads);
  ~WorkerTeam();
  WorkerTeam(const WorkerTeam&) = delete;
  WorkerTeam& operator=(const WorkerTeam&) = delete;

  /// The caller counts as one.
  [[nodiscard]] unsigned threadCount() const { return static_cast<unsigned>(threads_.size()) + 1; }

  /// Does `task(i)` for each i below `count` and returns when all are done. The first exception of a task is thrown
  /// again here after that.
  void run(std::size_t count, const std::function<void(std::size_t)>& task);

 private:
  void work();
  void takeTasks(std::unique_lock<std::mutex>& lock);

  std::mutex mutex_;
  std::condition_variable hasWork_, isDone_;
  const std::function<void(std::size_t)>* task_ = nullptr;  // of the job under way; null: none
  std::size_t count_ = 0;
  std::size_t next_ = 0;
  std::size_t unfinished_ = 0;
  std::exception_ptr failure_;
  bool isEnding_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace espalier::turtle
