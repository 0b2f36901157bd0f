#include "engine/core/index_set.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace espalier::core::index_set_test {
namespace {

TEST(IndexSet, FindsTheNextMember) {
  // more than a word of the summary, and a last word that is not full
  constexpr std::uint32_t kCount = 10'001;
  IndexSet set(kCount);
  std::set<std::uint32_t> expected;
  EXPECT_EQ(set.from(0), IndexSet::kNone);
  std::mt19937_64 random(5);  // NOLINT(cert-msc51-cpp): the same numbers in each run
  for (int round = 0; round < 20'000; ++round) {
    const auto number = static_cast<std::uint32_t>(random() % kCount);
    // few members in the second half of the rounds, so that whole words are empty
    if (random() % 10 < (round < 10'000 ? 6U : 1U)) {
      set.insert(number);
      expected.insert(number);
    } else {
      set.erase(number);
      expected.erase(number);
    }
    const auto from = static_cast<std::uint32_t>(random() % kCount);
    const auto next = expected.lower_bound(from);
    ASSERT_EQ(set.from(from), next == expected.end() ? IndexSet::kNone : *next) << round;
  }
  for (const std::uint32_t number : expected) {
    set.erase(number);
  }
  EXPECT_EQ(set.from(0), IndexSet::kNone);
  set.insert(kCount - 1);
  EXPECT_EQ(set.from(0), kCount - 1);
}

}  // namespace
}  // namespace espalier::core::index_set_test
