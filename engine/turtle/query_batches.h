#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/turtle/environment_process.h"

namespace espalier::turtle {

/// Replaces `part` by the chosen queries of `whole`, in the given order. Parameters before `firstParameter` are left
/// out; a query with fewer has none. Arrays that are empty in `whole` are empty in `part`. O(chosen queries +
/// parameters).
void selectQueries(const QueryBatch& whole, std::span<const std::size_t> chosen, std::size_t firstParameter,
                   QueryBatch& part);

/// Copies the replies to a selection back: the inverse of selectQueries.
void mergeReplies(const QueryBatch& whole, std::span<const std::size_t> chosen, std::size_t firstParameter,
                  const QueryBatch& part, const ReplyBatch& partReplies, ReplyBatch& wholeReplies);

}  // namespace espalier::turtle
