#pragma once

#include <atomic>

#include "engine/core/work_meter.h"

namespace espalier::environment {

/// Stops the work when it has asked so often. Threads may share it.
class StopsAfter final : public core::WorkMeter {
 public:
  explicit StopsAfter(int asked) : left_(asked) {}
  [[nodiscard]] bool take(std::int64_t) noexcept override { return true; }
  [[nodiscard]] bool isStopped() const noexcept override { return left_-- <= 0; }

 private:
  mutable std::atomic<int> left_;
};

}  // namespace espalier::environment
