#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/envelope.h"

namespace espalier::server {

/// Why a call to an environment in another process has no result.
struct LinkFailure {
  enum class Kind : std::uint8_t {
    Away,    // no peer: not offered, not reachable, could not be started
    Closed,  // the peer was there and went away
    Timeout,
    Refused,      // it answered with an error: `error`
    Garbage,      // it sent something that is not a message of the protocol
    Server,       // it is a server of simulations
    Interrupted,  // the caller gave up
  };
  Kind kind = Kind::Away;
  std::string message;    // the rest of a sentence that begins with the environment: "went away"
  protocol::Error error;  // Refused: the error that the peer sent
};

/// The failure of a call that the peer answered with an error. Its message is a stranger's text: it goes on to others
/// with at most 2000 bytes.
[[nodiscard]] LinkFailure refusedWith(const protocol::Error& error);

/// The result of a call.
using LinkOutcome = tl::expected<protocol::Payload, LinkFailure>;

/// Blocks and sizes that the peer of a link takes.
struct PeerTerms {
  bool takesBlocks = false;               // both sides named `bin`
  std::uint64_t lineBytes = 256'000'000;  // as in its hello, else as our own environments take
  std::uint64_t blockBytes = 0;           // of one message
};

/// The terms of a peer's hello, when we take blocks.
[[nodiscard]] PeerTerms termsOf(const std::vector<std::string>& capabilities,
                                const std::vector<std::pair<std::string, std::uint64_t>>& limits);

/// A connection to an environment in another process, made again when it is lost. One thread calls at a time; only
/// interrupt() may come from another.
class EnvironmentLink {
 public:
  virtual ~EnvironmentLink() = default;

  /// How messages name it: "environment 'mylight'", "environment tcp://127.0.0.1:4000".
  [[nodiscard]] virtual std::string label() const = 0;
  /// Advice for the user when it is away, a whole sentence.
  [[nodiscard]] virtual std::string remedy() const = 0;
  /// Makes sure that a peer is there, connecting when needed.
  [[nodiscard]] virtual std::optional<LinkFailure> connect() = 0;
  /// A number that is new for each new peer; 0: there is no peer.
  [[nodiscard]] virtual std::uint64_t generation() const = 0;
  /// The terms of the present peer; meaningless without one.
  [[nodiscard]] virtual PeerTerms terms() const = 0;
  /// Asks and waits for the answer. The params are an object.
  [[nodiscard]] virtual LinkOutcome call(std::string_view method, const protocol::Body& params,
                                         std::chrono::milliseconds timeout) = 0;
  /// Ends a call that waits now.
  virtual void interrupt() = 0;
};

}  // namespace espalier::server
