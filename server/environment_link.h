#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "protocol/envelope.h"

namespace espalier::server {

/// Why a call to an environment in another process has no result.
struct LinkFailure {
  enum class Kind : std::uint8_t {
    Away,    // nobody is there: not offered, not reachable, could not be started
    Closed,  // it was there and went away
    Timeout,
    Refused,      // it answered with an error: `error`
    Garbage,      // it sent something that is not a message of the protocol
    Interrupted,  // the caller gave up
  };
  Kind kind = Kind::Away;
  std::string message;    // what happened, as the rest of a sentence that begins with the environment: "went away"
  protocol::Error error;  // Refused: what it said
};

using LinkOutcome = std::variant<protocol::Payload, LinkFailure>;

/// A connection to an environment in another process, made again when it is lost. One thread calls at a time; only
/// interrupt() may come from another.
class EnvironmentLink {
 public:
  virtual ~EnvironmentLink() = default;

  /// How messages name it: "environment 'mylight'", "environment tcp://127.0.0.1:4000".
  [[nodiscard]] virtual std::string label() const = 0;
  /// What to do when it is away, a whole sentence.
  [[nodiscard]] virtual std::string remedy() const = 0;
  /// Makes sure that a peer is there, connecting when needed.
  [[nodiscard]] virtual std::optional<LinkFailure> connect() = 0;
  /// Differs from every earlier value when the peer is not the one it was; 0: none is there.
  [[nodiscard]] virtual std::uint64_t generation() const = 0;
  /// Asks and waits for the answer. `paramsJson` is the text of an object.
  [[nodiscard]] virtual LinkOutcome call(std::string_view method, const std::string& paramsJson,
                                         std::chrono::milliseconds timeout) = 0;
  /// Ends a call that waits now.
  virtual void interrupt() = 0;
};

}  // namespace espalier::server
