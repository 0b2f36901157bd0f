#include "engine/core/worker_team.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace espalier::worker_team_test {
namespace {

using core::WorkerTeam;

/// The text of what a call throws; empty: nothing.
template <typename Call>
std::string failureOf(const Call& call) {
  try {
    call();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

TEST(WorkerTeam, EveryWorkerRunsOncePerRound) {
  for (const unsigned size : {1U, 2U, 5U}) {
    WorkerTeam team(size);
    EXPECT_EQ(team.size(), size);
    std::vector<std::atomic<int>> counts(size);
    for (int round = 1; round <= 20; ++round) {
      team.onEveryWorker([&](unsigned worker) { ++counts[worker]; });
      for (const std::atomic<int>& count : counts) {
        EXPECT_EQ(count.load(), round);
      }
    }
  }
}

TEST(WorkerTeam, TheCallerIsWorkerZero) {
  WorkerTeam team(3);
  std::vector<std::thread::id> ids(3);
  team.onEveryWorker([&](unsigned worker) { ids[worker] = std::this_thread::get_id(); });
  EXPECT_EQ(ids[0], std::this_thread::get_id());
  EXPECT_NE(ids[1], ids[0]);
  EXPECT_NE(ids[2], ids[1]);
}

TEST(WorkerTeam, TheFailureOfTheLowestWorkerReachesTheCaller) {
  WorkerTeam team(3);
  const auto failing = [](unsigned worker) {
    if (worker > 0) {
      throw std::runtime_error("worker " + std::to_string(worker));
    }
  };
  EXPECT_EQ(failureOf([&] { team.onEveryWorker(failing); }), "worker 1");
  // and the team still works
  std::atomic<int> count = 0;
  team.onEveryWorker([&](unsigned) { ++count; });
  EXPECT_EQ(count.load(), 3);
}

TEST(WorkerTeam, EachTaskRunsOnceForAnyNumberOfThreads) {
  for (const unsigned size : {1U, 2U, 5U}) {
    WorkerTeam team(size);
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{1000}}) {
      std::vector<std::atomic<int>> done(count);
      team.forEach(count, [&](std::size_t i) { ++done[i]; });
      for (const std::atomic<int>& times : done) {
        ASSERT_EQ(times, 1);
      }
    }
  }
}

TEST(WorkerTeam, TheFailureOfTheLowestTaskReachesTheCaller) {
  for (const unsigned size : {1U, 3U}) {
    WorkerTeam team(size);
    for (int round = 0; round < 20; ++round) {
      std::vector<std::atomic<int>> done(100);
      const auto failing = [&](std::size_t i) {
        ++done[i];
        if (i == 7 || i == 9 || i == 99) {
          throw std::runtime_error("task " + std::to_string(i));
        }
      };
      EXPECT_EQ(failureOf([&] { team.forEach(done.size(), failing); }), "task 7");
      // the tasks before it ran, as in a loop
      for (std::size_t i = 0; i < 7; ++i) {
        EXPECT_EQ(done[i], 1);
      }
    }
    std::atomic<int> count = 0;
    team.forEach(4, [&](std::size_t) { ++count; });
    EXPECT_EQ(count, 4);
  }
}

TEST(WorkerTeam, AfterAFailureNoTaskBegins) {
  WorkerTeam team(2);
  // more tasks than anybody makes before the failure is known
  constexpr std::size_t kEndless = 2'000'000'000;
  std::atomic<std::size_t> last = 0;
  const auto failing = [&](std::size_t i) {
    last = i;
    if (i == 0) {
      throw std::runtime_error("task 0");
    }
  };
  EXPECT_EQ(failureOf([&] { team.forEach(kEndless, failing); }), "task 0");
  EXPECT_LT(last, kEndless - 1);
}

TEST(WorkerTeam, OfTwoTasksThatFailAtOnceTheLowerReachesTheCaller) {
  WorkerTeam team(2);
  for (std::size_t round = 0; round < 200; ++round) {
    // neither fails before both have started; now the one, now the other fails a moment later
    std::latch areBothStarted(2);
    const auto failing = [&](std::size_t i) {
      areBothStarted.arrive_and_wait();
      for (std::size_t k = 0; k < 100 * ((i + round) % 2); ++k) {
        std::this_thread::yield();
      }
      throw std::runtime_error("task " + std::to_string(i));
    };
    EXPECT_EQ(failureOf([&] { team.forEach(2, failing); }), "task 0");
  }
}

}  // namespace
}  // namespace espalier::worker_team_test
