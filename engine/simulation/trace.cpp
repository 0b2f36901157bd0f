#include "engine/simulation/trace.h"

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

std::variant<std::optional<TraceEvent>, std::string> TraceReader::next() {
  if (position_ == 0) {
    ByteReader head(bytes_);
    if (head.raw(kTraceMagic.size()) != kTraceMagic) {
      return std::string("this is not a trace: it does not begin with " + std::string(kTraceMagic) + ".");
    }
    const std::uint32_t version = head.number32();
    if (head.hasFailed() || version == 0 || version > kTraceVersion) {
      return "this trace has version " + std::to_string(version) + ", this program reads 1 to " +
             std::to_string(kTraceVersion) + ". Use a newer program.";
    }
    position_ = kTraceMagic.size() + 4;
  }
  if (position_ == bytes_.size()) {
    return std::optional<TraceEvent>();
  }
  const std::string place = "at byte " + std::to_string(position_);
  ByteReader reader(bytes_.substr(position_));
  const std::uint64_t length = reader.number64();
  const std::string_view content = reader.raw(length);
  const std::uint64_t checksum = reader.number64();
  if (reader.hasFailed()) {
    return "the trace is cut off in the event " + place + ": the program that wrote it ended early.";
  }
  TraceEvent event;
  if (!decodeEvent(content, event)) {
    return "the event " + place + " cannot be read: the trace is damaged.";
  }
  if (checksum != checksumOf(content)) {
    event.damage = "the event " + place + " does not have its checksum: the trace is damaged.";
    // a changed query or reply is for the replay to find and to name
    if (event.kind != TraceEventKind::Step) {
      return event.damage;
    }
  }
  position_ += 16 + length;
  return std::optional<TraceEvent>(std::move(event));
}

}  // namespace espalier::simulation
