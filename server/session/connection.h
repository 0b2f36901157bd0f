#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "protocol/errors.h"

namespace espalier::server {

/// The writing half of a connection as sessions see it, without the network library. All members are thread-safe.
class Connection {
 public:
  virtual ~Connection() = default;
  /// Queues a complete message. A connection whose queue grows beyond the limit is closed, because its peer does not
  /// read.
  virtual void send(std::shared_ptr<const std::string> line) = 0;
  /// Closes after the queue has been sent.
  virtual void closeWhenSent() = 0;
  /// Calls Session::onDrained when that time has passed.
  virtual void remind(std::chrono::milliseconds delay) = 0;
  /// The peer has said hello and may use the server. On the network thread. An error when there are as many sessions as
  /// there may be.
  [[nodiscard]] virtual std::optional<protocol::Error> admit() { return std::nullopt; }
  /// Bytes queued and not yet given to the system.
  [[nodiscard]] virtual std::size_t outboxBytes() const = 0;
  /// Address for the log.
  [[nodiscard]] virtual std::string peerName() const = 0;
};

}  // namespace espalier::server
