#include "engine/turtle/query_batches.h"

#include <gtest/gtest.h>

#include <vector>

namespace espalier::turtle::query_batches_test {
namespace {

// four queries with parameters (1, 7), (2), (3), (4, 8, 9) and following modules with none to two parameters
QueryBatch mixedQueries() {
  QueryBatch batch;
  batch.plant = {0, 0, 0, 0};
  batch.module = {0, 1, 2, 3};
  batch.symbol = {0, 1, 0, 1};
  batch.isTransient = {0, 0, 0, 0};
  batch.parameterOffset = {0, 2, 3, 4, 7};
  batch.parameters = {1, 7, 2, 3, 4, 8, 9};
  batch.following = {5, 6, 7, 8};
  batch.followingPair = {'@', 0, '~', 0};
  batch.followingOffset = {0, 1, 1, 3, 4};
  batch.followingParameters = {10, 30, 31, 40};
  return batch;
}

TEST(QueryBatches, SelectionAndMergeLoseNothing) {
  const QueryBatch whole = mixedQueries();
  const std::vector<std::size_t> chosen{3, 0};
  QueryBatch part;
  selectQueries(whole, chosen, 1, part);
  EXPECT_EQ(part.module, (std::vector<std::uint64_t>{3, 0}));
  EXPECT_EQ(part.parameters, (std::vector<double>{8, 9, 7}));
  EXPECT_EQ(part.parameterOffset, (std::vector<std::uint64_t>{0, 2, 3}));
  EXPECT_EQ(part.following, (std::vector<core::SymbolId>{8, 5}));
  EXPECT_EQ(part.followingPair, (std::vector<char>{0, '@'}));
  EXPECT_EQ(part.followingParameters, (std::vector<double>{40, 10}));
  EXPECT_EQ(part.followingOffset, (std::vector<std::uint64_t>{0, 1, 2}));
  ReplyBatch partReplies;
  partReplies.prepare(part);
  partReplies.set(part, 0, 1, -9);
  partReplies.set(part, 1, 0, -7);
  partReplies.answeredCount = 2;
  ReplyBatch replies;
  replies.prepare(whole);
  mergeReplies(whole, chosen, 1, part, partReplies, replies);
  EXPECT_EQ(replies.values, (std::vector<double>{0, -7, 0, 0, 0, 0, -9}));
  EXPECT_EQ(replies.isSet, (std::vector<std::uint8_t>{0, 1, 0, 0, 0, 0, 1}));
  EXPECT_EQ(replies.answeredCount, 2U);
}

TEST(QueryBatches, ColumnsThatNobodyNeedsStayEmpty) {
  QueryBatch part;
  selectQueries(mixedQueries(), std::vector<std::size_t>{1}, 0, part);
  EXPECT_TRUE(part.position.empty());
  EXPECT_TRUE(part.width.empty());
  EXPECT_EQ(part.parameters, std::vector<double>{2});
}

}  // namespace
}  // namespace espalier::turtle::query_batches_test
