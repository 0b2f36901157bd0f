#pragma once

#include <atomic>
#include <cstdint>

#include "engine/core/work_meter.h"
#include "server/running/account.h"

namespace espalier::server {

/// Bounds one turn of work by the memory of an account. Memory that the turn takes is reserved in the account while it
/// takes it, and given back at its end: memory that stays is then counted where it is (Holding). May be stopped from
/// any thread.
class TurnMeter final : public core::WorkMeter {
 public:
  /// The behaviour of work that is stopped.
  enum class WhenStopped : std::uint8_t {
    Asks,          // its loops ask isStopped()
    GetsNoMemory,  // it is code of a library that does not ask: the next block that it takes is refused
  };

  TurnMeter(Account& account, MemoryKind kind, WhenStopped whenStopped = WhenStopped::Asks)
      : account_(&account), kind_(kind), whenStopped_(whenStopped) {}
  ~TurnMeter() override;

  /// Reserves in the account in advance, as for a block of a known size. False: the account does not have it.
  [[nodiscard]] bool take(std::int64_t bytes) noexcept override;
  [[nodiscard]] bool isStopped() const noexcept override { return isStopped_ || isRefused_; }
  [[nodiscard]] std::uint64_t enter() noexcept override;
  void leave(std::uint64_t entered) noexcept override;

  void stop() noexcept { isStopped_ = true; }
  /// The account did not have what the turn needed.
  [[nodiscard]] bool isRefused() const noexcept { return isRefused_; }
  [[nodiscard]] Account& account() { return *account_; }
  /// Bytes that this turn has taken and not given back; below 0: it freed older memory.
  [[nodiscard]] std::int64_t held() const noexcept { return held_; }
  /// Ends the reservation and begins anew.
  void giveBack() noexcept;
  /// Forgets a refusal, unless the work was stopped. True: it may go on.
  [[nodiscard]] bool tryAgain() noexcept {
    isRefused_ = false;
    return !isStopped_;
  }

 private:
  Account* account_;
  MemoryKind kind_;
  WhenStopped whenStopped_;
  std::atomic<std::int64_t> held_{0};      // taken and not given back in this turn; below 0: it freed older memory
  std::atomic<std::int64_t> reserved_{0};  // of the account
  std::atomic<bool> wasLarge_{false};      // it reserved so much that the heap is to give memory back to the system
  std::atomic<bool> isStopped_{false};
  std::atomic<bool> isRefused_{false};
};

/// Counts what a part of a turn takes and leaves, and asks the meter of the thread for it.
class PartMeter final : public core::WorkMeter {
 public:
  PartMeter() : outer_(core::WorkMeter::current()) {}

  [[nodiscard]] bool take(std::int64_t bytes) noexcept override {
    if (outer_ != nullptr && !outer_->take(bytes)) {
      return false;
    }
    net_ += bytes;
    return true;
  }
  [[nodiscard]] bool isStopped() const noexcept override { return outer_ != nullptr && outer_->isStopped(); }
  /// Bytes taken and not given back.
  [[nodiscard]] std::int64_t net() const { return net_; }

 private:
  core::WorkMeter* const outer_;
  std::atomic<std::int64_t> net_{0};
};

/// `new` and `delete` of this program tell the meter of their thread what they take and give back.
[[nodiscard]] bool isHeapMetered();

}  // namespace espalier::server
