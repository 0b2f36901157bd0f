#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "engine/turtle/environment_process.h"
#include "protocol/messages.h"
#include "server/remote/environment_link.h"

namespace espalier::server {

struct RemoteProcessOptions {
  std::chrono::milliseconds stepTimeout{60'000};
  /// How long a peer may take to answer environment.describe. A silent peer is treated as a minimal environment: it is
  /// sent everything, and asked only for steps.
  std::chrono::milliseconds introductionTimeout{10'000};
  std::string configurationJson;                 // text of an object for environment.open; empty: none
  std::optional<protocol::BoundsRecord> bounds;  // of the space that the plants may fill, for environment.open
  /// A peer that is away is not an error before the first step (simulations loaded from disk).
  bool isAbsenceTolerated = false;
  /// Asks the peer for its state after each step: when the peer dies in the next one, save() has the state before it.
  bool keepsState = false;
  /// Runs the waiting part of each call; empty: directly. The server lets another worker compute meanwhile.
  std::function<void(const std::function<void()>&)> runWaiting;
};

/// An environment in another process as the simulation sees it. When the peer was lost, the next step connects again,
/// opens it again, gives back its state when possible, and sends the same step again. A step is idempotent by (step,
/// iteration).
class RemoteProcess final : public turtle::EnvironmentProcess {
 public:
  RemoteProcess(std::shared_ptr<EnvironmentLink> link, RemoteProcessOptions options);

  /// Connects and asks for the description. An error when the peer is away or refuses.
  [[nodiscard]] std::optional<turtle::EnvironmentError> introduce();

  /// The peer answered environment.describe.
  [[nodiscard]] bool isDescribed() const { return isDescribed_; }
  [[nodiscard]] turtle::EnvironmentDescription describe() const override;
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override;
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override;
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) override;
  [[nodiscard]] std::string save() const override;
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override;

 private:
  [[nodiscard]] LinkOutcome call(std::string_view method, const protocol::Body& params,
                                 std::chrono::milliseconds timeout) const;
  /// The queries as the peer takes them, or the reason why they cannot be sent.
  [[nodiscard]] tl::expected<protocol::Body, turtle::EnvironmentError> bodyOf(
      const protocol::EnvironmentStepParams& params, const std::string& during) const;
  /// Connected, introduced, opened and with its state given back.
  [[nodiscard]] std::optional<turtle::EnvironmentError> makeReady(std::uint64_t step);
  [[nodiscard]] std::optional<turtle::EnvironmentError> openPeer(std::uint64_t step);
  [[nodiscard]] turtle::EnvironmentError errorOf(const LinkFailure& failure, const std::string& during) const;
  [[nodiscard]] bool canCheckpoint() const { return description_.isStateful && description_.canCheckpoint; }
  [[nodiscard]] std::string simulationParams() const;

  std::shared_ptr<EnvironmentLink> link_;
  RemoteProcessOptions options_;
  protocol::DescribeResult description_;
  bool isDescribed_ = false;                // the peer answered environment.describe
  bool isMinimal_ = false;                  // it answers steps only
  std::uint64_t introducedGeneration_ = 0;  // of the link; 0: none
  std::uint64_t openedGeneration_ = 0;
  std::optional<turtle::EnvironmentContext> context_;
  std::uint64_t stepCount_ = 0;                    // steps and ticks since open: the version of the peer's state
  mutable std::optional<std::string> savedState_;  // of the peer, when savedAt_ == stepCount_
  mutable std::uint64_t savedAt_ = 0;
  std::shared_ptr<const turtle::Geometry> peerGeometry_;  // that the peer was sent last and has; null: send all of it
};

}  // namespace espalier::server
