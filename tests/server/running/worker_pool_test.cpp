#include "server/running/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <memory>

namespace espalier::server::worker_pool_test {
namespace {

/// Longer than any test: nothing is in overtime.
constexpr std::chrono::hours kNever{1};
constexpr std::chrono::seconds kPatience{30};

TEST(WorkerPool, RunsEverythingPosted) {
  std::atomic<int> count{0};
  {
    WorkerPool pool({.workers = 3});
    for (int i = 0; i < 1'000; ++i) {
      pool.post({.run = [&] { ++count; }, .owner = std::to_string(i % 7)});
    }
  }
  EXPECT_EQ(count, 1'000);
}

TEST(WorkerPool, NeverComputesOnMoreThreadsThanWorkers) {
  std::atomic<int> running{0};
  std::atomic<int> most{0};
  {
    WorkerPool pool({.workers = 2, .overtime = kNever});
    for (int i = 0; i < 200; ++i) {
      const auto run = [&] {
        const int now = ++running;
        int seen = most;
        while (now > seen && !most.compare_exchange_weak(seen, now)) {
        }
        std::this_thread::yield();
        --running;
      };
      pool.post({.run = run, .lane = Lane::Step, .owner = std::to_string(i % 5)});
    }
  }
  EXPECT_LE(most, 2);
}

TEST(WorkerPool, TasksThatComeWhileAThreadEndsAllGetAThread) {
  WorkerPool pool({.workers = 2, .overtime = kNever});
  for (int round = 0; round < 2'000; ++round) {
    // the threads that ended the last round may not sleep yet; these two end only together
    std::latch areBothRunning(2);
    for (const char* owner : {"1", "2"}) {
      pool.post({.run = [&] { areBothRunning.arrive_and_wait(); }, .lane = Lane::Step, .owner = owner});
    }
    ASSERT_TRUE(pool.waitUntilIdle(kPatience)) << "round " << round;
  }
}

TEST(WorkerPool, ATaskThatWaitsLetsAnotherComputeInItsPlace) {
  WorkerPool pool({.workers = 1, .overtime = kNever});
  std::latch isDone(1);
  pool.post({.run = [&] { pool.blockWhile([&] { isDone.wait(); }); }, .lane = Lane::Step});
  // with its only worker waiting, the pool would hang here for ever
  pool.post({.run = [&] { isDone.count_down(); }, .lane = Lane::Step});
  EXPECT_TRUE(pool.waitUntilIdle(kPatience));
}

TEST(WorkerPool, ShortTasksNeverWaitBehindSteps) {
  WorkerPool pool({.workers = 1, .overtime = kNever});
  std::latch isReleased(1);
  std::latch isAnswered(1);
  pool.post({.run = [&] { isReleased.wait(); }, .lane = Lane::Step, .owner = "1"});
  pool.post({.run = [&] { isReleased.wait(); }, .lane = Lane::Step, .owner = "2"});
  pool.post({.run = [&] { isAnswered.count_down(); }, .lane = Lane::Short, .owner = "3"});
  isAnswered.wait();
  isReleased.count_down();
  EXPECT_TRUE(pool.waitUntilIdle(kPatience));
}

TEST(WorkerPool, OwnersTakeTurnsHoweverManyTasksEachHas) {
  WorkerPool pool({.workers = 1, .overtime = kNever});
  std::latch isReleased(1);
  std::string order;  // one worker: no two write at a time
  pool.post({.run = [&] { isReleased.wait(); }, .lane = Lane::Step, .owner = "gate"});
  for (int i = 0; i < 3; ++i) {
    pool.post({.run = [&] { order += 'a'; }, .lane = Lane::Step, .owner = "a"});
  }
  pool.post({.run = [&] { order += 'b'; }, .lane = Lane::Step, .owner = "b"});
  pool.post({.run = [&] { order += 'b'; }, .lane = Lane::Step, .owner = "b"});
  isReleased.count_down();
  ASSERT_TRUE(pool.waitUntilIdle(kPatience));
  EXPECT_EQ(order, "ababa");
}

TEST(WorkerPool, AnEndlessStepGivesItsPlaceToOtherOwnersNotToItsOwn) {
  WorkerPool pool({.workers = 1, .overtime = std::chrono::milliseconds(1)});
  std::latch isReleased(1);
  std::latch isServed(2);
  std::atomic<bool> hasSecond{false};
  pool.post({.run = [&] { isReleased.wait(); }, .lane = Lane::Step, .owner = "hog"});
  pool.post({.run = [&] { hasSecond = true; }, .lane = Lane::Step, .owner = "hog"});
  // with its only worker taken, the pool would hang here for ever
  pool.post({.run = [&] { isServed.count_down(); }, .lane = Lane::Step, .owner = "other"});
  pool.post({.run = [&] { isServed.count_down(); }, .lane = Lane::Step, .owner = "other"});
  isServed.wait();
  EXPECT_FALSE(hasSecond);
  isReleased.count_down();
  EXPECT_TRUE(pool.waitUntilIdle(kPatience));
  EXPECT_TRUE(hasSecond);
}

TEST(WorkerPool, ATaskBeyondItsLimitIsTold) {
  WorkerPool pool({.workers = 1, .overtime = kNever});
  std::latch isTold(1);
  pool.post(
      {.run = [&] { isTold.wait(); }, .limit = std::chrono::milliseconds(1), .onLimit = [&] { isTold.count_down(); }});
  EXPECT_TRUE(pool.waitUntilIdle(kPatience));
}

TEST(WorkerPool, ATaskPostedAtTheEndOfAnotherIsRunByItsThread) {
  WorkerPool pool({.workers = 1, .overtime = kNever});
  std::thread::id first;
  std::thread::id second;
  pool.post({.run =
                 [&] {
                   first = std::this_thread::get_id();
                   pool.postAtEnd({.run = [&] { second = std::this_thread::get_id(); }, .lane = Lane::Step});
                 },
             .lane = Lane::Step});
  ASSERT_TRUE(pool.waitUntilIdle(kPatience));
  EXPECT_EQ(first, second);
}

TEST(WorkerPool, ATaskThatADestructorPostsIsRunAlsoWhenThePoolIsBeingDestroyed) {
  std::atomic<bool> isRun{false};
  {
    WorkerPool pool({.workers = 1});
    const auto posting = [&pool, &isRun](void*) { pool.post({.run = [&isRun] { isRun = true; }}); };
    std::shared_ptr<void> held(nullptr, posting);
    pool.post({.run = [] {}, .limit = std::chrono::hours(1), .onLimit = [held = std::move(held)] {}});
  }
  EXPECT_TRUE(isRun);
}

TEST(WorkerPool, WaitUntilIdleGivesUpInTime) {
  WorkerPool pool({.workers = 1});
  std::latch isReleased(1);
  pool.post({.run = [&] { isReleased.wait(); }});
  EXPECT_FALSE(pool.waitUntilIdle(std::chrono::milliseconds(1)));
  isReleased.count_down();
  EXPECT_TRUE(pool.waitUntilIdle(kPatience));
}

}  // namespace
}  // namespace espalier::server::worker_pool_test
