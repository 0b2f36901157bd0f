#include "environment/base/replies.h"

#include <algorithm>

namespace espalier::environment {

void countAnswers(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies) {
  replies.answeredCount = 0;
  for (std::size_t query = 0; query < queries.size(); ++query) {
    const auto begin = replies.isSet.begin() + static_cast<std::ptrdiff_t>(queries.parameterOffset[query]);
    const auto end = replies.isSet.begin() + static_cast<std::ptrdiff_t>(queries.parameterOffset[query + 1]);
    replies.answeredCount += std::find(begin, end, 1) != end ? 1U : 0U;
  }
}

}  // namespace espalier::environment
