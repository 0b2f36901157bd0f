#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <utility>

namespace espalier::server {

/// Ends a piece of work from another thread. The work says how it can be stopped, and when. Thread-safe.
class Interruption {
 public:
  enum class Reason : std::uint8_t {
    None,
    Cancelled,    // by the caller, or the caller has left
    CallSeconds,  // it took longer than a call may
  };

  /// Stops the work, now or as soon as it can be stopped. The first reason counts.
  void interrupt(Reason reason) {
    const std::lock_guard lock(mutex_);
    if (reason_ == Reason::None) {
      reason_ = reason;
    }
    if (stop_) {
      stop_();
    }
  }
  [[nodiscard]] Reason reason() const {
    const std::lock_guard lock(mutex_);
    return reason_;
  }

  /// While it lives the work can be stopped by `stop`, which must be quick and may come from any thread. Scopes nest;
  /// the inner one counts.
  class Scope {
   public:
    Scope(Interruption& interruption, std::function<void()> stop) : interruption_(&interruption) {
      const std::lock_guard lock(interruption_->mutex_);
      outer_ = std::move(interruption_->stop_);
      // the scope around it is stopped too
      interruption_->stop_ = [this, own = std::move(stop)] {
        own();
        if (outer_) {
          outer_();
        }
      };
      if (interruption_->reason_ != Reason::None) {
        interruption_->stop_();
      }
    }
    ~Scope() {
      const std::lock_guard lock(interruption_->mutex_);
      interruption_->stop_ = std::move(outer_);
    }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    Interruption* interruption_;
    std::function<void()> outer_;
  };

 private:
  mutable std::mutex mutex_;
  Reason reason_ = Reason::None;
  std::function<void()> stop_;
};

}  // namespace espalier::server
