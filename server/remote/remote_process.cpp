#include "server/remote/remote_process.h"

#include <utility>

#include "engine/simulation/snapshot.h"
#include "protocol/codec.h"
#include "protocol/json_text.h"
#include "server/remote/translation/translate.h"
#include "server/remote/translation/translate_environment.h"
#include "server/remote/translation/translate_geometry.h"

namespace espalier::server {
namespace {

protocol::DescribeResult needsEverything() {
  protocol::DescribeResult description;
  description.needs = {.position = true,
                       .heading = true,
                       .left = true,
                       .up = true,
                       .width = true,
                       .scale = true,
                       .parameters = true,
                       .following = true,
                       .geometry = false};
  return description;
}

bool isUnknownMethod(const LinkFailure& failure) {
  return failure.kind == LinkFailure::Kind::Refused && failure.error.code == protocol::ErrorCode::UnknownMethod;
}

}  // namespace

RemoteProcess::RemoteProcess(std::shared_ptr<EnvironmentLink> link, RemoteProcessOptions options)
    : link_(std::move(link)), options_(std::move(options)), description_(needsEverything()) {}

LinkOutcome RemoteProcess::call(std::string_view method, const protocol::Body& params,
                                std::chrono::milliseconds timeout) const {
  LinkOutcome outcome = tl::unexpected(LinkFailure{});
  const auto wait = [&] { outcome = link_->call(method, params, timeout); };
  options_.runWaiting ? options_.runWaiting(wait) : wait();
  return outcome;
}

turtle::EnvironmentError RemoteProcess::errorOf(const LinkFailure& failure, const std::string& during) const {
  turtle::EnvironmentError error;
  // a peer that says that the request itself is wrong will say so again
  const bool isRefused = failure.kind == LinkFailure::Kind::Refused;
  const bool isServer = failure.kind == LinkFailure::Kind::Server;
  error.isRetryable = !isServer && (!isRefused || (failure.error.code != protocol::ErrorCode::InvalidParams &&
                                                   failure.error.code != protocol::ErrorCode::StaleStep &&
                                                   protocol::memberOf(failure.error.data, "retryable") != "false"));
  error.message = link_->label() + " " + failure.message + " (" + during + "). ";
  error.message += isServer    ? "Give the address that the environment prints when it listens."
                   : isRefused ? "Mend what the environment complains about, then try again."
                               : link_->remedy();
  return error;
}

std::optional<turtle::EnvironmentError> RemoteProcess::introduce() {
  std::optional<LinkFailure> failure;
  const auto connect = [&] { failure = link_->connect(); };
  options_.runWaiting ? options_.runWaiting(connect) : connect();
  if (failure) {
    return errorOf(*failure, "while connecting");
  }
  if (introducedGeneration_ == link_->generation()) {
    return std::nullopt;
  }
  const std::uint64_t generation = link_->generation();
  auto outcome = call("environment.describe", "{}", options_.introductionTimeout);
  isMinimal_ = false;
  if (outcome) {
    auto decoded = protocol::decodeDescribeResult(*outcome);
    if (!decoded) {
      return turtle::EnvironmentError{link_->label() + " describes itself wrongly: " + decoded.error().message + "." +
                                          " Correct its answer to environment.describe.",
                                      false};
    }
    description_ = std::move(*decoded);
    isDescribed_ = true;
  } else {
    const LinkFailure& problem = outcome.error();
    const bool isSilent = problem.kind == LinkFailure::Kind::Timeout;
    if (!isSilent && problem.kind != LinkFailure::Kind::Refused) {
      return errorOf(problem, "in environment.describe");
    }
    isMinimal_ = isSilent;
    isDescribed_ = false;
    description_ = needsEverything();
  }
  introducedGeneration_ = generation;
  return std::nullopt;
}

turtle::EnvironmentDescription RemoteProcess::describe() const {
  auto description = toDescription(description_);
  if (introducedGeneration_ == 0) {
    description.name = simulation::kUnknownEnvironment;
  } else if (description.name.empty()) {
    description.name = link_->label();
  }
  return description;
}

std::optional<turtle::EnvironmentError> RemoteProcess::openPeer(std::uint64_t step) {
  peerGeometry_.reset();
  auto params = toOpenParams(*context_, options_.configurationJson);
  params.bounds = options_.bounds;
  const bool isInRun = step > 0 || stepCount_ > 0;
  if (isInRun && !canCheckpoint()) {
    params.resumeStep = step;
  }
  auto outcome = call("environment.open", protocol::encode(params), options_.stepTimeout);
  if (!outcome && !isUnknownMethod(outcome.error())) {
    return errorOf(outcome.error(), "in environment.open");
  }
  if (!isInRun || !canCheckpoint()) {
    return std::nullopt;
  }

  // it was somewhere in a run: give it back its state
  if (!savedState_ || savedAt_ != stepCount_) {
    return turtle::EnvironmentError{link_->label() +
                                        " lost its state and no copy of it exists at this step. Reset the simulation, "
                                        "or restore a snapshot of it; a server with --data saves after every step.",
                                    false};
  }
  auto restored =
      call("environment.restore", protocol::encode(protocol::RestoreStateParams{context_->simulation, *savedState_}),
           options_.stepTimeout);
  if (!restored) {
    return errorOf(restored.error(), "in environment.restore");
  }
  return std::nullopt;
}

std::optional<turtle::EnvironmentError> RemoteProcess::makeReady(std::uint64_t step) {
  if (auto error = introduce()) {
    return error;
  }
  if (openedGeneration_ == link_->generation() || !context_) {
    return std::nullopt;
  }
  const std::uint64_t generation = link_->generation();
  if (!isMinimal_) {
    if (auto error = openPeer(step)) {
      return error;
    }
  }
  openedGeneration_ = generation;
  return std::nullopt;
}

std::optional<turtle::EnvironmentError> RemoteProcess::open(const turtle::EnvironmentContext& context) {
  context_ = context;
  openedGeneration_ = 0;
  stepCount_ = 0;
  savedState_.reset();
  auto error = makeReady(0);
  if (error && error->isRetryable && options_.isAbsenceTolerated) {
    return std::nullopt;
  }
  return error;
}

tl::expected<protocol::Body, turtle::EnvironmentError> RemoteProcess::bodyOf(
    const protocol::EnvironmentStepParams& params, const std::string& during) const {
  const PeerTerms terms = link_->terms();
  const bool isBinary = terms.takesBlocks;
  try {
    protocol::Body body = isBinary ? protocol::encodeBlocks(params) : protocol::Body(protocol::encode(params));
    const std::uint64_t bytes = isBinary ? body.blocks.totalBytes() : body.json.size();
    const std::uint64_t bound = isBinary ? terms.blockBytes : terms.lineBytes;
    if (bytes <= bound) {
      return body;
    }
    const std::string limit = isBinary ? "blockBytes" : "lineBytes";
    return tl::unexpected(turtle::EnvironmentError{
        link_->label() + " takes at most " + std::to_string(bound) + " bytes in one message (" + limit + "), but " +
            during + " take " + std::to_string(bytes) + " bytes" + (isBinary ? " in blocks." : " as text.") +
            " Let it need less (needs in environment.describe), " +
            (isBinary ? "raise its blockBytes, "
                      : "let it take binary blocks (the capability bin), raise its lineBytes, ") +
            "or let the model ask less in one step.",
        false});
  } catch (const protocol::NonFiniteNumber&) {
    return tl::unexpected(turtle::EnvironmentError{"A query for " + link_->label() +
                                                       " has a parameter or position that is NaN or infinite (" +
                                                       during + "). Correct the model.",
                                                   false});
  }
}

std::optional<turtle::EnvironmentError> RemoteProcess::step(const turtle::QueryBatch& queries,
                                                            turtle::ReplyBatch& replies) {
  if (auto error = makeReady(queries.step)) {
    return error;
  }
  const std::string during = "step " + std::to_string(queries.step) + ", " + std::to_string(queries.size()) +
                             (queries.size() == 1 ? " query" : " queries");
  const std::string simulation = context_ ? context_->simulation : std::string("simulation");
  const std::vector<std::string> symbols = context_ ? context_->symbols : std::vector<std::string>();
  auto params = toStepParams(simulation, queries, description_.needs, symbols);
  // whatever goes wrong from here on: the peer is sent all of the geometry again
  const auto peerGeometry = std::exchange(peerGeometry_, nullptr);
  if (description_.needs.geometry && queries.geometry != nullptr) {
    params.geometry =
        toColumns(queries.geometry, description_.takesDifferences ? peerGeometry.get() : nullptr, symbols);
  }
  auto body = bodyOf(params, during);
  if (!body) {
    return std::move(body.error());
  }
  auto outcome = call("environment.step", *body, options_.stepTimeout);
  if (!outcome && isMinimal_ && outcome.error().kind == LinkFailure::Kind::Refused) {
    // a peer that was silent and answers now was only slow to start: it can be described and opened after all
    introducedGeneration_ = 0;
    openedGeneration_ = 0;
    if (auto error = makeReady(queries.step)) {
      return error;
    }
    if (!isMinimal_) {
      return this->step(queries, replies);
    }
  }
  if (!outcome) {
    return errorOf(outcome.error(), during);
  }
  auto decoded = protocol::decodeReplies(*outcome, queries.size());
  if (!decoded) {
    return turtle::EnvironmentError{link_->label() + " answered wrongly (" + during + "): " + decoded.error().message +
                                        ". Correct the environment, then ask again.",
                                    true};
  }
  applyReplies(*decoded, queries, replies);
  peerGeometry_ = queries.geometry;
  ++stepCount_;
  if (options_.keepsState) {
    (void)save();
  }
  return std::nullopt;
}

std::optional<turtle::EnvironmentError> RemoteProcess::tick(std::uint64_t step) {
  // a process without state has nothing to advance
  if (isDescribed_ && !description_.isStateful) {
    return std::nullopt;
  }
  turtle::QueryBatch none;
  none.clear();
  none.step = step;
  none.timeDays = context_ ? turtle::beginOfStep(context_->world.stepDurationDays, step) : 0.0;
  none.parameterOffset.assign(1, 0);
  none.followingOffset.assign(1, 0);
  turtle::ReplyBatch replies;
  replies.prepare(none);
  return this->step(none, replies);
}

std::string RemoteProcess::simulationParams() const {
  protocol::JsonWriter params;
  return params.beginObject().key("simulation").text(context_ ? context_->simulation : "").endObject().take();
}

std::string RemoteProcess::save() const {
  if (!canCheckpoint()) {
    return {};
  }
  if (savedState_ && savedAt_ == stepCount_) {
    return *savedState_;
  }
  if (openedGeneration_ == 0 || openedGeneration_ != link_->generation()) {
    return {};
  }
  auto outcome = call("environment.save", simulationParams(), options_.stepTimeout);
  if (!outcome) {
    return {};
  }
  auto state = protocol::decodeSaveResult(*outcome);
  if (!state) {
    return {};
  }
  savedState_ = std::move(*state);
  savedAt_ = stepCount_;
  return *savedState_;
}

std::optional<turtle::EnvironmentError> RemoteProcess::restore(std::string_view state) {
  stepCount_ = stepCount_ == 0 ? 1 : stepCount_;
  savedState_ = std::string(state);
  savedAt_ = stepCount_;
  peerGeometry_.reset();
  // a peer that has the simulation open is only given its state
  if (openedGeneration_ != 0 && openedGeneration_ == link_->generation() && canCheckpoint() && context_) {
    const auto params = protocol::encode(protocol::RestoreStateParams{context_->simulation, *savedState_});
    const auto restored = call("environment.restore", params, options_.stepTimeout);
    if (restored) {
      return std::nullopt;
    }
  }
  // else the next call opens it again and gives it this state
  openedGeneration_ = 0;
  auto error = makeReady(0);
  if (error && error->isRetryable && options_.isAbsenceTolerated) {
    return std::nullopt;
  }
  return error;
}

}  // namespace espalier::server
