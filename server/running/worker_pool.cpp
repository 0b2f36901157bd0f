#include "server/running/worker_pool.h"

#include <algorithm>
#include <utility>

#include "server/remote/control_group.h"
#include "server/remote/freed_memory.h"

namespace espalier::server {
namespace {

/// The longest time between two looks of the keeper while tasks run.
constexpr std::chrono::milliseconds kLongestLook{50};

}  // namespace

thread_local WorkerPool::Running* WorkerPool::current_ = nullptr;

WorkerPool::WorkerPool(const WorkerPoolOptions& options)
    : workers_(options.workers > 0 ? options.workers : processorCount()), overtime_(options.overtime) {
  lanes_[static_cast<std::size_t>(Lane::Short)].workers = std::max(2U, workers_);
  lanes_[static_cast<std::size_t>(Lane::Step)].workers = workers_;
  lanes_[static_cast<std::size_t>(Lane::Decode)].workers = workers_;
  // frames leave room for steps
  lanes_[static_cast<std::size_t>(Lane::Frame)].workers = std::max(1U, workers_ / 2);
  keeper_ = std::thread([this] { keepTime(); });
}

WorkerPool::~WorkerPool() {
  std::vector<std::thread> threads;
  {
    std::unique_lock lock(mutex_);
    idle_.wait(lock, [this] { return isIdle(); });
    isStopping_ = true;
    threads.swap(threads_);
  }
  wake_.notify_all();
  time_.notify_all();
  for (std::thread& thread : threads) {
    thread.join();
  }
  keeper_.join();
}

void WorkerPool::post(Task task) {
  {
    const std::lock_guard lock(mutex_);
    enqueue(std::move(task));
    startThreadIfNeeded();
  }
  wake_.notify_one();
}

void WorkerPool::postAtEnd(Task task) {
  if (current_ == nullptr) {
    post(std::move(task));
    return;
  }
  const std::lock_guard lock(mutex_);
  enqueue(std::move(task));
}

void WorkerPool::enqueue(Task task) {
  LaneState& lane = laneOf(task);
  ++lane.waiting;
  lane.owners[task.owner].tasks.push_back(std::move(task));
}

WorkerPool::Owner* WorkerPool::nextOwner(LaneState& lane) {
  if (lane.waiting == 0 || lane.counted >= lane.workers || lane.computing >= lane.workers + kMaximumOvertime) {
    return nullptr;
  }
  // the owner that computes least; among equals the one that was served longest ago
  Owner* next = nullptr;
  for (auto& [name, owner] : lane.owners) {
    const bool isReady =
        !owner.tasks.empty() && owner.computing < lane.workers && owner.blocked < kMaximumBlockedPerOwner;
    if (isReady && (next == nullptr || owner.computing < next->computing ||
                    (owner.computing == next->computing && owner.lastServed < next->lastServed))) {
      next = &owner;
    }
  }
  return next;
}

WorkerPool::LaneState* WorkerPool::readyLane() {
  for (LaneState& lane : lanes_) {
    if (nextOwner(lane) != nullptr) {
      return &lane;
    }
  }
  return nullptr;
}

void WorkerPool::startThreadIfNeeded() {
  if (freeThreads_ == 0 && threads_.size() < kMaximumThreads && readyLane() != nullptr) {
    ++freeThreads_;
    threads_.emplace_back([this] { work(); });
  }
}

bool WorkerPool::isIdle() const {
  return running_.empty() &&
         std::all_of(lanes_.begin(), lanes_.end(), [](const LaneState& lane) { return lane.waiting == 0; });
}

void WorkerPool::begin(Running& running) {
  LaneState& lane = laneOf(running.task);
  Owner& owner = lane.owners[running.task.owner];
  ++lane.counted;
  ++lane.computing;
  ++owner.computing;
  owner.lastServed = ++begunCount_;
  running.start = Clock::now();
  if (isKeeperResting_) {
    isKeeperResting_ = false;
    time_.notify_one();
  }
}

void WorkerPool::end(Running& running) {
  LaneState& lane = laneOf(running.task);
  const auto owner = lane.owners.find(running.task.owner);
  --lane.computing;
  --owner->second.computing;
  if (!running.isOvertime) {
    --lane.counted;
  }
  if (owner->second.tasks.empty() && owner->second.computing == 0 && owner->second.blocked == 0) {
    lane.owners.erase(owner);
  }
}

void WorkerPool::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return isStopping_ || readyLane() != nullptr; });
    // tasks that the destructor of the last task posted are still carried out
    LaneState* const lane = readyLane();
    if (lane == nullptr) {
      return;
    }
    Owner& owner = *nextOwner(*lane);
    Task task = std::move(owner.tasks.front());
    owner.tasks.pop_front();
    --lane->waiting;
    carryOut(std::move(task), lock);
  }
}

