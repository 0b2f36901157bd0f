#include "server/running/leader_follower.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <stdexcept>
#include <thread>

namespace espalier::server {
namespace {

using Next = LeaderFollower::Next;

constexpr std::chrono::hours kForEver{1};

TEST(LeaderFollower, HandlesEventsOnOneThreadAtATimeWhateverTheComputationsTake) {
  std::atomic<int> leaders{0};
  int handled = 0;  // without a lock: the sanitizer of threads would see what is not in order
  std::atomic<int> computed{0};
  std::atomic<bool> isTaken{false};
  LeaderFollower* threads = nullptr;
  LeaderFollower::Work work;
  work.handle = [&] {
    EXPECT_EQ(++leaders, 1);
    isTaken = true;
    ++handled;
    const Next next = computed >= 200 ? Next::End : threads->hasFollower() ? Next::Compute : Next::Handle;
    --leaders;
    return next;
  };
  work.compute = [&] {
    const int count = ++computed;  // there is one computation at a time
    isTaken = false;
    // every other one goes on until the other thread leads
    while (count % 2 == 0 && !isTaken) {
      std::this_thread::yield();
    }
  };
  LeaderFollower made(std::move(work), std::chrono::microseconds(100));
  threads = &made;
  made.run();
  EXPECT_GE(handled, 200);
  EXPECT_EQ(computed, 200);
}

TEST(LeaderFollower, WhoBeginsToWaitLetsTheOtherLeadAtOnce) {
  std::latch isAnswered(1);
  LeaderFollower* threads = nullptr;
  bool isComputed = false;
  LeaderFollower::Work work;
  work.handle = [&] {
    if (isComputed) {
      isAnswered.count_down();
      return Next::End;
    }
    return threads->hasFollower() ? Next::Compute : Next::Handle;
  };
  work.compute = [&] {
    isComputed = true;
    threads->giveWay();
    threads->giveWay();
    // by the other thread: it would hang here for an hour
    isAnswered.wait();
  };
  LeaderFollower made(std::move(work), kForEver);
  threads = &made;
  made.run();
  EXPECT_TRUE(isAnswered.try_wait());
}

TEST(LeaderFollower, WakesAFollowerThatHasLongHadNothingToDo) {
  std::atomic<bool> isTaken{false};
  LeaderFollower* threads = nullptr;
  int handled = 0;
  LeaderFollower::Work work;
  work.handle = [&] {
    isTaken = true;
    ++handled;
    // much longer than a follower of this patience goes on looking
    if (handled == 1) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return handled > 100 ? Next::End : threads->hasFollower() ? Next::Compute : Next::Handle;
  };
  work.compute = [&] {
    isTaken = false;
    while (!isTaken) {
      std::this_thread::yield();
    }
  };
  LeaderFollower made(std::move(work), std::chrono::microseconds(1));
  threads = &made;
  made.run();
  EXPECT_EQ(handled, 101);
}

TEST(LeaderFollower, ThrowsWhatWasThrown) {
  LeaderFollower::Work work;
  work.handle = []() -> Next { throw std::runtime_error("a bug"); };
  work.compute = [] {};
  LeaderFollower made(std::move(work), kForEver);
  EXPECT_THROW(made.run(), std::runtime_error);
}

}  // namespace
}  // namespace espalier::server
