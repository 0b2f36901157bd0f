#pragma once

#include "engine/turtle/environment_process.h"

namespace espalier::environment {

/// Sets `answeredCount` to the number of queries with at least one value set; a process calls it last in step().
/// O(parameters).
void countAnswers(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies);

}  // namespace espalier::environment
