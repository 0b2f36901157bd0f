#include "server/running/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>

namespace espalier::server {
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

TEST(WorkerPool, TasksThatComeWhileAThreadLooksForOneAllGetAThread) {
  WorkerPool pool({.workers = 2, .overtime = kNever});
  for (int round = 0; round < 2'000; ++round) {
    // the threads that ended the last round look for tasks or sleep; these two end only together
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

TEST(WorkerPool, QuickTasksWaitForTheThreadThatTakesThem) {
  WorkerPool pool({.workers = 2, .overtime = kNever});
  std::thread::id quick;
  std::thread::id following;
  pool.takeQuickTasks(true);
  pool.post({.run =
                 [&] {
                   quick = std::this_thread::get_id();
                   // a thread that takes quick tasks is there for events: what goes on goes on elsewhere
                   pool.post(
                       {.run = [&] { following = std::this_thread::get_id(); }, .lane = Lane::Step, .isQuick = true});
                 },
             .lane = Lane::Step,
             .isQuick = true});
  EXPECT_TRUE(pool.hasQuickTask());
  EXPECT_FALSE(pool.waitUntilIdle(std::chrono::milliseconds(1)));
  pool.doQuickTask({});
  EXPECT_EQ(quick, std::this_thread::get_id());
  EXPECT_FALSE(pool.hasQuickTask());
  EXPECT_TRUE(pool.waitUntilIdle(kPatience));
  EXPECT_NE(following, std::thread::id());
  EXPECT_NE(following, std::this_thread::get_id());
  pool.takeQuickTasks(false);
}

TEST(WorkerPool, OneQuickTaskWaitsTheOthersGoToTheWorkers) {
  WorkerPool pool({.workers = 2, .overtime = kNever});
  std::latch areDone(2);
  std::atomic<int> onThisThread{0};
  pool.takeQuickTasks(true);
  for (int i = 0; i < 3; ++i) {
    pool.post({.run =
                   [&, caller = std::this_thread::get_id()] {
                     if (std::this_thread::get_id() == caller) {
                       ++onThisThread;
                     } else {
                       areDone.count_down();
                     }
                   },
               .lane = Lane::Step,
               .isQuick = true});
  }
  areDone.wait();
  EXPECT_EQ(onThisThread, 0);
  pool.doQuickTask({});
  EXPECT_EQ(onThisThread, 1);
  EXPECT_TRUE(pool.waitUntilIdle(kPatience));
  pool.takeQuickTasks(false);
}

TEST(WorkerPool, QuickTasksThatNobodyTakesGoToTheWorkers) {
  WorkerPool pool({.workers = 2});
  std::atomic<int> count{0};
  const auto post = [&] { pool.post({.run = [&] { ++count; }, .lane = Lane::Step, .isQuick = true}); };
  post();
  pool.takeQuickTasks(true);
  std::thread(post).join();
  EXPECT_FALSE(pool.hasQuickTask());
  post();
  EXPECT_TRUE(pool.hasQuickTask());
  pool.takeQuickTasks(false);
  EXPECT_FALSE(pool.hasQuickTask());
  EXPECT_TRUE(pool.waitUntilIdle(kPatience));
  EXPECT_EQ(count, 3);
}

TEST(WorkerPool, AQuickTaskThatWaitsSaysSoBefore) {
  WorkerPool pool({.workers = 1, .overtime = kNever});
  std::latch isDone(1);
  pool.takeQuickTasks(true);
  pool.post({.run = [&] { pool.blockWhile([&] { isDone.wait(); }); }, .lane = Lane::Step, .isQuick = true});
  int blocked = 0;
  pool.doQuickTask([&] {
    ++blocked;
    isDone.count_down();
  });
  EXPECT_EQ(blocked, 1);
  pool.takeQuickTasks(false);
}

TEST(WorkerPool, AQuickTaskThatIsNoneIsTimedLikeAnyOther) {
  WorkerPool pool({.workers = 1, .overtime = std::chrono::milliseconds(1)});
  std::latch isTold(1);
  std::latch isServed(1);
  pool.takeQuickTasks(true);
  pool.post({.run =
                 [&] {
                   isTold.wait();
                   isServed.wait();
                 },
             .lane = Lane::Step,
             .owner = "1",
             .isQuick = true,
             .limit = std::chrono::milliseconds(1),
             .onLimit = [&] { isTold.count_down(); }});
  pool.post({.run = [&] { isServed.count_down(); }, .lane = Lane::Step, .owner = "2"});
  pool.doQuickTask({});
  EXPECT_TRUE(pool.waitUntilIdle(kPatience));
  pool.takeQuickTasks(false);
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
}  // namespace espalier::server
