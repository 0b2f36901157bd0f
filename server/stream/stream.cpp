#include "server/stream/stream.h"

#include <algorithm>

#include "protocol/codec.h"
#include "server/server_core.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

// queued on the connection: below it the viewer is ready, if its outbox is not smaller
constexpr std::size_t kReadyBytes = 16'000'000;

}  // namespace

Stream::Stream(std::string id, protocol::StreamOpenParams params, std::weak_ptr<Session> session,
               std::size_t outboxBytes)
    : id_(std::move(id)),
      params_(std::move(params)),
      session_(std::move(session)),
      outboxBytes_(outboxBytes),
      allowedSequence_(params_.credits.value_or(0)),
      allowedBefore_(allowedSequence_) {}

void Stream::follow(std::shared_ptr<const std::atomic<std::uint64_t>> lastNumber) {
  const std::lock_guard lock(mutex_);
  lastNumber_ = std::move(lastNumber);
}

bool Stream::isReady(std::uint64_t allowedSequence) const {
  const auto session = session_.lock();
  return session != nullptr && session->outboxBytes() < std::min(outboxBytes_ / 4, kReadyBytes) &&
         (!params_.credits || nextSequence_ < allowedSequence);
}

bool Stream::isTimely() {
  if (params_.maximumHertz == 0.0) {
    return true;
  }
  const Clock::time_point now = Clock::now();
  if (now >= nextTime_) {
    return true;
  }
  if (const auto session = session_.lock(); session != nullptr && !isReminded_) {
    isReminded_ = true;
    session->remind(std::chrono::ceil<std::chrono::milliseconds>(nextTime_ - now));
  }
  return false;
}

bool Stream::wantsFrame(const Moment& moment) {
  const std::lock_guard lock(mutex_);
  if (isClosed_ || moment.step % params_.every != 0) {
    return false;
  }
  // a frame that would come sooner than maxHz allows is not missed
  if (!isTimely()) {
    isBehind_ = true;
    return false;
  }
  if (isReady(moment.number < allowedFrom_ ? allowedBefore_ : allowedSequence_)) {
    return true;
  }
  miss(moment.step, 1);
  base_ = {};
  return false;
}

void Stream::skip(const std::vector<StepRange>& steps) {
  if (steps.empty()) {
    return;
  }
  const std::lock_guard lock(mutex_);
  for (const StepRange& range : steps) {
    const std::uint64_t before = range.first == 0 ? 0 : (range.first - 1) / params_.every + 1;
    const std::uint64_t count = range.last / params_.every + 1 - before;
    if (isClosed_ || count == 0) {
      continue;
    }
    // frames that maxHz leaves out are not missed
    if (params_.maximumHertz > 0.0) {
      isBehind_ = true;
    } else {
      miss(range.last - range.last % params_.every, count);
    }
  }
}

void Stream::miss(std::uint64_t step, std::uint64_t count) {
  isBehind_ = true;
  missed_ += count;
  lastMissedStep_ = step;
  if (const auto session = session_.lock()) {
    session->core().metrics.drops += count;
  }
}

bool Stream::wantsToCatchUp() {
  const std::lock_guard lock(mutex_);
  isReminded_ = false;
  return !isClosed_ && isBehind_ && isTimely() && isReady(allowedSequence_);
}

FrameBase Stream::base() const {
  const std::lock_guard lock(mutex_);
  return base_;
}

void Stream::forgetBase() {
  const std::lock_guard lock(mutex_);
  base_ = {};
}

void Stream::send(std::uint64_t step, bool isFinished, StreamFrame frame) {
  const auto session = session_.lock();
  // a frame that never fits the outbox would cost the viewer its connection
  if (const std::uint64_t bytes = frame.body.json.size() + frame.body.blocks.totalBytes(); bytes > outboxBytes_) {
    end("a frame has " + std::to_string(bytes) + " bytes, and at most " + std::to_string(outboxBytes_) +
        " may be on their way (outboxBytes). Select fewer symbols, take blocks in single precision, or start the "
        "server with a higher --limit outboxBytes=N.");
    return;
  }
  const std::lock_guard lock(mutex_);
  if (isClosed_ || session == nullptr) {
    return;
  }
  protocol::StreamData data;
  data.stream = id_;
  data.simulation = params_.simulation;
  data.step = step;
  data.sequence = nextSequence_++;
  data.isKey = frame.isKey;
  // a step that was left out first and is shown now is not missed
  data.missed = missed_ - (lastMissedStep_ == step ? 1 : 0);
  data.isFinished = isFinished;
  data.body = std::move(frame.body);
  missed_ = 0;
  lastMissedStep_.reset();
  isBehind_ = false;
  base_ = std::move(frame.base);
  if (params_.maximumHertz > 0.0) {
    nextTime_ = Clock::now() +
                std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / params_.maximumHertz));
  }
  ++session->core().metrics.frames;
  session->notify("stream.data", protocol::encode(std::move(data)));
}

void Stream::end(const std::string& reason) {
  const auto session = session_.lock();
  const std::lock_guard lock(mutex_);
  if (isClosed_ || session == nullptr) {
    return;
  }
  isClosed_ = true;
  base_ = {};
  protocol::JsonWriter params;
  params.beginObject().key("stream").text(id_).key("reason").text(reason).endObject();
  session->notify("stream.end", params.take());
}

void Stream::acknowledge(const protocol::StreamAckParams& ack) {
  const std::lock_guard lock(mutex_);
  if (!params_.credits) {
    return;
  }
  // states that were handed over before, but for the last one, are missed whether or not their turn has come
  if (const std::uint64_t last = lastNumber_ == nullptr ? 0 : lastNumber_->load(); last > allowedFrom_) {
    allowedBefore_ = allowedSequence_;
    allowedFrom_ = last;
  }
  if (ack.sequence && *ack.sequence < nextSequence_) {
    allowedSequence_ = std::max(allowedSequence_, *ack.sequence + 1 + *params_.credits);
  }
  // never more than the viewer asked for at the start, beyond what it has not acknowledged
  allowedSequence_ = std::min(allowedSequence_ + ack.credits, nextSequence_ + *params_.credits);
}

void Stream::close() {
  const std::lock_guard lock(mutex_);
  isClosed_ = true;
  base_ = {};
}

bool Stream::isClosed() const {
  const std::lock_guard lock(mutex_);
  return isClosed_ || session_.expired();
}

}  // namespace espalier::server
