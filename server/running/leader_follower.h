#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>

namespace espalier::server {

/// Two threads take turns at one loop of events (the pattern Leader/Followers; Schmidt, Stal, Rohnert and Buschmann,
/// Pattern-Oriented Software Architecture 2, 2000). The leader handles events, and computes what is expected to be over
/// before another thread could be woken. When it is not over after `patience`, or when it begins to wait for somebody,
/// the follower leads on; who computed follows when it is done. Events are handled by one thread at a time, and what
/// one leader did happens before what the next one does.
class LeaderFollower {
 public:
  enum class Next : std::uint8_t { Handle, Compute, End };
  struct Work {
    std::function<Next()> handle;   // some events, or waits for one; says what comes next
    std::function<void()> compute;  // said only while there is a follower
  };

  LeaderFollower(Work work, std::chrono::microseconds patience);

  /// Until `handle` says that it is the end: on this thread and another, which is joined. Throws what they throw.
  void run();

  // in Work::handle
  /// Somebody would lead on: Next::Compute may be said.
  [[nodiscard]] bool hasFollower() const { return hasFollower_.load(std::memory_order_acquire); }

  // in Work::compute
  /// Lets the follower lead at once.
  void giveWay();

 private:
  void takePart(bool isLeader);
  /// False: another leads now, or it is the end.
  [[nodiscard]] bool leadOn();
  [[nodiscard]] bool computeAside();
  /// False: it is the end.
  [[nodiscard]] bool follow();
  void end(std::exception_ptr failure);

  static constexpr std::int64_t kNobody = 0;
  static constexpr std::int64_t kLongAgo = 1;

  const Work work_;
  const std::int64_t patience_;  // nanoseconds
  /// When the leader went to compute, in nanoseconds of the steady clock; who sets it from there to kNobody leads.
  std::atomic<std::int64_t> leftAt_{kNobody};
  std::atomic<std::uint64_t> computedCount_{0};
  std::atomic<bool> hasFollower_{false};
  std::atomic<bool> isAsleep_{false};  // the follower, until it is woken
  std::mutex mutex_;
  std::condition_variable wake_;
  bool isOver_ = false;
  std::exception_ptr failure_;
};

}  // namespace espalier::server
