#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <exception>

#include "engine/core/work_meter.h"

namespace espalier::server {

/// The memory of all connections of a host together: the simulations that their peers have open, and the messages that
/// are being read.
struct HostMemory {
  std::uint64_t most = 0;
  std::atomic<std::int64_t> held{0};
};

/// The memory of one connection, which counts in that of its host. Everything that the connection takes and gives back
/// is done for this meter. A program whose `new` tells no meter has no bound.
class ConnectionMemory final : public core::WorkMeter {
 public:
  explicit ConnectionMemory(HostMemory& host) : host_(&host) {}
  ~ConnectionMemory() override { host_->held -= told_; }
  ConnectionMemory(const ConnectionMemory&) = delete;
  ConnectionMemory& operator=(const ConnectionMemory&) = delete;

  [[nodiscard]] bool take(std::int64_t bytes) noexcept override {
    const std::int64_t own = own_ += bytes;
    if (isReading_ && bytes > 0 && own - ownBefore_ > kShort && host_->held + own - told_ > most() &&
        std::uncaught_exceptions() == 0) {
      own_ -= bytes;
      return false;
    }
    if (own > told_ + kPiece || own < told_ - kPiece) {
      host_->held += own - told_.exchange(own);
    }
    return true;
  }
  [[nodiscard]] bool isStopped() const noexcept override { return false; }

  /// The connection has no room for more. One that has little always has some: others do not keep it out.
  [[nodiscard]] bool isFull() const { return own_ > kShort && host_->held > most(); }
  /// While a long message is read, memory may be refused. A process that takes a step is not stopped in its middle.
  void setReading(bool isReading) {
    ownBefore_ = own_.load();
    isReading_ = isReading;
  }
  [[nodiscard]] std::size_t held() const { return static_cast<std::size_t>(std::max<std::int64_t>(own_, 0)); }
  [[nodiscard]] const HostMemory& host() const { return *host_; }

 private:
  static constexpr std::int64_t kShort = 1 << 20;
  /// The host is told of larger changes only: all connections would wait for one counter.
  static constexpr std::int64_t kPiece = 1 << 16;

  [[nodiscard]] std::int64_t most() const noexcept { return static_cast<std::int64_t>(host_->most); }

  HostMemory* host_;
  std::atomic<std::int64_t> own_{0};
  std::atomic<std::int64_t> told_{0};       // the part of own_ that the host counts
  std::atomic<std::int64_t> ownBefore_{0};  // the message that is read
  std::atomic<bool> isReading_{false};
};

}  // namespace espalier::server
