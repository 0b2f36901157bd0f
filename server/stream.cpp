#include "server/stream.h"

#include <algorithm>

#include "protocol/codec.h"
#include "server/geometry_frame.h"
#include "server/server_core.h"
#include "server/session.h"
#include "server/translate.h"

namespace espalier::server {

Stream::Stream(std::string id, protocol::StreamOpenParams params, std::weak_ptr<Session> session,
               std::size_t readyBytes)
    : id_(std::move(id)),
      params_(std::move(params)),
      session_(std::move(session)),
      readyBytes_(readyBytes),
      allowedSequence_(params_.credits.value_or(0)) {}

bool Stream::isReady() const {
  const auto session = session_.lock();
  return session != nullptr && session->outboxBytes() < readyBytes_ &&
         (!params_.credits || nextSequence_ < allowedSequence_);
}

bool Stream::wantsFrame(std::uint64_t step) {
  const std::lock_guard lock(mutex_);
  if (isClosed_ || step % params_.every != 0) {
    return false;
  }
  if (isReady()) {
    return true;
  }
  ++missed_;
  lastMissedStep_ = step;
  if (const auto session = session_.lock()) {
    ++session->core().metrics.drops;
  }
  return false;
}

bool Stream::wantsToCatchUp() {
  const std::lock_guard lock(mutex_);
  return !isClosed_ && missed_ > 0 && isReady();
}

void Stream::send(std::uint64_t step, bool isFinished, protocol::Body body) {
  const auto session = session_.lock();
  // what can never be sent would cost the viewer its connection
  const std::uint64_t bytes = body.json.size() + body.blocks.totalBytes();
  if (const std::uint64_t bound = 4 * readyBytes_; bytes > bound) {
    end("a frame has " + std::to_string(bytes) + " bytes, and at most " + std::to_string(bound) +
        " may be on their way (outboxBytes). Select fewer symbols, take blocks in single precision, or start the "
        "server "
        "with a higher --limit outboxBytes=N.");
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
  // a step that was left out and is shown now after all was not missed
  data.missed = missed_ - (lastMissedStep_ == step ? 1 : 0);
  data.isFinished = isFinished;
  data.body = std::move(body);
  missed_ = 0;
  lastMissedStep_.reset();
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
  protocol::JsonWriter params;
  params.beginObject().key("stream").text(id_).key("reason").text(reason).endObject();
  session->notify("stream.end", params.take());
}

void Stream::acknowledge(const protocol::StreamAckParams& ack) {
  const std::lock_guard lock(mutex_);
  if (!params_.credits) {
    return;
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
}

bool Stream::isClosed() const {
  const std::lock_guard lock(mutex_);
  return isClosed_ || session_.expired();
}

std::variant<protocol::Body, core::SimulationError> frameBody(
    const protocol::StreamOpenParams& params, const simulation::Simulation& simulation, double milliseconds,
    std::optional<std::vector<turtle::TurtleRecord>>& records) {
  if (params.what == "statistics") {
    protocol::JsonWriter body;
    write(body, toStatistics(simulation.statistics(), milliseconds));
    return protocol::Body(body.take());
  }
  if (params.what == "string") {
    const std::uint32_t plant = params.select.plants.empty() ? 0 : params.select.plants.front();
    protocol::JsonWriter body;
    body.key("string").text(plant < simulation.plantCount() ? simulation.stringText(plant) : std::string());
    return protocol::Body(body.take());
  }
  if (params.what == "geometry") {
    return geometryBody(simulation);
  }
  if (!records) {
    auto made = simulation.turtleRecords();
    if (auto* error = std::get_if<core::SimulationError>(&made)) {
      return std::move(*error);
    }
    records = std::move(std::get<std::vector<turtle::TurtleRecord>>(made));
  }
  try {
    return params.isInBlocks ? encodeTurtleBlocks(*records, simulation.program(), params)
                             : protocol::Body(encodeTurtleRecords(*records, simulation.program(), params.select));
  } catch (const protocol::NonFiniteNumber&) {
    return core::SimulationError{.code = core::SimulationErrorCode::NonFinite,
                                 .message = "The turtle went to a position that is NaN or infinite. Correct the model.",
                                 .step = simulation.completedSteps()};
  }
}

}  // namespace espalier::server