void WorkerPool::carryOut(Task task, std::unique_lock<std::mutex>& lock) {
  --freeThreads_;
  const auto running = running_.emplace(running_.end());
  running->task = std::move(task);
  begin(*running);
  // one thread was woken: wake or start another when there is more to do
  startThreadIfNeeded();
  const bool isMoreReady = freeThreads_ > 0 && readyLane() != nullptr;
  lock.unlock();
  if (isMoreReady) {
    wake_.notify_one();
  }
  current_ = &*running;
  running->task.run();
  running->task.run = nullptr;
  current_ = nullptr;
  lock.lock();
  end(*running);
  std::list<Running> done;
  done.splice(done.begin(), running_, running);
  if (isIdle()) {
    idle_.notify_all();
  }
  ++freeThreads_;
  lock.unlock();
  done.clear();
  trimHeap();
  lock.lock();
}

void WorkerPool::blockWhile(const std::function<void()>& wait) {
  Running* const running = current_;
  if (running == nullptr) {
    wait();
    return;
  }
  const Clock::time_point before = Clock::now();
  {
    const std::lock_guard lock(mutex_);
    LaneState& lane = laneOf(running->task);
    Owner& owner = lane.owners[running->task.owner];
    running->isBlocked = true;
    --owner.computing;
    ++owner.blocked;
    --lane.computing;
    lane.counted -= running->isOvertime ? 0U : 1U;
    startThreadIfNeeded();
  }
  wake_.notify_one();
  wait();
  // for a moment one task more than `workers` may compute: to wait for a place here could deadlock two tasks that wait
  // for each other
  const std::lock_guard lock(mutex_);
  LaneState& lane = laneOf(running->task);
  Owner& owner = lane.owners[running->task.owner];
  running->isBlocked = false;
  running->start += Clock::now() - before;
  ++owner.computing;
  --owner.blocked;
  ++lane.computing;
  lane.counted += running->isOvertime ? 0U : 1U;
}

bool WorkerPool::look(Clock::time_point now, std::vector<std::function<void()>>& reached) {
  bool isFreed = false;
  for (Running& running : running_) {
    if (running.isBlocked) {
      continue;
    }
    const auto computed = now - running.start;
    if (!running.isOvertime && computed >= overtime_) {
      running.isOvertime = true;
      --laneOf(running.task).counted;
      isFreed = true;
    }
    const Task& task = running.task;
    if (task.limit.count() > 0 && !running.isLimitReached && computed >= task.limit) {
      running.isLimitReached = true;
      reached.push_back(task.onLimit);
    }
  }
  return isFreed;
}

void WorkerPool::keepTime() {
  const auto interval = std::clamp(overtime_ / 4, std::chrono::milliseconds(1), kLongestLook);
  std::vector<std::function<void()>> reached;
  std::unique_lock lock(mutex_);
  while (!isStopping_) {
    if (running_.empty()) {
      isKeeperResting_ = true;
      time_.wait(lock, [this] { return isStopping_ || !isKeeperResting_; });
      continue;
    }
    time_.wait_for(lock, interval, [this] { return isStopping_; });
    if (look(Clock::now(), reached)) {
      startThreadIfNeeded();
      wake_.notify_all();
    }
    lock.unlock();
    for (const auto& call : reached) {
      call();
    }
    reached.clear();
    lock.lock();
  }
}

bool WorkerPool::waitUntilIdle(std::chrono::milliseconds time) {
  std::unique_lock lock(mutex_);
  return idle_.wait_for(lock, time, [this] { return isIdle(); });
}

}  // namespace espalier::server
