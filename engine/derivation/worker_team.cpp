#include "engine/derivation/worker_team.h"

namespace espalier::derivation {

WorkerTeam::WorkerTeam(unsigned size) : failures_(size) {
  for (unsigned worker = 1; worker < size; ++worker) {
    threads_.emplace_back([this, worker] { work(worker); });
  }
}

WorkerTeam::~WorkerTeam() {
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

void WorkerTeam::run(const std::function<void(unsigned)>& task) {
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

}  // namespace espalier::derivation
