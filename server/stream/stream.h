#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "protocol/messages.h"
#include "server/stream/stream_frame.h"

namespace espalier::server {

class Session;

/// Steps, the last one included.
struct StepRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

/// One viewer's stream of one simulation. A frame is made only when the viewer is ready for it, so a slow viewer costs
/// the server no memory. Steps in between count as missed; the next frame is a key frame of the latest step. Otherwise
/// a frame may be the difference from the one before. Thread-safe.
class Stream {
 public:
  Stream(std::string id, protocol::StreamOpenParams params, std::weak_ptr<Session> session, std::size_t outboxBytes);

  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] const protocol::StreamOpenParams& params() const { return params_; }

  /// A completed step, when its frames are made.
  struct Moment {
    std::uint64_t step = 0;
    std::uint64_t number = 0;  // of the state, among those that were handed over to the viewers (Viewers)
  };
  /// True: a frame is to be made now. A step that is due and gets no frame counts as missed.
  [[nodiscard]] bool wantsFrame(const Moment& moment);
  /// No frames are made of these steps: those that were due count as missed. The next frame may still be a difference.
  void skip(const std::vector<StepRange>& steps);
  /// `lastNumber` counts the states that are handed over. Credits that come later are not for these.
  void follow(std::shared_ptr<const std::atomic<std::uint64_t>> lastNumber);
  /// Whether frames were left out and the viewer is ready again.
  [[nodiscard]] bool wantsToCatchUp();
  /// The frame that the next one may refer to.
  [[nodiscard]] FrameBase base() const;
  /// The next frame is a key frame.
  void forgetBase();
  /// Sends the frame of a step.
  void send(std::uint64_t step, bool isFinished, StreamFrame frame);
  /// Sends the reason for the stream's end, once.
  void end(const std::string& reason);
  void acknowledge(const protocol::StreamAckParams& ack);
  /// The viewer closed it: nothing is sent any more.
  void close();
  [[nodiscard]] bool isClosed() const;

 private:
  using Clock = std::chrono::steady_clock;

  // with mutex_ held
  [[nodiscard]] bool isReady(std::uint64_t allowedSequence) const;
  void miss(std::uint64_t step, std::uint64_t count);
  /// Enough time has passed since the last frame (maxHz). If not, has the session ask again in time.
  [[nodiscard]] bool isTimely();

  const std::string id_;
  const protocol::StreamOpenParams params_;
  const std::weak_ptr<Session> session_;
  const std::size_t outboxBytes_;  // that may be queued on the connection
  mutable std::mutex mutex_;
  std::uint64_t nextSequence_ = 0;
  std::uint64_t allowedSequence_ = 0;  // frames below it may be sent, when there are credits
  std::uint64_t allowedBefore_ = 0;    // the same for states before the one that was the last when credits came
  std::uint64_t allowedFrom_ = 0;      // the number of that state
  std::shared_ptr<const std::atomic<std::uint64_t>> lastNumber_;  // null: no state was handed over yet
  std::uint64_t missed_ = 0;                                      // since the last frame
  std::optional<std::uint64_t> lastMissedStep_;
  bool isBehind_ = false;         // a frame that was due was not sent
  bool isReminded_ = false;       // the session will ask again
  Clock::time_point nextTime_{};  // no frame before it
  FrameBase base_;
  bool isClosed_ = false;
};

}  // namespace espalier::server
