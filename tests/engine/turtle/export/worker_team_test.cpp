#include "engine/turtle/export/worker_team.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

namespace espalier::turtle {
namespace {

TEST(WorkerTeam, DoesEachTaskOnceForAnyNumberOfThreads) {
  for (const unsigned threads : {1U, 2U, 5U}) {
    WorkerTeam team(threads);
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, std::size_t{1000}}) {
      std::vector<std::atomic<int>> done(count);
      team.run(count, [&](std::size_t i) { ++done[i]; });
      for (const std::atomic<int>& times : done) {
        ASSERT_EQ(times, 1);
      }
    }
  }
}

TEST(WorkerTeam, AFailureOfATaskReachesTheCallerAfterTheOtherTasks) {
  for (const unsigned threads : {1U, 3U}) {
    WorkerTeam team(threads);
    EXPECT_THROW(team.run(10,
                          [](std::size_t i) {
                            if (i == 9) {
                              throw std::runtime_error("nine");
                            }
                          }),
                 std::runtime_error);
    std::atomic<int> done = 0;
    team.run(4, [&](std::size_t) { ++done; });
    EXPECT_EQ(done, 4);
  }
}

}  // namespace
}  // namespace espalier::turtle
