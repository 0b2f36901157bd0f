#include "server/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>

namespace espalier::server {
namespace {

TEST(WorkerPool, RunsEverythingPosted) {
  std::atomic<int> count{0};
  {
    WorkerPool pool(3);
    for (int i = 0; i < 1'000; ++i) {
      pool.post([&] { ++count; });
    }
  }
  EXPECT_EQ(count, 1'000);
}

TEST(WorkerPool, NeverComputesOnMoreThreadsThanWorkers) {
  std::atomic<int> running{0};
  std::atomic<int> most{0};
  {
    WorkerPool pool(2);
    for (int i = 0; i < 200; ++i) {
      pool.post([&] {
        const int now = ++running;
        int seen = most;
        while (now > seen && !most.compare_exchange_weak(seen, now)) {
        }
        std::this_thread::yield();
        --running;
      });
    }
  }
  EXPECT_LE(most, 2);
}

TEST(WorkerPool, ATaskThatWaitsLetsAnotherComputeInItsPlace) {
  WorkerPool pool(1);
  std::latch isDone(1);
  pool.post([&] { pool.blockWhile([&] { isDone.wait(); }); });
  // with its only worker waiting, the pool would hang here for ever
  pool.post([&] { isDone.count_down(); });
  EXPECT_TRUE(pool.waitUntilIdle(std::chrono::seconds(30)));
}

TEST(WorkerPool, WaitUntilIdleGivesUpInTime) {
  WorkerPool pool(1);
  std::latch isReleased(1);
  pool.post([&] { isReleased.wait(); });
  EXPECT_FALSE(pool.waitUntilIdle(std::chrono::milliseconds(1)));
  isReleased.count_down();
  EXPECT_TRUE(pool.waitUntilIdle(std::chrono::seconds(30)));
}

}  // namespace
}  // namespace espalier::server
