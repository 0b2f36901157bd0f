#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/remote/environment_link.h"

namespace espalier::server {

/// One question to a peer. A worker waits for the answer, and the network thread brings it.
class PendingCall {
 public:
  void complete(LinkOutcome outcome);
  void fail(LinkFailure failure) { complete(tl::unexpected(std::move(failure))); }
  /// Nothing when the time is over.
  [[nodiscard]] std::optional<LinkOutcome> wait(std::chrono::milliseconds timeout);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<LinkOutcome> outcome_;
};

/// A connected peer that answers questions: a session. Thread-safe.
class AskedPeer {
 public:
  virtual ~AskedPeer() = default;
  /// Sends a request and completes `call` with its answer, or at once when the connection is closed. Returns its id.
  [[nodiscard]] virtual std::string ask(std::string_view method, const protocol::Body& params,
                                        std::shared_ptr<PendingCall> call) = 0;
  [[nodiscard]] virtual PeerTerms terms() const = 0;
  /// The answer to the request is not needed any more.
  virtual void forget(const std::string& id) = 0;
  /// The name of the token that the peer came with. Empty: the server has no tokens.
  [[nodiscard]] virtual std::string owner() const = 0;
  /// The peer was asked whether it is there, and has been silent since.
  [[nodiscard]] virtual bool hasMissedHeartbeat() const = 0;
};

/// The environments that connected and offered themselves, by name. A peer may take over the name of another one that
/// came with the same token, so an environment that comes back is used even while its old connection looks alive.
/// Without tokens the older peer must have missed its heartbeat. Thread-safe.
class OfferedEnvironments {
 public:
  struct Offer {
    std::weak_ptr<AskedPeer> peer;
    std::uint64_t serial = 0;  // 1, 2, ... of all offers
  };
  enum class Outcome : std::uint8_t { New, Replaced, Taken };
  /// `announce` is called before the offer can be found, unless the name is taken. The questions that wait for an older
  /// peer fail.
  [[nodiscard]] Outcome offer(const std::string& name, const std::shared_ptr<AskedPeer>& peer,
                              const std::function<void()>& announce);
  /// Forgets all offers of a peer.
  void withdraw(const AskedPeer* peer);
  [[nodiscard]] std::optional<Offer> find(const std::string& name) const;
  /// Does what find(name) does, for a question: when another peer takes the name over, `call` fails.
  [[nodiscard]] std::optional<Offer> find(const std::string& name, const std::shared_ptr<PendingCall>& call);
  [[nodiscard]] std::vector<std::string> names() const;
  /// How many names a peer offers.
  [[nodiscard]] std::size_t count(const AskedPeer* peer) const;

 private:
  struct Entry {
    Offer offer;
    std::vector<std::weak_ptr<PendingCall>> calls;  // that may still wait for the peer
  };

  mutable std::mutex mutex_;
  std::map<std::string, Entry> offers_;
  std::uint64_t lastSerial_ = 0;
};

/// A link to the peer that offers a name now. Once a peer has answered, only peers with its token are asked: they get
/// the plants and the saved state.
class OfferedLink final : public EnvironmentLink {
 public:
  /// `offered` must outlive the link.
  OfferedLink(std::string name, OfferedEnvironments& offered) : name_(std::move(name)), offered_(&offered) {}

  [[nodiscard]] std::string label() const override { return "environment '" + name_ + "'"; }
  [[nodiscard]] std::string remedy() const override;
  [[nodiscard]] std::optional<LinkFailure> connect() override;
  [[nodiscard]] std::uint64_t generation() const override;
  [[nodiscard]] PeerTerms terms() const override;
  [[nodiscard]] LinkOutcome call(std::string_view method, const protocol::Body& params,
                                 std::chrono::milliseconds timeout) override;
  void interrupt() override;

 private:
  [[nodiscard]] LinkFailure away() const;
  /// The peer of an offer. Null: none is connected, or it came with another token than the one before.
  [[nodiscard]] std::shared_ptr<AskedPeer> peerOf(const std::optional<OfferedEnvironments::Offer>& offer) const;

  std::string name_;
  OfferedEnvironments* offered_;
  std::optional<std::string> owner_;  // of the peer that answered first
  std::mutex mutex_;                  // guards current_
  std::shared_ptr<PendingCall> current_;
};

}  // namespace espalier::server
