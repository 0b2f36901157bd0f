#pragma once

#include <string>
#include <vector>

#include "engine/turtle/environment_process.h"
#include "protocol/messages.h"

namespace espalier::server {

// Queries and replies between the engine and the protocol; with translate.h the only crossing.

/// The params of environment.step, with only the columns that `needs` names. They refer to the batch, except for
/// converted columns. `symbols` are the names by SymbolId. O(n).
[[nodiscard]] protocol::EnvironmentStepParams toStepParams(const std::string& simulation,
                                                           const turtle::QueryBatch& queries,
                                                           const protocol::NeedsRecord& needs,
                                                           const std::vector<std::string>& symbols);

/// The batch of such params. Names that `symbols` lacks are appended to it. A column that `needs` names and the params
/// lack gets the turtle's zero vector or 1.
[[nodiscard]] turtle::QueryBatch toBatch(const protocol::EnvironmentStepParams& params,
                                         const turtle::EnvironmentNeeds& needs, std::vector<std::string>& symbols);

/// The replies as columns: only queries with a value set, trailing unset values left out. They refer to the batches
/// when every value is set.
[[nodiscard]] protocol::ReplyColumns toReplies(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies);

/// Sets the replies in a prepared batch.
void applyReplies(const protocol::ReplyColumns& columns, const turtle::QueryBatch& queries,
                  turtle::ReplyBatch& replies);

}  // namespace espalier::server
