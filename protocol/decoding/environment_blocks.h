#pragma once

#include "protocol/decoding/member.h"
#include "protocol/messages.h"
#include "protocol/payload.h"

namespace espalier::protocol {

// Queries and replies in binary blocks, for protocol's own decoders. A mistake is thrown as MemberFailure.

/// The blocks of environment.step; `params` has the list `symbols`.
[[nodiscard]] QueryColumns readQueryBlocks(const Member& params, const Payload& payload);
/// The blocks of its answer. Without a block `id` there is a row for each of the `queryCount` queries, or none.
[[nodiscard]] ReplyColumns readReplyBlocks(const Payload& payload, std::size_t queryCount);

}  // namespace espalier::protocol
