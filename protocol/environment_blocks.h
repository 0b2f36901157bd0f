#pragma once

#include "protocol/json_tree.h"
#include "protocol/messages.h"

namespace espalier::protocol {

// Queries and replies in binary blocks. For protocol's own decoders: what is wrong is thrown as FieldFailure.

/// The blocks of environment.step; `params` has the list `symbols`.
[[nodiscard]] QueryColumns readQueryBlocks(const Field& params, const Payload& payload);
/// The blocks of its answer. Without a block `id` there is a row for each of the `queryCount` queries, or none.
[[nodiscard]] ReplyColumns readReplyBlocks(const Payload& payload, std::size_t queryCount);

}  // namespace espalier::protocol
