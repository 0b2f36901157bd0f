#include "engine/core/work_meter.h"

#include <gtest/gtest.h>

#include <atomic>

#include "engine/core/buffer.h"
#include "engine/core/worker_team.h"

namespace espalier::core::work_meter_test {
namespace {

/// Allows so many bytes.
class Bound final : public WorkMeter {
 public:
  explicit Bound(std::int64_t bytes) : bytes_(bytes) {}
  [[nodiscard]] bool take(std::int64_t bytes) noexcept override {
    if (bytes > 0 && held + bytes > bytes_) {
      return false;
    }
    held += bytes;
    return true;
  }
  [[nodiscard]] bool isStopped() const noexcept override { return isStoppedNow; }
  [[nodiscard]] std::uint64_t enter() noexcept override { return ++entered; }
  void leave(std::uint64_t value) noexcept override { left += value; }

  std::atomic<std::int64_t> held{0};
  std::atomic<bool> isStoppedNow{false};
  std::atomic<std::uint64_t> entered{0};
  std::atomic<std::uint64_t> left{0};

 private:
  const std::int64_t bytes_;
};

TEST(WorkMeter, ScopesNestAndEndInTheirOrder) {
  EXPECT_EQ(WorkMeter::current(), nullptr);
  Bound outer(0);
  {
    const WorkMeter::Scope scope(&outer);
    EXPECT_EQ(WorkMeter::current(), &outer);
    {
      const WorkMeter::Scope none(nullptr);
      EXPECT_EQ(WorkMeter::current(), nullptr);
    }
    EXPECT_EQ(WorkMeter::current(), &outer);
    EXPECT_EQ(outer.left, 0U);
  }
  EXPECT_EQ(WorkMeter::current(), nullptr);
  EXPECT_EQ(outer.left, 1U);
}

TEST(WorkMeter, PollingThrowsOnlyWhenTheWorkIsToStop) {
  pollWork();
  Bound meter(0);
  const WorkMeter::Scope scope(&meter);
  pollWork();
  meter.isStoppedNow = true;
  EXPECT_THROW(pollWork(), WorkStopped);
}

TEST(WorkMeter, BuffersTellWhatTheyTakeAndGiveBack) {
  Bound meter(50'000'000);
  const WorkMeter::Scope scope(&meter);
  {
    // small blocks, big ones, and blocks that move
    Buffer<double> buffer;
    for (const std::size_t count : {100U, 10'000U, 200'000U, 300'000U, 2'000'000U}) {
      buffer.resize(count);
      EXPECT_GE(meter.held, static_cast<std::int64_t>(buffer.capacity() * sizeof(double)));
      EXPECT_LE(meter.held, static_cast<std::int64_t>(buffer.capacity() * sizeof(double)) + 100);
    }
    const std::size_t before = buffer.capacity();
    EXPECT_THROW(buffer.reserve(7'000'000), std::bad_alloc);
    EXPECT_EQ(buffer.capacity(), before);
    EXPECT_EQ(buffer.size(), 2'000'000U);
  }
  EXPECT_LE(std::abs(meter.held), 100);
}

TEST(WorkMeter, ThreadsOfATeamWorkForTheMeterOfTheirCaller) {
  WorkerTeam team(3);
  Bound meter(0);
  std::atomic<int> metered{0};
  {
    const WorkMeter::Scope scope(&meter);
    team.onEveryWorker([&](unsigned) { metered += WorkMeter::current() == &meter ? 1 : 0; });
  }
  EXPECT_EQ(metered, 3);
  // the two threads and the scope of this one
  EXPECT_EQ(meter.entered, 3U);
  team.onEveryWorker([&](unsigned) { metered += WorkMeter::current() == nullptr ? 1 : 0; });
  EXPECT_EQ(metered, 6);
}

}  // namespace
}  // namespace espalier::core::work_meter_test
