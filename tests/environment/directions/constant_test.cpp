#include <gtest/gtest.h>

#include "tests/environment/query_builder.h"

namespace espalier::environment::constant_test {
namespace {

TEST(Constant, FillsAsManyParametersAsTheModuleHas) {
  const auto process = openProcess("constant", R"({"values":[0.5,2]})");
  QueryBuilder builder;
  builder.add({}, {9}).add({}, {9, 9, 9}).add({}, {});
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  ASSERT_FALSE(process->step(builder.batch(), replies));
  const ReplyTable table = tableOf(builder.batch(), replies);
  EXPECT_EQ(table[0], (std::vector<std::optional<double>>{0.5}));
  EXPECT_EQ(table[1], (std::vector<std::optional<double>>{0.5, 2.0, std::nullopt}));
  EXPECT_EQ(replies.answeredCount, 2U);
  EXPECT_EQ(replies.surplusCount, 0U);
}

TEST(Constant, AnswersOneByDefault) {
  const auto process = openProcess("constant", "");
  QueryBuilder builder;
  builder.add({}, {9});
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{1}));
}

TEST(Constant, AnEmptyListAnswersNothing) {
  const auto process = openProcess("constant", R"({"values":[]})");
  QueryBuilder builder;
  builder.add({}, {9});
  EXPECT_EQ(answersOf(*process, builder.batch())[0][0], std::nullopt);
}

}  // namespace
}  // namespace espalier::environment::constant_test
