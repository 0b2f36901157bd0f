#include <algorithm>

#include "protocol/codec.h"
#include "protocol/version.h"
#include "server/server_core.h"
#include "server/session/methods.h"
#include "server/session/session.h"

namespace espalier::server {

namespace methods {

void ping(const Request& request, protocol::NoParams) {
  request.session.respond(request.id, "{}");
}

void serverStatus(const Request& request, protocol::NoParams) {
  ServerCore& core = request.session.core();
  const auto runners = core.all();
  const auto running =
      std::count_if(runners.begin(), runners.end(), [](const auto& runner) { return runner->information().isRunning; });
  protocol::JsonWriter result;
  result.beginObject().key("server").text("espalier " + std::string(protocol::kProgramVersion));
  result.key("protocol").integer(protocol::kProtocolVersion).key("sessions").integer(core.sessionCount.load());
  result.key("simulations").integer(std::uint64_t{runners.size()});
  result.key("running").integer(static_cast<std::uint64_t>(running));
  result.key("workers").integer(core.pool().workers()).key("saving").boolean(core.store().isKept());
  result.key("offered").texts(core.offered().names());
  const auto seconds =
      std::chrono::duration_cast<std::chrono::seconds>(std::chrono::steady_clock::now() - core.started());
  result.key("uptimeSeconds").integer(static_cast<std::uint64_t>(seconds.count()));
  result.key("damaged").integer(std::uint64_t{core.damaged().size()});
  std::uint64_t stringBytes = 0;
  std::uint64_t streamBytes = 0;
  for (const auto& runner : runners) {
    stringBytes += runner->stringBytes();
    streamBytes += runner->streamBytes();
  }
  result.key("memory").beginObject().key("stringBytes").integer(stringBytes).key("streamBytes").integer(streamBytes);
  result.key("outboxBytes").integer(core.outboxBytes()).key("storeBytes").integer(core.store().bytes()).endObject();
  request.session.respond(request.id, result.endObject().view());
}

void cancel(const Request& request, protocol::CancelParams params) {
  request.session.cancelRequest(params.request);
  if (!request.isNotification) {
    request.session.respond(request.id, "{}");
  }
}

}  // namespace methods
}  // namespace espalier::server
