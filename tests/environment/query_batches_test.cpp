#include "environment/query_batches.h"

#include <gtest/gtest.h>

#include "query_builder.h"

namespace espalier::environment {
namespace {

QueryBuilder mixedQueries() {
  QueryBuilder builder;
  builder.add({}, {1, 7}, 0).add({}, {2}, 1).add({}, {3}, 0).add({}, {4, 8, 9}, 1);
  return builder;
}

TEST(QueryBatches, SelectionAndMergeLoseNothing) {
  QueryBuilder builder = mixedQueries();
  turtle::QueryBatch& whole = builder.batch();
  whole.following = {5, 6, 7, 8};
  whole.followingOffset = {0, 1, 1, 3, 4};
  whole.followingParameters = {10, 30, 31, 40};
  const std::vector<std::size_t> chosen{3, 0};
  turtle::QueryBatch part;
  selectQueries(whole, chosen, 1, part);
  EXPECT_EQ(part.module, (std::vector<std::uint64_t>{3, 0}));
  EXPECT_EQ(part.parameters, (std::vector<double>{8, 9, 7}));
  EXPECT_EQ(part.parameterOffset, (std::vector<std::uint64_t>{0, 2, 3}));
  EXPECT_EQ(part.following, (std::vector<core::SymbolId>{8, 5}));
  EXPECT_EQ(part.followingParameters, (std::vector<double>{40, 10}));
  turtle::ReplyBatch partReplies;
  partReplies.prepare(part);
  partReplies.set(part, 0, 1, -9);
  partReplies.set(part, 1, 0, -7);
  partReplies.answeredCount = 2;
  turtle::ReplyBatch replies;
  replies.prepare(whole);
  mergeReplies(whole, chosen, 1, part, partReplies, replies);
  const ReplyTable table = tableOf(whole, replies);
  EXPECT_EQ(table[3], (std::vector<std::optional<double>>{std::nullopt, std::nullopt, -9.0}));
  EXPECT_EQ(table[0], (std::vector<std::optional<double>>{std::nullopt, -7.0}));
  EXPECT_EQ(replies.answeredCount, 2U);
}

}  // namespace
}  // namespace espalier::environment
