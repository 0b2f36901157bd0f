#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/turtle/environment_process.h"

namespace espalier::environment {

/// Replaces `part` by the chosen queries of `whole`, in the given order. Parameters before `firstParameter` are left
/// out; a query with fewer has none. Arrays that are empty in `whole` are empty in `part`. O(chosen queries +
/// parameters).
void selectQueries(const turtle::QueryBatch& whole, std::span<const std::size_t> chosen, std::size_t firstParameter,
                   turtle::QueryBatch& part);

/// Copies the replies to a selection back: the inverse of selectQueries.
void mergeReplies(const turtle::QueryBatch& whole, std::span<const std::size_t> chosen, std::size_t firstParameter,
                  const turtle::QueryBatch& part, const turtle::ReplyBatch& partReplies,
                  turtle::ReplyBatch& wholeReplies);

}  // namespace espalier::environment
