#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engine/core/simulation_error.h"
#include "engine/simulation/simulation.h"
#include "protocol/messages.h"

namespace espalier::server {

class Session;

/// One viewer's stream of one simulation. A frame is made only when the viewer is ready for it, so a slow one costs the
/// simulation nothing and the server no memory: steps in between are counted as missed, and the next frame shows the
/// latest step. Every frame is complete in itself. Thread-safe.
class Stream {
 public:
  Stream(std::string id, protocol::StreamOpenParams params, std::weak_ptr<Session> session, std::size_t readyBytes);

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const protocol::StreamOpenParams& params() const { return params_; }

  /// A step was completed. Whether a frame is to be made of it now; if not, and it was due, it counts as missed.
  [[nodiscard]] bool wantsFrame(std::uint64_t step);
  /// Whether frames were left out and the viewer is ready again.
  [[nodiscard]] bool wantsToCatchUp();
  /// Sends the frame of a step. `body` as in protocol::StreamData.
  void send(std::uint64_t step, bool isFinished, protocol::Body body);
  /// Sends the reason for the stream's end, once.
  void end(const std::string& reason);
  void acknowledge(const protocol::StreamAckParams& ack);
  /// The viewer closed it: nothing is sent any more.
  void close();
  [[nodiscard]] bool isClosed() const;

 private:
  [[nodiscard]] bool isReady() const;  // with mutex_ held

  const std::string id_;
  const protocol::StreamOpenParams params_;
  const std::weak_ptr<Session> session_;
  const std::size_t readyBytes_;  // queued on the connection: below it the viewer is ready
  mutable std::mutex mutex_;
  std::uint64_t nextSequence_ = 0;
  std::uint64_t allowedSequence_ = 0;  // frames below it may be sent, when there are credits
  std::uint64_t missed_ = 0;           // since the last frame
  std::optional<std::uint64_t> lastMissedStep_;
  bool isClosed_ = false;
};

/// The body of a frame of the simulation as it is now. Turtle records are made once in `records` for all streams.
[[nodiscard]] std::variant<protocol::Body, core::SimulationError> frameBody(
    const protocol::StreamOpenParams& params, const simulation::Simulation& simulation, double milliseconds,
    std::optional<std::vector<turtle::TurtleRecord>>& records);

}  // namespace espalier::server
