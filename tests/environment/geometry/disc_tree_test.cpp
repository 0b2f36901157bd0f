#include "environment/geometry/disc_tree.h"

#include <gtest/gtest.h>

#include <random>

namespace espalier::environment::disc_tree_test {
namespace {

TEST(DiscTree, FindsOverlapsAsPairByPairAlsoAfterRemovals) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> place(-5, 5);
  std::uniform_int_distribution<std::uint32_t> rank(0, 9);
  std::vector<Disc> discs;
  for (int i = 0; i < 300; ++i) {
    discs.push_back({{place(random), place(random), place(random)}, 0.1 * rank(random), rank(random)});
  }
  DiscTree tree(discs);
  std::vector<bool> isIn(discs.size(), true);
  for (int round = 0; round < 4; ++round) {
    for (std::size_t i = 0; i < discs.size(); ++i) {
      for (const std::uint32_t least : {0U, 5U, 10U}) {
        bool expected = false;
        for (std::size_t j = 0; j < discs.size(); ++j) {
          const core::Vec3 d = discs[j].centre - discs[i].centre;
          const double sum = discs[i].radius + discs[j].radius;
          expected = expected || (j != i && isIn[j] && discs[j].rank >= least && core::dot(d, d) <= sum * sum);
        }
        EXPECT_EQ(tree.isOverlapped(i, least, discsOverlap), expected) << i << " " << least;
      }
    }
    for (std::size_t i = static_cast<std::size_t>(round); i < discs.size(); i += 5) {
      tree.remove(i);
      isIn[i] = false;
    }
  }
}

TEST(DiscTree, TouchingDiscsOverlapAndADiscNeverOverlapsItself) {
  const DiscTree tree({{{0, 0, 0}, 1, 0}, {{3, 0, 0}, 2, 0}, {{9, 0, 0}, 1, 0}});
  EXPECT_TRUE(tree.isOverlapped(0, 0, discsOverlap));
  EXPECT_FALSE(tree.isOverlapped(2, 0, discsOverlap));
}

}  // namespace
}  // namespace espalier::environment::disc_tree_test
