#include "server/session/methods.h"

#include <algorithm>
#include <array>

#include "engine/core/diagnostic.h"
#include "protocol/codec.h"
#include "protocol/methods.h"
#include "server/server_core.h"
#include "server/session/request_work.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

using protocol::ErrorCode;

/// The needs of a handler: the column NEEDS of methods.def.
enum class Needs : std::uint8_t { Nothing, Simulation };

/// The log names each change and the session that asked for it, but no single steps and nothing that only reads.
void noteDeed(Session& session, const std::string& method, std::string_view simulation, protocol::Role role) {
  const LogSubject subject{.session = session.id(), .simulation = simulation, .token = session.tokenName()};
  const bool isChange = role == protocol::Role::Controller || role == protocol::Role::Environment;
  if (isChange && method != "simulation.step" && method != "model.check") {
    session.core().log().info(method, subject);
  } else {
    session.core().log().debug(method, subject);
  }
}

/// Decodes the params, finds the simulation where it is needed, and calls the handler. Errors are answered.
template <auto decode, auto handle, Needs needs, protocol::Role role>
void handleMessage(Session& session, const protocol::Message& message) {
  const Request request{session, message.id, message.kind == protocol::Message::Kind::Notification};
  protocol::Payload payload = message.payload;
  std::vector<std::string> unknown;
  payload.listUnknownMembers(unknown);
  auto params = decode(payload);
  if (!params) {
    session.respondError(message.id, params.error());
    return;
  }
  if (!unknown.empty() && !request.isNotification) {
    if (session.isStrict()) {
      const std::size_t colon = unknown.front().find(": ");
      session.respondError(message.id,
                           protocol::memberError(unknown.front().substr(0, colon), unknown.front().substr(colon + 2)));
      return;
    }
    session.warn(message.id, std::move(unknown));
  }
  if constexpr (requires { params->simulation; }) {
    noteDeed(session, message.method, params->simulation, role);
  } else {
    noteDeed(session, message.method, {}, role);
  }
  if constexpr (needs == Needs::Simulation) {
    if (auto runner = findRunner(request, params->simulation)) {
      handle(request, std::move(runner), std::move(*params));
    }
  } else {
    handle(request, std::move(*params));
  }
}

struct Row {
  std::string_view name;
  protocol::Role role;
  bool canBeNotification;
  void (*handle)(Session&, const protocol::Message&);
};

constexpr std::array kRows{
#define ESPALIER_SHARED_METHOD(NAME, PARAMS, HANDLER, NEEDS, ROLE, SUMMARY) \
  Row{NAME, protocol::Role::ROLE, false,                                    \
      &handleMessage<&protocol::decode##PARAMS, &methods::HANDLER, Needs::NEEDS, protocol::Role::ROLE>},
#define ESPALIER_SERVER_METHOD(NAME, PARAMS, HANDLER, NEEDS, ROLE, SUMMARY) \
  Row{NAME, protocol::Role::ROLE, false,                                    \
      &handleMessage<&protocol::decode##PARAMS, &methods::HANDLER, Needs::NEEDS, protocol::Role::ROLE>},
#define ESPALIER_SERVER_METHOD_OR_NOTIFICATION(NAME, PARAMS, HANDLER, NEEDS, ROLE, SUMMARY) \
  Row{NAME, protocol::Role::ROLE, true,                                                     \
      &handleMessage<&protocol::decode##PARAMS, &methods::HANDLER, Needs::NEEDS, protocol::Role::ROLE>},
#include "protocol/methods.def"
};

protocol::Error roleError(const Session& session, const Row& row) {
  const std::string role(protocol::nameOf(row.role));
  protocol::JsonWriter data;
  data.beginObject().key("role").text(role).key("roles").texts(session.roles().names()).endObject();
  return {ErrorCode::Unauthorised,
          std::string(row.name) + " needs the role " + role + ", and this connection has " + session.roles().text() +
              ". Connect with a token that has the role: the operator of the server makes one with `espalier token new "
              "NAME --role " +
              role + "`. A program that lists roles in its hello must list this one.",
          data.take()};
}

std::vector<std::string_view> methodNames() {
  std::vector<std::string_view> names{"hello"};
  for (const Row& row : kRows) {
    names.push_back(row.name);
  }
  return names;
}

}  // namespace

void dispatch(Session& session, const protocol::Message& message) {
  const bool isRequest = message.kind == protocol::Message::Kind::Request;
  const auto row =
      std::find_if(kRows.begin(), kRows.end(), [&](const Row& candidate) { return candidate.name == message.method; });
  if (row == kRows.end()) {
    if (isRequest) {
      session.respondError(message.id, {ErrorCode::UnknownMethod,
                                        "There is no method '" + message.method + "'. " +
                                            core::suggestName(message.method, methodNames()),
                                        {}});
    }
    return;
  }
  if (!session.roles().allows(row->role)) {
    if (isRequest) {
      session.respondError(message.id, roleError(session, *row));
    }
    return;
  }
  if (!isRequest && !row->canBeNotification) {
    // its outcome would have no receiver
    session.core().log().debug("sent " + message.method + " without an id; it is ignored", {.session = session.id()});
    return;
  }
  if (isRequest && session.core().isShuttingDown()) {
    session.respondError(message.id,
                         {ErrorCode::ShuttingDown, "The server is shutting down. Ask again when it is back.", {}});
    return;
  }
  row->handle(session, message);
}

}  // namespace espalier::server
