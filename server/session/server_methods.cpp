#include <algorithm>

#include "protocol/codec.h"
#include "protocol/version.h"
#include "server/server_core.h"
#include "server/session/methods.h"
#include "server/session/session.h"

namespace espalier::server {

namespace {

void writeMemory(protocol::JsonWriter& result, const Account& account) {
  for (std::size_t kind = 0; kind < kMemoryKindCount; ++kind) {
    result.key(kMemoryKindNames[kind]).integer(account.bytes(static_cast<MemoryKind>(kind)));
  }
  result.key("usedBytes").integer(account.memoryBytes());
  if (account.bounds().memoryBytes != UINT64_MAX) {
    result.key("boundBytes").integer(account.bounds().memoryBytes);
  }
}

}  // namespace

namespace methods {

void ping(const Request& request, protocol::NoParams) {
  request.session.respond(request.id, "{}");
}

void serverStatus(const Request& request, protocol::NoParams) {
  ServerCore& core = request.session.core();
  const auto runners = core.all();
  const auto running =
      std::count_if(runners.begin(), runners.end(), [](const auto& runner) { return runner->isRunning(); });
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
  result.key("durability").text(nameOf(core.store().durability()));
  std::uint64_t streamBytes = 0;
  std::uint64_t passive = 0;
  for (const auto& runner : runners) {
    streamBytes += runner->streamBytes();
    passive += runner->isPassive() ? 1U : 0U;
  }
  result.key("passive").integer(passive);
  core.countDatabase();
  const Account& all = core.accounts().server();
  result.key("memory").beginObject();
  writeMemory(result, all);
  result.key("streamBytes").integer(streamBytes);
  result.key("outboxBytes").integer(core.outboxBytes()).key("storeBytes").integer(core.store().bytes());
  result.key("traceBytes").integer(all.traceRoom().used()).endObject();
  // only its own: what others do is not the peer's business
  const Account& own = request.session.account();
  result.key("account").beginObject().key("name").text(own.owner());
  result.key("simulations").integer(own.simulations()).key("streams").integer(own.streams());
  result.key("cpuSeconds").number(own.cpuSeconds());
  writeMemory(result, own);
  result.key("traceBytes").integer(own.traceRoom().used());
  result.endObject();
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
