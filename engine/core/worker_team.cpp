#include "engine/core/worker_team.h"

#include <atomic>

#include "engine/core/check.h"
#include "engine/core/work_meter.h"

namespace espalier::core {

WorkerTeam::WorkerTeam(unsigned size) : failures_(size) {
  ESPALIER_CHECK(size > 0);
  try {
    for (unsigned worker = 1; worker < size; ++worker) {
      threads_.emplace_back([this, worker] { work(worker); });
    }
  } catch (...) {
    // the system has no more threads: those that wait already must end before they are joined
    stop();
    throw;
  }
}

WorkerTeam::~WorkerTeam() {
  stop();
}

void WorkerTeam::stop() {
  {
    const std::lock_guard lock(mutex_);
    isStopping_ = true;
  }
  wake_.notify_all();
}

void WorkerTeam::runTask(unsigned worker) noexcept {
  failures_[worker] = nullptr;
  try {
    (*task_)(worker);
  } catch (...) {
    failures_[worker] = std::current_exception();
  }
}

void WorkerTeam::work(unsigned worker) {
  std::uint64_t seen = 0;
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [&] { return isStopping_ || round_ != seen; });
    if (isStopping_) {
      return;
    }
    seen = round_;
    lock.unlock();
    runTask(worker);
    lock.lock();
    if (--busy_ == 0) {
      done_.notify_one();
    }
  }
}

void WorkerTeam::onEveryWorker(const std::function<void(unsigned)>& plainTask) {
  // the threads work for the meter of the caller
  WorkMeter* const meter = threads_.empty() ? nullptr : WorkMeter::current();
  const std::function<void(unsigned)> meteredTask = [meter, &plainTask](unsigned worker) {
    if (worker == 0) {
      plainTask(worker);
    } else {
      const WorkMeter::Scope scope(meter);
      plainTask(worker);
    }
  };
  const std::function<void(unsigned)>& task = meter == nullptr ? plainTask : meteredTask;
  {
    const std::lock_guard lock(mutex_);
    task_ = &task;
    busy_ = static_cast<unsigned>(threads_.size());
    ++round_;
  }
  wake_.notify_all();
  runTask(0);
  {
    std::unique_lock lock(mutex_);
    done_.wait(lock, [&] { return busy_ == 0; });
    task_ = nullptr;
  }
  for (const std::exception_ptr& failure : failures_) {
    if (failure) {
      std::rethrow_exception(failure);
    }
  }
}

void WorkerTeam::forEach(std::size_t count, const std::function<void(std::size_t)>& task) {
  if (threads_.empty() || count < 2) {
    for (std::size_t i = 0; i < count; ++i) {
      task(i);
    }
    return;
  }
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::size_t firstFailed = count;
  std::exception_ptr failure;
  onEveryWorker([&](unsigned) {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        task(i);
      } catch (...) {
        // tasks start in order: every task with a lower number has started and finishes
        next = count;
        const std::lock_guard lock(mutex);
        if (i < firstFailed) {
          firstFailed = i;
          failure = std::current_exception();
        }
      }
    }
  });
  if (failure) {
    std::rethrow_exception(failure);
  }
}

}  // namespace espalier::core
