#include "server/remote/hosting/environment_dialogue.h"

#include <algorithm>
#include <array>

#include "engine/core/hash.h"
#include "protocol/codec.h"
#include "protocol/version.h"
#include "server/remote/translation/translate.h"
#include "server/remote/translation/translate_environment.h"
#include "server/remote/translation/translate_geometry.h"

namespace espalier::server {
namespace {

protocol::Error failed(const turtle::EnvironmentError& error) {
  protocol::JsonWriter data;
  data.beginObject().key("retryable").boolean(error.isRetryable).endObject();
  return {protocol::ErrorCode::EnvironmentFailed, error.message, data.take()};
}

template <typename T>
void add(core::Hasher& hasher, std::span<const T> column) {
  hasher.bytes({reinterpret_cast<const char*>(column.data()), column.size_bytes()});
}

/// Of everything that a process sees of a step.
std::uint64_t hashOf(const protocol::EnvironmentStepParams& params) {
  const protocol::QueryColumns& queries = params.queries;
  core::Hasher hasher;
  hasher.bytes({reinterpret_cast<const char*>(&params.timeDays), sizeof(params.timeDays)});
  add(hasher, queries.plant);
  add(hasher, queries.module);
  add(hasher, queries.isTransient);
  for (const std::uint32_t symbol : queries.symbol) {
    hasher.bytes(queries.symbols[symbol]);
  }
  add(hasher, queries.offset);
  add(hasher, queries.parameters);
  for (const auto& column :
       {queries.position, queries.heading, queries.left, queries.up, queries.width, queries.scale}) {
    add(hasher, column);
  }
  for (const std::uint32_t symbol : queries.following) {
    hasher.bytes(symbol == protocol::QueryColumns::kNoSymbol ? "" : queries.symbols[symbol]);
  }
  add(hasher, queries.followingOffset);
  add(hasher, queries.followingParameters);
  return hasher.value();
}

/// The answer as the question came: in blocks or as text.
protocol::Body bodyOf(const protocol::ReplyColumns& replies, const protocol::Payload& question) {
  return question.blocks() != nullptr ? protocol::encodeBlocks(replies) : protocol::Body(protocol::encode(replies));
}

}  // namespace

std::optional<std::string> EnvironmentDialogue::answer(const protocol::MessageReader::Read& read) {
  if (!read) {
    return protocol::encodeError(read.error().id, read.error().error);
  }
  const auto& message = *read;
  if (message.kind != protocol::Message::Kind::Request) {
    return std::nullopt;
  }
  const Reply reply = handle(message);
  if (!reply) {
    return protocol::encodeError(message.id, reply.error());
  }
  return protocol::encodeResult(message.id, *reply);
}

template <auto decode, auto handler>
EnvironmentDialogue::Reply EnvironmentDialogue::decodeAndHandle(EnvironmentDialogue& self,
                                                                const protocol::Payload& payload) {
  const auto params = decode(payload);
  if (!params) {
    return tl::unexpected(params.error());
  }
  return (self.*handler)(*params, payload);
}

EnvironmentDialogue::Reply EnvironmentDialogue::handle(const protocol::Message& request) {
  struct Row {
    std::string_view name;
    Reply (*handle)(EnvironmentDialogue&, const protocol::Payload&);
  };
  using Dialogue = EnvironmentDialogue;
  static constexpr std::array kRows{
#define ESPALIER_COMMON_METHOD(NAME, PARAMS, HANDLER, SUMMARY) \
  Row{NAME, &decodeAndHandle<&protocol::decode##PARAMS, &Dialogue::HANDLER>},
#define ESPALIER_SHARED_METHOD(NAME, PARAMS, HANDLER, NEEDS, ROLE, SUMMARY) \
  Row{NAME, &decodeAndHandle<&protocol::decode##PARAMS, &Dialogue::HANDLER>},
#define ESPALIER_ENVIRONMENT_METHOD(NAME, PARAMS, HANDLER, SUMMARY) \
  Row{NAME, &decodeAndHandle<&protocol::decode##PARAMS, &Dialogue::HANDLER>},
#include "protocol/methods.def"
  };
  std::string names;
  try {
    for (const Row& row : kRows) {
      if (row.name == request.method) {
        return row.handle(*this, request.payload);
      }
      names += (names.empty() ? "" : ", ") + std::string(row.name);
    }
  } catch (const protocol::NonFiniteNumber&) {
    return tl::unexpected(
        protocol::Error{protocol::ErrorCode::NonFinite,
                        "The environment computed a NaN or infinite value. Check the parameters sent to it.",
                        {}});
  } catch (const std::exception& exception) {
    return tl::unexpected(
        protocol::Error{protocol::ErrorCode::Internal,
                        std::string("The environment has a bug: ") + exception.what() + ". Please report it.",
                        {}});
  }
  return tl::unexpected(
      protocol::Error{protocol::ErrorCode::UnknownMethod,
                      "'" + request.method + "' is unknown here. An environment answers " + names + ".",
                      {}});
}

EnvironmentDialogue::Reply EnvironmentDialogue::hello(const protocol::HelloParams& params, const protocol::Payload&) {
  if (std::find(params.protocol.begin(), params.protocol.end(), protocol::kProtocolVersion) == params.protocol.end()) {
    return tl::unexpected(
        protocol::Error{protocol::ErrorCode::Version,
                        "No common protocol version: this environment speaks 1. Use a peer that speaks espalier/1.",
                        {}});
  }
  areBlocksAgreed_ =
      std::find(params.capabilities.begin(), params.capabilities.end(), "bin") != params.capabilities.end();
  const protocol::HelloResult result{.protocol = protocol::kProtocolVersion,
                                     .session = "1",
                                     .server = "espalier " + std::string(protocol::kProgramVersion),
                                     .roles = {},
                                     .capabilities = {"bin", "checkpoint"},
                                     .limits = {{"lineBytes", limits_.lineBytes}, {"blockBytes", limits_.blockBytes}}};
  return protocol::encode(result);
}

EnvironmentDialogue::Reply EnvironmentDialogue::ping(const protocol::NoParams&, const protocol::Payload&) {
  return protocol::Body("{}");
}

EnvironmentDialogue::Reply EnvironmentDialogue::describe(const protocol::NoParams&, const protocol::Payload&) {
  return protocol::encode(toDescribeResult((*factory_)()->describe()));
}

protocol::Expected<EnvironmentDialogue::Opened*> EnvironmentDialogue::openedFor(const std::string& simulation) {
  const auto found = opened_.find(simulation);
  if (found != opened_.end()) {
    return &found->second;
  }
  turtle::EnvironmentContext context;
  context.simulation = simulation;
  return openAnew(context);
}

protocol::Expected<EnvironmentDialogue::Opened*> EnvironmentDialogue::openAnew(
    const turtle::EnvironmentContext& context) {
  opened_.erase(context.simulation);
  if (opened_.size() >= kMostSimulations) {
    return tl::unexpected(protocol::limitError("simulations", opened_.size() + 1, kMostSimulations,
                                               "Close simulations of this connection, or connect again for more."));
  }
  Opened opened;
  opened.process = (*factory_)();
  const turtle::EnvironmentDescription description = opened.process->describe();
  opened.isStateful = description.isStateful;
  opened.needs = description.needs;
  opened.symbols = context.symbols;
  if (const auto error = opened.process->open(context)) {
    return tl::unexpected(failed(*error));
  }
  return &opened_.insert_or_assign(context.simulation, std::move(opened)).first->second;
}

EnvironmentDialogue::Reply EnvironmentDialogue::open(const protocol::OpenParams& params, const protocol::Payload&) {
  if (!params.configurationJson.empty()) {
    return tl::unexpected(protocol::memberError(
        "params.configuration",
        "this environment was configured when it was started (--configuration FILE); leave the configuration out"));
  }
  const auto context = toContext(params);
  if (!context) {
    return tl::unexpected(protocol::memberError("params.world", context.error()));
  }
  if (auto opened = openAnew(*context); !opened) {
    return tl::unexpected(std::move(opened.error()));
  }
  return protocol::Body("{}");
}

EnvironmentDialogue::Reply EnvironmentDialogue::step(const protocol::EnvironmentStepParams& params,
                                                     const protocol::Payload& payload) {
  const auto found = openedFor(params.simulation);
  if (!found) {
    return tl::unexpected(found.error());
  }
  Opened& opened = **found;

  // a process with state must not advance twice for one step
  const std::optional<std::uint64_t> before = opened.lastStep;
  std::uint64_t hash = 0;
  if (opened.isStateful) {
    hash = hashOf(params);
    const bool isSame = opened.lastStep == params.step && opened.lastIteration == params.iteration;
    if (isSame && opened.lastQueriesHash == hash) {
      return bodyOf(opened.columns, payload);
    }
    if (isSame || (opened.lastStep && params.step < *opened.lastStep)) {
      return tl::unexpected(protocol::Error{
          protocol::ErrorCode::StaleStep,
          "Step " + std::to_string(params.step) + " was asked for, but the environment has made step " +
              std::to_string(*opened.lastStep) + ". Open it again, or restore the state it had before that step.",
          {}});
    }
  }

  opened.lastStep.reset();
  opened.queries = toBatch(params, opened.needs, opened.symbols);
  if (params.geometry) {
    auto geometry = std::make_shared<turtle::Geometry>();
    const std::shared_ptr<const turtle::Geometry> last = std::exchange(opened.geometry, nullptr);
    if (const auto problem = toGeometry(*params.geometry, last.get(), opened.symbols, *geometry)) {
      opened.lastStep = before;
      return tl::unexpected(protocol::memberError("params.geometry", *problem + "; send the whole geometry"));
    }
    opened.geometry = geometry;
    opened.queries.geometry = std::move(geometry);
  }
  opened.replies.prepare(opened.queries);
  const bool isTick = opened.queries.size() == 0 && !opened.needs.geometry;
  const auto error = isTick ? opened.process->tick(params.step) : opened.process->step(opened.queries, opened.replies);
  if (error) {
    opened.lastStep = before;
    return tl::unexpected(failed(*error));
  }
  opened.columns = toReplies(opened.queries, opened.replies);
  if (opened.isStateful) {
    opened.lastStep = params.step;
    opened.lastIteration = params.iteration;
    opened.lastQueriesHash = hash;
  }
  return bodyOf(opened.columns, payload);
}

EnvironmentDialogue::Reply EnvironmentDialogue::save(const protocol::SimulationParams& params,
                                                     const protocol::Payload&) {
  const auto found = openedFor(params.simulation);
  if (!found) {
    return tl::unexpected(found.error());
  }
  return protocol::encodeSaveResult((*found)->process->save());
}

EnvironmentDialogue::Reply EnvironmentDialogue::restore(const protocol::RestoreStateParams& params,
                                                        const protocol::Payload&) {
  const auto found = openedFor(params.simulation);
  if (!found) {
    return tl::unexpected(found.error());
  }
  if (const auto error = (*found)->process->restore(params.state)) {
    return tl::unexpected(failed(*error));
  }
  (*found)->lastStep.reset();
  return protocol::Body("{}");
}

EnvironmentDialogue::Reply EnvironmentDialogue::close(const protocol::SimulationParams& params,
                                                      const protocol::Payload&) {
  opened_.erase(params.simulation);
  return protocol::Body("{}");
}

}  // namespace espalier::server
