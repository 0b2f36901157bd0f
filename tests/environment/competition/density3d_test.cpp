#include <gtest/gtest.h>

#include "tests/environment/query_builder.h"

namespace espalier::environment::density3d_test {
namespace {

constexpr const char* kBox = R"({"range":[10,10,10],"position":[-5,-5,-5],"gridSize":[10,10,10]})";
constexpr const char* kPublished =
    R"({"range":[10,10,10],"position":[-5,-5,-5],"gridSize":[10,10,10],"order":"published"})";

QueryBuilder fiveQueries() {
  QueryBuilder builder;
  builder.add({0.5, 0.5, 0.5}, {1}).add({0.6, 0.4, 0.5}, {2}).add({3.5, 0.5, 0.5}, {5}).add({20, 0, 0}, {7});
  builder.add({-0.5, 0.5, 0.5}, {0.25});
  return builder;
}

TEST(Density3d, PublishedOrderReadsTheSumSoFarAsCase186) {
  const auto process = openProcess("density3d", kPublished);
  QueryBuilder builder = fiveQueries();
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{1, 3, 5, 0, 0}));
}

TEST(Density3d, TheDefaultReadsTheSumAfterTheWholeStep) {
  const auto process = openProcess("density3d", kBox);
  QueryBuilder builder = fiveQueries();
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{3, 3, 5, 0, 0}));
  QueryBuilder reversed;
  reversed.add({0.6, 0.4, 0.5}, {2}).add({0.5, 0.5, 0.5}, {1});
  EXPECT_EQ(firstValues(answersOf(*openProcess("density3d", kBox), reversed.batch())), (std::vector<double>{3, 3}));
}

TEST(Density3d, CountsPersistUntilItIsOpenedAgain) {
  const auto process = openProcess("density3d", kBox);
  QueryBuilder builder = fiveQueries();
  answersOf(*process, builder.batch());
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch()))[0], 6.0);
  ASSERT_FALSE(process->open({}));
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch()))[0], 3.0);
}

TEST(Density3d, ContributionsAreTruncatedTowardsZero) {
  const auto process = openProcess("density3d", kBox);
  QueryBuilder builder;
  builder.add({0.5, 0.5, 0.5}, {1.99}).add({1.5, 0.5, 0.5}, {-1.99}).add({2.5, 0.5, 0.5}, {1e300});
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{1, -1, 1099511627776.0}));
}

TEST(Density3d, TheBoxIncludesItsLowBordersAndExcludesItsHighOnes) {
  const auto process = openProcess("density3d", kBox);
  QueryBuilder builder;
  builder.add({-5, -5, -5}, {1}).add({5, 0, 0}, {1}).add({0, 5, 0}, {1}).add({0, 0, -5.001}, {1});
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{1, 0, 0, 0}));
}

TEST(Density3d, AnOctreeLevelGivesPowersOfTwo) {
  // level 2 over [0, 8): voxels of side 2
  const auto process = openProcess("density3d", R"({"range":[8,8,8],"octreeLevel":2})");
  QueryBuilder builder;
  builder.add({0, 0, 0}, {1}).add({1.9, 1.9, 1.9}, {1}).add({2, 0, 0}, {1});
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{2, 2, 1}));
}

TEST(Density3d, NumbersOfVoxelsAreWhole) {
  const std::string text = errorsOf(makeProcess("density3d", R"({"gridSize":[1,2.5,1]})"));
  EXPECT_EQ(text.substr(0, text.find('\n')),
            "error: environment process 'density3d': 'gridSize[1]' must be a whole number, found the number 2.5");
}

TEST(Density3d, ARestoredStateContinuesAndADamagedOneChangesNothing) {
  const auto process = openProcess("density3d", kPublished);
  QueryBuilder builder = fiveQueries();
  answersOf(*process, builder.batch());
  const std::string state = process->save();
  const auto other = openProcess("density3d", kPublished);
  ASSERT_FALSE(other->restore(state));
  EXPECT_EQ(other->save(), state);
  const auto error = other->restore(std::string_view(state).substr(1));
  ASSERT_TRUE(error);
  EXPECT_EQ(error->message, "The saved state of environment 'density3d' is damaged. Use a snapshot that is complete.");
  EXPECT_EQ(other->save(), state);
  EXPECT_EQ(answersOf(*other, builder.batch()), answersOf(*process, builder.batch()));
}

TEST(Density3d, AFineBoxCountsAsACoarseOne) {
  // 2^60 voxels are kept in a table, 2^9 in an array: with all amounts in the middle of a coarse voxel the sums agree
  const auto fine = openProcess("density3d", R"({"octreeLevel":20})");
  const auto coarse = openProcess("density3d", R"({"octreeLevel":3})");
  for (int step = 0; step < 3; ++step) {
    QueryBuilder builder;
    for (int i = 0; i < 500; ++i) {
      const auto place = [](int k) { return (k % 8 + 0.5) / 8.0; };
      builder.add({place(i), place(i / 3), place(i / 7)}, {static_cast<double>(i % 5 - 2)});
    }
    ASSERT_EQ(answersOf(*fine, builder.batch()), answersOf(*coarse, builder.batch()));
  }
  // sums that are 0 again leave no trace
  const std::string empty = openProcess("density3d", R"({"octreeLevel":3})")->save();
  const auto process = openProcess("density3d", R"({"octreeLevel":3})");
  answersOf(*process, QueryBuilder().add({0.5, 0.5, 0.5}, {3}).batch());
  EXPECT_NE(process->save(), empty);
  answersOf(*process, QueryBuilder().add({0.5, 0.5, 0.5}, {-3}).batch());
  EXPECT_EQ(process->save(), empty);
}

TEST(Density3d, AStateOfAnotherBoxIsRefused) {
  const auto large = openProcess("density3d", R"({"octreeLevel":4})");
  answersOf(*large, QueryBuilder().add({0.9, 0.9, 0.9}, {3}).batch());
  const auto error = openProcess("density3d", R"({"octreeLevel":1})")->restore(large->save());
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(error->message.find("saved state"), std::string::npos);
}

}  // namespace
}  // namespace espalier::environment::density3d_test
