#include "server/running/leader_follower.h"

#include <thread>
#include <utility>

namespace espalier::server {
namespace {

/// How long a follower goes on looking after nothing was computed any more, before it sleeps until it is woken: in
/// patiences.
constexpr int kQuietLooks = 50;

std::int64_t now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace

LeaderFollower::LeaderFollower(Work work, std::chrono::microseconds patience)
    : work_(std::move(work)), patience_(std::chrono::nanoseconds(patience).count()) {}

void LeaderFollower::run() {
  std::thread other([this] { takePart(false); });
  takePart(true);
  other.join();
  if (failure_) {
    std::rethrow_exception(failure_);
  }
}

void LeaderFollower::takePart(bool isLeader) {
  try {
    while (isLeader || follow()) {
      isLeader = leadOn();
    }
  } catch (...) {
    end(std::current_exception());
  }
}

bool LeaderFollower::leadOn() {
  while (true) {
    switch (work_.handle()) {
      case Next::Handle:
        break;
      case Next::Compute:
        if (!computeAside()) {
          return false;
        }
        break;
      case Next::End:
        end(nullptr);
        return false;
    }
  }
}

bool LeaderFollower::computeAside() {
  computedCount_.fetch_add(1, std::memory_order_relaxed);
  leftAt_.store(now());
  if (isAsleep_.load()) {
    // it holds the mutex until it can be woken
    const std::lock_guard lock(mutex_);
    wake_.notify_one();
  }
  work_.compute();
  return leftAt_.exchange(kNobody) != kNobody;
}

void LeaderFollower::giveWay() {
  std::int64_t left = leftAt_.load();
  if (left == kNobody || !leftAt_.compare_exchange_strong(left, kLongAgo)) {
    return;  // somebody leads already
  }
  const std::lock_guard lock(mutex_);
  wake_.notify_one();
}

bool LeaderFollower::follow() {
  std::unique_lock lock(mutex_);
  hasFollower_.store(true, std::memory_order_release);
  std::uint64_t seenCount = computedCount_.load(std::memory_order_relaxed);
  int quietLooks = 0;
  while (!isOver_) {
    std::int64_t left = leftAt_.load();
    if (left == kLongAgo || (left != kNobody && now() - left >= patience_)) {
      hasFollower_.store(false, std::memory_order_relaxed);
      if (leftAt_.compare_exchange_strong(left, kNobody)) {
        return true;
      }
      hasFollower_.store(true, std::memory_order_release);
      continue;
    }
    if (left != kNobody || quietLooks < kQuietLooks) {
      wake_.wait_for(lock, std::chrono::nanoseconds(patience_));
      const std::uint64_t count = computedCount_.load(std::memory_order_relaxed);
      quietLooks = count == std::exchange(seenCount, count) ? quietLooks + 1 : 0;
      continue;
    }
    isAsleep_.store(true);
    if (leftAt_.load() == kNobody) {
      wake_.wait(lock);
    }
    isAsleep_.store(false);
    quietLooks = 0;
  }
  return false;
}

void LeaderFollower::end(std::exception_ptr failure) {
  const std::lock_guard lock(mutex_);
  isOver_ = true;
  if (failure && !failure_) {
    failure_ = std::move(failure);
  }
  wake_.notify_all();
}

}  // namespace espalier::server
