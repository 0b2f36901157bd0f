#pragma once

#include <atomic>
#include <cstdint>

namespace espalier::server {

/// Bytes on a disk that several files share. Thread-safe.
class DiskRoom {
 public:
  /// 0: no bound.
  void setBound(std::uint64_t bytes) { bound_ = bytes; }
  [[nodiscard]] std::uint64_t bound() const { return bound_; }
  [[nodiscard]] std::uint64_t used() const { return used_; }
  [[nodiscard]] bool isFull() const { return bound_ > 0 && used_ >= bound_; }

  /// False: there is no room, and nothing was taken.
  [[nodiscard]] bool take(std::uint64_t bytes) {
    const std::uint64_t bound = bound_;
    const std::uint64_t used = used_ += bytes;
    if (bound > 0 && used > bound) {
      used_ -= bytes;
      return false;
    }
    return true;
  }
  /// What was there before, or is not there any more (below 0).
  void add(std::int64_t bytes) { used_ += static_cast<std::uint64_t>(bytes); }

 private:
  std::atomic<std::uint64_t> bound_{0};
  std::atomic<std::uint64_t> used_{0};
};

}  // namespace espalier::server
