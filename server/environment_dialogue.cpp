#include "server/environment_dialogue.h"

#include <algorithm>

#include "engine/core/hash.h"
#include "protocol/codec.h"
#include "protocol/version.h"
#include "server/translate.h"

namespace espalier::server {
namespace {

protocol::Error failed(const turtle::EnvironmentError& error) {
  protocol::JsonWriter data;
  data.beginObject().key("retryable").boolean(error.isRetryable).endObject();
  return {protocol::ErrorCode::EnvironmentFailed, error.message, data.take()};
}

}  // namespace

std::optional<std::string> EnvironmentDialogue::answer(std::string_view line) {
  auto decoded = protocol::decodeMessage(line);
  if (auto* bad = std::get_if<protocol::BadMessage>(&decoded)) {
    return protocol::encodeError(bad->id, bad->error);
  }
  const auto& message = std::get<protocol::Message>(decoded);
  if (message.kind != protocol::Message::Kind::Request) {
    return std::nullopt;
  }
  const Reply reply = handle(message);
  if (const auto* error = std::get_if<protocol::Error>(&reply)) {
    return protocol::encodeError(message.id, *error);
  }
  return protocol::encodeResult(message.id, std::get<std::string>(reply));
}

EnvironmentDialogue::Reply EnvironmentDialogue::handle(const protocol::Message& request) {
  try {
    if (request.method == "hello") {
      return hello(request.payload);
    }
    if (request.method == "environment.describe") {
      return protocol::encode(toDescribeResult((*factory_)()->describe()));
    }
    if (request.method == "environment.open") {
      return open(request.payload);
    }
    if (request.method == "environment.step") {
      return step(request.payload);
    }
    if (request.method == "environment.save") {
      return save(request.payload);
    }
    if (request.method == "environment.restore") {
      return restore(request.payload);
    }
    if (request.method == "environment.close") {
      return close(request.payload);
    }
  } catch (const protocol::NonFiniteNumber&) {
    return protocol::Error{protocol::ErrorCode::NonFinite,
                           "The environment computed a NaN or infinite value. Check the parameters sent to it.",
                           {}};
  } catch (const std::exception& exception) {
    return protocol::Error{protocol::ErrorCode::Internal,
                           std::string("The environment has a bug: ") + exception.what() + ". Please report it.",
                           {}};
  }
  return protocol::Error{
      protocol::ErrorCode::UnknownMethod,
      "'" + request.method +
          "' is unknown here. An environment answers hello, environment.describe, "
          "environment.open, environment.step, environment.save, environment.restore and environment.close.",
      {}};
}

EnvironmentDialogue::Reply EnvironmentDialogue::hello(const protocol::Payload& payload) const {
  const auto decoded = protocol::decodeHelloParams(payload);
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    return *error;
  }
  const auto& versions = std::get<protocol::HelloParams>(decoded).protocol;
  if (std::find(versions.begin(), versions.end(), protocol::kProtocolVersion) == versions.end()) {
    return protocol::Error{protocol::ErrorCode::Version,
                           "No common protocol version: this environment speaks 1. Use a peer that speaks espalier/1.",
                           {}};
  }
  const protocol::HelloResult result{.protocol = protocol::kProtocolVersion,
                                     .session = "1",
                                     .server = "espalier " + std::string(protocol::kProgramVersion),
                                     .capabilities = {"checkpoint"},
                                     .limits = {}};
  return protocol::encode(result);
}

EnvironmentDialogue::Opened& EnvironmentDialogue::openedFor(const std::string& simulation) {
  Opened& opened = opened_[simulation];
  if (opened.process == nullptr) {
    opened.process = (*factory_)();
    opened.isStateful = opened.process->describe().isStateful;
  }
  return opened;
}

EnvironmentDialogue::Reply EnvironmentDialogue::open(const protocol::Payload& payload) {
  const auto decoded = protocol::decodeOpenParams(payload);
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    return *error;
  }
  const auto& params = std::get<protocol::OpenParams>(decoded);
  if (!params.configurationJson.empty()) {
    return protocol::fieldError("params.configuration",
                                "this environment was configured when it was started (--configuration FILE); leave the "
                                "configuration out");
  }
  opened_.erase(params.simulation);
  Opened& opened = openedFor(params.simulation);
  opened.symbols = params.symbols;
  if (const auto error = opened.process->open(toContext(params))) {
    opened_.erase(params.simulation);
    return failed(*error);
  }
  return std::string("{}");
}

EnvironmentDialogue::Reply EnvironmentDialogue::step(const protocol::Payload& payload) {
  const auto decoded = protocol::decodeEnvironmentStepParams(payload);
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    return *error;
  }
  const auto& params = std::get<protocol::EnvironmentStepParams>(decoded);
  Opened& opened = openedFor(params.simulation);

  // a process with state must not advance twice for one step
  std::uint64_t hash = 0;
  if (opened.isStateful) {
    core::Hasher hasher;
    hasher.bytes(payload.toText());
    hash = hasher.value();
    const bool isSame = opened.lastStep == params.step && opened.lastIteration == params.iteration;
    if (isSame && opened.lastQueriesHash == hash) {
      return opened.lastResult;
    }
    if (isSame || (opened.lastStep && params.step < *opened.lastStep)) {
      return protocol::Error{
          protocol::ErrorCode::StaleStep,
          "Step " + std::to_string(params.step) + " was asked for, but the environment has made step " +
              std::to_string(*opened.lastStep) + ". Open it again, or restore the state it had before that step.",
          {}};
    }
  }

  const turtle::QueryBatch queries = toBatch(params, opened.symbols);
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  const auto error = queries.size() == 0 ? opened.process->tick(params.step) : opened.process->step(queries, replies);
  if (error) {
    return failed(*error);
  }
  std::string result = protocol::encode(toReplies(queries, replies));
  if (opened.isStateful) {
    opened.lastStep = params.step;
    opened.lastIteration = params.iteration;
    opened.lastQueriesHash = hash;
    opened.lastResult = result;
  }
  return result;
}

EnvironmentDialogue::Reply EnvironmentDialogue::save(const protocol::Payload& payload) {
  const auto decoded = protocol::decodeNameParams(payload, "simulation");
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    return *error;
  }
  return protocol::encodeSaveResult(openedFor(std::get<protocol::NameParams>(decoded).name).process->save());
}

EnvironmentDialogue::Reply EnvironmentDialogue::restore(const protocol::Payload& payload) {
  const auto decoded = protocol::decodeRestoreStateParams(payload);
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    return *error;
  }
  const auto& params = std::get<protocol::RestoreStateParams>(decoded);
  Opened& opened = openedFor(params.simulation);
  if (const auto error = opened.process->restore(params.state)) {
    return failed(*error);
  }
  opened.lastStep.reset();
  return std::string("{}");
}

EnvironmentDialogue::Reply EnvironmentDialogue::close(const protocol::Payload& payload) {
  const auto decoded = protocol::decodeNameParams(payload, "simulation");
  if (const auto* error = std::get_if<protocol::Error>(&decoded)) {
    return *error;
  }
  opened_.erase(std::get<protocol::NameParams>(decoded).name);
  return std::string("{}");
}

}  // namespace espalier::server
