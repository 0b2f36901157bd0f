#include "engine/derivation/worker_team.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

namespace espalier {
namespace {

using derivation::WorkerTeam;

TEST(WorkerTeam, EveryWorkerRunsOncePerRound) {
  for (const unsigned size : {1U, 2U, 5U}) {
    WorkerTeam team(size);
    EXPECT_EQ(team.size(), size);
    std::vector<std::atomic<int>> counts(size);
    for (int round = 1; round <= 20; ++round) {
      team.run([&](unsigned worker) { ++counts[worker]; });
      for (const std::atomic<int>& count : counts) {
        EXPECT_EQ(count.load(), round);
      }
    }
  }
}

TEST(WorkerTeam, TheFirstExceptionComesBack) {
  WorkerTeam team(3);
  const auto failing = [](unsigned worker) {
    if (worker > 0) {
      throw std::runtime_error("worker " + std::to_string(worker));
    }
  };
  try {
    team.run(failing);
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "worker 1");
  }
  // and the team still works
  std::atomic<int> count = 0;
  team.run([&](unsigned) { ++count; });
  EXPECT_EQ(count.load(), 3);
}

}  // namespace
}  // namespace espalier
