#include "engine/simulation/trace.h"

#include <algorithm>

#include "engine/core/hash.h"
#include "engine/simulation/byte_reader.h"
#include "engine/simulation/byte_writer.h"
#include "engine/simulation/trace_format.h"
#include "engine/turtle/field.h"

namespace espalier::simulation {
namespace {

std::uint64_t checksumOf(std::string_view bytes) {
  core::Hasher hasher;
  hasher.bytes(bytes);
  return hasher.value();
}

/// Passes every call on and records the answers.
class RecordingProcess final : public turtle::EnvironmentProcess {
 public:
  RecordingProcess(std::unique_ptr<turtle::EnvironmentProcess> process, std::shared_ptr<TraceRecorder> recorder)
      : process_(std::move(process)), recorder_(std::move(recorder)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return process_->describe(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    recorder_->opened(context);
    return process_->open(context);
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    auto error = process_->step(queries, replies);
    if (error) {
      recorder_->fail(queries.step, error->message);
    } else {
      recorder_->answered(queries, replies);
    }
    return error;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) override {
    auto error = process_->tick(step);
    if (error) {
      recorder_->fail(step, error->message);
    } else {
      recorder_->ticked(step);
    }
    return error;
  }
  [[nodiscard]] std::string save() const override { return process_->save(); }
  [[nodiscard]] std::vector<turtle::Field> fields() const override { return process_->fields(); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return process_->restore(state);
  }

 private:
  std::unique_ptr<turtle::EnvironmentProcess> process_;
  std::shared_ptr<TraceRecorder> recorder_;
};

}  // namespace

void TraceRecorder::write(TraceEventKind kind, std::string_view content) {
  ByteWriter frame;
  if (!hasBegun_) {
    // queries before the start belong to no run
    if (kind != TraceEventKind::Start) {
      return;
    }
    frame.raw(kTraceMagic);
    frame.number32(kTraceVersion);
    hasBegun_ = true;
  }
  frame.number64(content.size());
  sink_->write(frame.bytes());
  sink_->write(content);
  ByteWriter check;
  check.number64(checksumOf(content));
  sink_->write(check.bytes());
}

void TraceRecorder::begin(Simulation& simulation) {
  core::StringSink snapshot;
  simulation.save(snapshot);
  std::optional<turtle::EnvironmentDescription> description;
  if (simulation.environment() != nullptr) {
    description = simulation.environment()->describe();
  }
  write(TraceEventKind::Start, encodeStart(snapshot.text(), description ? &*description : nullptr, context_));
}

void TraceRecorder::complete(const Simulation& simulation) {
  write(TraceEventKind::Complete, encodeComplete(simulation));
}

void TraceRecorder::fail(std::uint64_t step, std::string_view message) {
  write(TraceEventKind::Failure, encodeFailure(step, message));
}

void TraceRecorder::answered(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies) {
  write(TraceEventKind::Step, encodeStep(queries, replies));
}

void TraceRecorder::ticked(std::uint64_t step) {
  write(TraceEventKind::Tick, encodeTick(step));
}

std::unique_ptr<turtle::EnvironmentProcess> record(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                   std::shared_ptr<TraceRecorder> recorder) {
  return process == nullptr ? nullptr : std::make_unique<RecordingProcess>(std::move(process), std::move(recorder));
}

std::optional<std::string> TraceReader::take(std::uint64_t count, bool& isShort) {
  // a length is a claim: memory is taken for the bytes that are there
  constexpr std::uint64_t kPieceBytes = std::uint64_t{1} << 20U;
  piece_.clear();
  while (piece_.size() < count) {
    const std::uint64_t wanted = std::min(kPieceBytes, count - piece_.size());
    const std::size_t before = piece_.size();
    if (auto problem = source_->read(static_cast<std::size_t>(wanted), piece_)) {
      return problem;
    }
    if (piece_.size() - before < wanted) {
      break;
    }
  }
  isShort = piece_.size() < count;
  position_ += piece_.size();
  return std::nullopt;
}

std::optional<std::string> TraceReader::takeHead() {
  bool isShort = false;
  if (auto problem = take(kTraceMagic.size() + 4, isShort)) {
    return problem;
  }
  ByteReader head(piece_);
  if (head.raw(kTraceMagic.size()) != kTraceMagic) {
    return "this is not a trace: it does not begin with " + std::string(kTraceMagic) + ". --trace FILE records one.";
  }
  const std::uint32_t version = head.number32();
  if (head.hasFailed() || version == 0 || version > kTraceVersion) {
    return "this trace has version " + std::to_string(version) + ", this program reads 1 to " +
           std::to_string(kTraceVersion) + ". Use a newer program.";
  }
  return std::nullopt;
}

tl::expected<std::optional<TraceEvent>, std::string> TraceReader::next() {
  if (position_ == 0) {
    if (auto problem = takeHead()) {
      return tl::unexpected(std::move(*problem));
    }
  }
  const std::string place = "at byte " + std::to_string(position_);
  const std::string isCut = "the trace is cut off in the event " + place + ": the program that wrote it ended early.";
  bool isShort = false;
  if (auto problem = take(8, isShort)) {
    return tl::unexpected(std::move(*problem));
  }
  if (piece_.empty()) {
    return std::optional<TraceEvent>();
  }
  if (isShort) {
    return tl::unexpected(isCut);
  }
  const std::uint64_t length = ByteReader(piece_).number64();
  if (length > maximumEventBytes_) {
    return tl::unexpected("the event " + place + " has " + std::to_string(length) + " bytes, of which at most " +
                          std::to_string(maximumEventBytes_) +
                          " are read: the trace is damaged, or needs more memory.");
  }
  if (auto problem = take(length, isShort)) {
    return tl::unexpected(std::move(*problem));
  }
  if (isShort) {
    return tl::unexpected(isCut);
  }
  TraceEvent event;
  event.bytes = length;
  const bool isEvent = decodeEvent(piece_, event);
  // zeros are no event: the checksum of much would take long
  const std::uint64_t found = isEvent ? checksumOf(piece_) : 0;
  if (auto problem = take(8, isShort)) {
    return tl::unexpected(std::move(*problem));
  }
  if (isShort) {
    return tl::unexpected(isCut);
  }
  if (!isEvent) {
    return tl::unexpected("the event " + place + " cannot be read: the trace is damaged.");
  }
  if (ByteReader(piece_).number64() != found) {
    event.damage = "the event " + place + " does not have its checksum: the trace is damaged.";
    // a changed query or reply is for the replay to find and to name
    if (event.kind != TraceEventKind::Step) {
      return tl::unexpected(std::move(event.damage));
    }
  }
  return std::optional<TraceEvent>(std::move(event));
}

}  // namespace espalier::simulation
