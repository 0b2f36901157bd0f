#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "server/remote/limits.h"

namespace espalier::server {

/// The limits of a running server, which its operator may change. A reader gets all of them as they were at one moment,
/// and may keep the reference: old limits stay until the server ends, because they change seldom. Thread-safe.
class LiveLimits {
 public:
  explicit LiveLimits(const ServerLimits& limits) { set(limits); }
  LiveLimits(const LiveLimits&) = delete;
  LiveLimits& operator=(const LiveLimits&) = delete;

  [[nodiscard]] const ServerLimits& get() const { return *current_.load(std::memory_order_acquire); }
  void set(const ServerLimits& limits) {
    const std::lock_guard lock(mutex_);
    current_.store(all_.emplace_back(std::make_unique<const ServerLimits>(limits)).get(), std::memory_order_release);
  }

 private:
  std::atomic<const ServerLimits*> current_{nullptr};
  std::mutex mutex_;
  std::vector<std::unique_ptr<const ServerLimits>> all_;
};

}  // namespace espalier::server
