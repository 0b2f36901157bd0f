#pragma once

#include "protocol/envelope.h"

namespace espalier::server {

class Session;

/// Carries out one request or notification of a greeted session. Quick ones are answered at once, the rest by a worker
/// later; each request gets exactly one answer. Network thread.
void dispatch(Session& session, const protocol::Message& message);

}  // namespace espalier::server
