#include "environment/registry.h"
#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "server/remote/translation/translate.h"
#include "server/server_core.h"
#include "server/session/request_work.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

/// Name, description and schema of each, as a JSON array.
std::string describeBuiltInEnvironments() {
  protocol::JsonWriter list;
  list.beginArray();
  for (const std::string& name : environment::processNames()) {
    list.beginObject().key("name").text(name);
    if (const auto process = environment::makeProcess(name, "")) {
      list.key("description").raw(protocol::encode(toDescribeResult((*process)->describe())));
    }
    // a schema is laid out over lines for people; a message is one line
    const std::string schema = "{\"schema\":" + environment::configurationSchema(name) + "}";
    list.key("schema").raw(protocol::memberOf(schema, "schema").value_or("{}")).endObject();
  }
  return list.endArray().take();
}

}  // namespace

namespace methods {

void environmentList(const Request& request, protocol::NoParams) {
  listOnWorker(request, [](const Request& self) {
    ServerCore& core = self.session.core();
    protocol::JsonWriter result;
    result.beginObject().key("environments").raw(core.builtInEnvironments(&describeBuiltInEnvironments));
    result.key("offered").texts(core.offered().names());
    self.session.respond(self.id, result.endObject().view());
  });
}

void environmentOffer(const Request& request, protocol::OfferParams params) {
  Session& session = request.session;
  OfferedEnvironments& offered = session.core().offered();
  if (const std::uint64_t bound = session.core().limits().offersPerSession; offered.count(&session) >= bound) {
    session.respondError(request.id, protocol::limitError("offersPerSession", bound + 1, bound,
                                                          "Offer fewer environments, or use another connection."));
    return;
  }
  // the answer is queued before a simulation can find the offer and ask
  const auto answer = [&] {
    protocol::JsonWriter result;
    result.beginObject().key("name").text(params.name).endObject();
    session.respond(request.id, result.view());
  };
  const auto outcome = offered.offer(params.name, session.shared_from_this(), answer);
  if (outcome == OfferedEnvironments::Outcome::Taken) {
    session.respondError(request.id,
                         {protocol::ErrorCode::OfferTaken,
                          "Another connection offers '" + params.name +
                              "'. Offer another name, use the same token, or wait until that connection is closed.",
                          {}});
    return;
  }
  session.core().log().info(
      "offers environment '" + params.name + "'" +
          (outcome == OfferedEnvironments::Outcome::Replaced ? ", in place of an older offer" : ""),
      {.session = session.id(), .token = session.tokenName()});
}

}  // namespace methods
}  // namespace espalier::server
