#include "engine/turtle/export/worker_team.h"

#include <exception>
#include <utility>

namespace espalier::turtle {

WorkerTeam::WorkerTeam(unsigned threads) {
  // the caller is one of them
  for (unsigned i = 1; i < threads; ++i) {
    threads_.emplace_back([this] { work(); });
  }
}

WorkerTeam::~WorkerTeam() {
  {
    const std::lock_guard lock(mutex_);
    isEnding_ = true;
  }
  hasWork_.notify_all();
  for (std::thread& thread : threads_) {
    thread.join();
  }
}

void WorkerTeam::takeTasks(std::unique_lock<std::mutex>& lock) {
  while (task_ != nullptr && next_ < count_) {
    const std::size_t i = next_++;
    const auto& task = *task_;
    lock.unlock();
    std::exception_ptr failure;
    try {
      task(i);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    if (failure && !failure_) {
      failure_ = failure;
    }
    if (--unfinished_ == 0) {
      task_ = nullptr;
      isDone_.notify_all();
    }
  }
}

void WorkerTeam::work() {
  std::unique_lock lock(mutex_);
  while (!isEnding_) {
    takeTasks(lock);
    hasWork_.wait(lock, [this] { return isEnding_ || (task_ != nullptr && next_ < count_); });
  }
}

void WorkerTeam::run(std::size_t count, const std::function<void(std::size_t)>& task) {
  if (threads_.empty() || count < 2) {
    for (std::size_t i = 0; i < count; ++i) {
      task(i);
    }
    return;
  }
  std::unique_lock lock(mutex_);
  task_ = &task;
  count_ = count;
  next_ = 0;
  unfinished_ = count;
  hasWork_.notify_all();
  takeTasks(lock);
  isDone_.wait(lock, [this] { return task_ == nullptr; });
  if (std::exception_ptr failure = std::exchange(failure_, nullptr)) {
    std::rethrow_exception(failure);
  }
}

}  // namespace espalier::turtle
