#include "server/worker_pool.h"

#include <algorithm>

namespace espalier::server {

WorkerPool::WorkerPool(unsigned workers)
    : workers_(workers > 0 ? workers : std::max(1U, std::thread::hardware_concurrency())) {}

WorkerPool::~WorkerPool() {
  std::vector<std::thread> threads;
  {
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return tasks_.empty() && running_ == 0; });
    isStopping_ = true;
    threads.swap(threads_);
  }
  wake_.notify_all();
  for (std::thread& thread : threads) {
    thread.join();
  }
}

void WorkerPool::post(Task task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
    startThreadIfNeeded();
  }
  wake_.notify_one();
}

std::size_t WorkerPool::computing() const {
  return running_ > blocked_ ? running_ - blocked_ : 0;
}

void WorkerPool::startThreadIfNeeded() {
  const bool hasWork = !tasks_.empty() && computing() < workers_;
  if (hasWork && waiting_ == 0 && threads_.size() < kMaximumThreads) {
    ++waiting_;
    threads_.emplace_back([this] { work(); });
  }
}

void WorkerPool::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return isStopping_ || (!tasks_.empty() && computing() < workers_); });
    if (isStopping_) {
      return;
    }
    Task task = std::move(tasks_.front());
    tasks_.pop_front();
    --waiting_;
    ++running_;
    // more tasks than threads that look for one
    startThreadIfNeeded();
    lock.unlock();
    task();
    task = nullptr;
    lock.lock();
    --running_;
    ++waiting_;
    if (tasks_.empty() && running_ == 0) {
      idle_.notify_all();
    }
  }
}

void WorkerPool::blockWhile(const std::function<void()>& wait) {
  {
    const std::lock_guard lock(mutex_);
    ++blocked_;
    startThreadIfNeeded();
  }
  wake_.notify_one();
  wait();
  // for a moment one thread more than `workers` may compute: waiting for a place here could deadlock two that wait for
  // each other
  const std::lock_guard lock(mutex_);
  --blocked_;
}

bool WorkerPool::waitUntilIdle(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  return idle_.wait_for(lock, time, [this] { return tasks_.empty() && running_ == 0; });
}

}  // namespace espalier::server
