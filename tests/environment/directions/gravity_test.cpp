#include <gtest/gtest.h>

#include "tests/environment/query_builder.h"

namespace espalier::environment::gravity_test {
namespace {

TEST(Gravity, DrawsAgainstTheWorldsUp) {
  turtle::EnvironmentContext context;
  context.world.up = {0, 0, 5};
  const auto process = openProcess("gravity", R"({"strength":2})", context);
  const auto table = answersOf(*process, QueryBuilder().add({1, 2, 3}, {7, 7, 7, 7}).add({}, {1, 1}).batch());
  EXPECT_EQ(table[0], (std::vector<std::optional<double>>{0.0, 0.0, -2.0, std::nullopt}));
  EXPECT_EQ(table[1], (std::vector<std::optional<double>>{0.0, 0.0}));
}

TEST(Gravity, DrawsInAGivenDirection) {
  const auto process = openProcess("gravity", R"({"direction":[0,3,4]})");
  EXPECT_EQ(answersOf(*process, QueryBuilder().add({}, {0, 0, 0}).batch())[0],
            (std::vector<std::optional<double>>{0.0, 0.6, 0.8}));
}

TEST(Gravity, RefusesADirectionOfNoLength) {
  EXPECT_EQ(errorsOf(makeProcess("gravity", R"({"direction":[0,0,0]})")),
            "error: environment process 'gravity': 'direction' must be three numbers that are not all 0\n"
            "   hint: write it as [x, y, z], or leave it out");
}

}  // namespace
}  // namespace espalier::environment::gravity_test
