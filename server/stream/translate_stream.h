#pragma once

#include <memory>

#include "protocol/messages.h"
#include "server/stream/query_recorder.h"
#include "server/stream/turtle_frame.h"

namespace espalier::server {

// The members of a frame that depend on what the stream shows; with translate.h and translate_environment.h the only
// crossing between the protocol's structs and the engine's types. All throw protocol::NonFiniteNumber.

/// All rows: "records":[...], or "count", "symbols" and blocks, as the stream asks.
[[nodiscard]] protocol::Body encodeTurtle(const std::shared_ptr<const TurtleFrame>& frame,
                                          const protocol::StreamOpenParams& params);

/// The difference from a frame before: "count", "kept" and the fresh rows, as records or blocks.
[[nodiscard]] protocol::Body encodeTurtle(TurtleChange change, const protocol::StreamOpenParams& params);

/// The queries of the last step and their answers: "queries" and "replies" as in environment.step, or blocks. Null:
/// there were none.
[[nodiscard]] protocol::Body encodeQueries(const std::shared_ptr<const QueryRecord>& record,
                                           const std::vector<std::string>& symbols,
                                           const protocol::StreamOpenParams& params);

}  // namespace espalier::server
