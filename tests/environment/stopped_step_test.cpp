// A process whose step is given up, because the caller left or the server ends, is as before the step.

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "tests/environment/candidates.h"
#include "tests/environment/query_builder.h"
#include "tests/environment/stops_after.h"

namespace espalier::environment::stopped_step_test {
namespace {

class StoppedStep : public testing::TestWithParam<Candidate> {};

// gives the step up after its first look at the meter, after its second, and so on, until it is made
TEST_P(StoppedStep, LeavesTheStateAsItWas) {
  // their steps can cost the square of what a model asks, or what a number of the configuration says
  const std::set<std::string> stoppable{"arvo",     "attractors", "chiba",  "colonization", "crowding", "light-voxels",
                                        "ornament", "obstacles",  "shadow", "soil-water",   "takenaka", "xylem"};
  std::mt19937_64 random(5);
  const auto process = openProcess(GetParam().name, GetParam().configuration);
  const auto undisturbed = openProcess(GetParam().name, GetParam().configuration);
  ASSERT_TRUE(process && undisturbed);
  int stopped = 0;
  for (std::uint64_t step = 0; step < 2; ++step) {
    const turtle::QueryBatch queries = queriesOf(GetParam(), step, random);
    const std::string before = process->save();
    turtle::ReplyBatch replies;
    bool isStopped = true;
    for (int asked = 0; isStopped; asked += 1 + asked / 50) {
      replies.prepare(queries);
      isStopped = false;
      StopsAfter meter(asked);
      try {
        const core::WorkMeter::Scope scope(&meter);
        // a process of processes says it in words
        isStopped = process->step(queries, replies).has_value();
      } catch (const core::WorkStopped&) {
        isStopped = true;
      }
      ASSERT_TRUE(process->save() == before || !isStopped) << "look " << asked << " of step " << step;
      stopped += isStopped ? 1 : 0;
    }
    turtle::ReplyBatch expected;
    expected.prepare(queries);
    ASSERT_FALSE(undisturbed->step(queries, expected).has_value());
    EXPECT_EQ(replies.values, expected.values);
    EXPECT_EQ(replies.isSet, expected.isSet);
    EXPECT_TRUE(process->save() == undisturbed->save());
  }
  EXPECT_TRUE(stopped > 0 || !stoppable.contains(GetParam().name));
}

INSTANTIATE_TEST_SUITE_P(Processes, StoppedStep, testing::ValuesIn(candidates()), nameOf);

}  // namespace
}  // namespace espalier::environment::stopped_step_test
