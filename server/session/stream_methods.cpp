#include "protocol/codec.h"
#include "server/server_core.h"
#include "server/session/request_work.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

using protocol::ErrorCode;

/// The reason why this session cannot have the stream, or nothing.
std::optional<protocol::Error> problemOf(const protocol::StreamOpenParams& params, const Session& session) {
  if (params.isInBlocks && !session.areBlocksAgreed()) {
    return protocol::Error{ErrorCode::Capability,
                           "params.bin: binary blocks were not agreed on. Name the capability 'bin' in "
                           "hello, or leave bin out.",
                           {}};
  }
  if (params.what == "geometry" && params.format == "glb" && !params.isInBlocks) {
    return protocol::memberError("params.bin",
                                 "geometry as a file comes in binary blocks; say \"bin\": true, or "
                                 "\"format\": \"columns\" for tables");
  }
  return std::nullopt;
}

/// Answers with the stream's name, then sends the first frame.
std::shared_ptr<Command> makeOpenCommand(const Request& request, std::shared_ptr<Stream> stream) {
  auto command = std::make_shared<Command>();
  command->owner = request.session.id();
  const std::weak_ptr<Session> weak = request.session.weak_from_this();
  command->advance = [weak, id = request.id, stream](SimulationRunner& runner, Command& self) {
    if (const auto owner = weak.lock()) {
      runner.publishEndOf(self);
      protocol::JsonWriter result;
      result.beginObject().key("stream").text(stream->id());
      result.key("step").integer(runner.hosted().simulation().completedSteps()).endObject();
      owner->respond(id, result.view());
      runner.addStream(stream);
    }
    return false;
  };
  command->fail = [weak, id = request.id, stream](const protocol::Error& error) {
    if (const auto owner = weak.lock()) {
      (void)owner->closeStream(stream->id());
      owner->respondError(id, error);
    }
  };
  return command;
}

}  // namespace

namespace methods {

void streamOpen(const Request& request, protocol::StreamOpenParams params) {
  Session& session = request.session;
  if (const auto problem = problemOf(params, session)) {
    session.respondError(request.id, *problem);
    return;
  }
  const auto runner = findRunner(request, params.simulation);
  if (runner == nullptr) {
    return;
  }
  auto stream = session.openStream(std::move(params), *runner);
  if (!stream) {
    session.respondError(request.id, stream.error());
    return;
  }
  session.submit(request.id, runner, makeOpenCommand(request, std::move(*stream)));
}

void streamAck(const Request& request, protocol::StreamAckParams params) {
  Session& session = request.session;
  if (const auto stream = session.findStream(params.stream)) {
    stream->acknowledge(params);
    session.onDrained();
  }
  if (!request.isNotification) {
    session.respond(request.id, "{}");
  }
}

void streamClose(const Request& request, protocol::StreamCloseParams params) {
  Session& session = request.session;
  if (session.closeStream(params.stream)) {
    session.respond(request.id, "{}");
  } else {
    session.respondError(request.id,
                         {ErrorCode::NotFound,
                          "This session has no stream '" + params.stream + "'. The answer to stream.open names it.",
                          {}});
  }
}

}  // namespace methods
}  // namespace espalier::server
