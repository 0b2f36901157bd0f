#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/byte_source.h"
#include "engine/core/limits.h"
#include "engine/core/simulation_error.h"
#include "engine/core/streams.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/environment_process.h"

namespace espalier::simulation {

/// First bytes of a trace, then the version as a little-endian 32-bit number. The layout is in FORMATS.md.
inline constexpr std::string_view kTraceMagic = "ESPTRACE";
inline constexpr std::uint32_t kTraceVersion = 1;

/// The kinds of events, in their order.
enum class TraceEventKind : std::uint8_t {
  Start = 1,     // where the run begins: snapshot, environment's description and context
  Step = 2,      // queries and their replies
  Tick = 3,      // a step without queries
  Failure = 4,   // the environment did not answer; `message` has the consequence
  Complete = 5,  // a step is complete: hashes of the plants
};

/// Hashes of the strings in pieces of so many modules, so that a difference can be placed.
inline constexpr std::uint64_t kTracePieceModules = 64;

/// One event as it is in a trace; which members are filled depends on the kind.
struct TraceEvent {
  TraceEventKind kind = TraceEventKind::Start;
  // Start
  std::string snapshot;
  turtle::EnvironmentDescription description;
  turtle::EnvironmentContext context;
  bool hasEnvironment = false;
  // Step, Tick
  turtle::QueryBatch queries;
  turtle::ReplyBatch replies;
  std::vector<std::uint32_t> replyChecks;  // of each query's replies (n)
  std::string damage;                      // why the event cannot be trusted; empty: it has its checksum
  // Tick, Failure, Complete
  std::uint64_t step = 0;   // completed steps; of Complete: with this one
  std::string message;      // Failure
  std::uint64_t bytes = 0;  // that the event has in the trace
  // Complete
  std::uint64_t hash = 0;                               // of the plants
  std::vector<std::vector<std::uint32_t>> pieceHashes;  // of each plant
};

/// Writes a trace while a simulation runs. The recording process notes the dialogue with the environment; the caller
/// reports that a run begins or that a step is complete.
///
///     auto recorder = std::make_shared<TraceRecorder>(sink);
///     Simulation simulation(program, placements, record(std::move(process), recorder), options);
///     simulation.rewind();
///     recorder->begin(simulation);
///     while (...) { simulation.step(); recorder->complete(simulation); }
class TraceRecorder {
 public:
  /// `sink` must live as long as the recorder.
  explicit TraceRecorder(core::ByteSink& sink) : sink_(&sink) {}

  /// After rewind() or restore(): the run starts, again when it was rewound.
  void begin(Simulation& simulation);
  /// After each step that succeeded.
  void complete(const Simulation& simulation);
  /// The environment failed; `message` has the consequence.
  void fail(std::uint64_t step, std::string_view message);

  // for the recording process
  void opened(const turtle::EnvironmentContext& context) { context_ = context; }
  void answered(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies);
  void ticked(std::uint64_t step);

 private:
  void write(TraceEventKind kind, std::string_view content);

  core::ByteSink* sink_;
  turtle::EnvironmentContext context_;
  bool hasBegun_ = false;
};

/// The process with its dialogue recorded. Null stays null: a simulation without an environment can be traced too.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> record(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                                 std::shared_ptr<TraceRecorder> recorder);

/// Reads an untrusted trace event by event, and holds one event at a time. A damaged, cut or too long event is an error
/// that names its place.
class TraceReader {
 public:
  /// `source` must outlive the reader. A longer event than `maximumEventBytes` is refused before it is read.
  explicit TraceReader(core::ByteSource& source, std::uint64_t maximumEventBytes = UINT64_MAX)
      : source_(&source), maximumEventBytes_(maximumEventBytes) {}

  /// The next event, nothing at the end, or an error sentence.
  [[nodiscard]] tl::expected<std::optional<TraceEvent>, std::string> next();

 private:
  /// Puts the next bytes into piece_. An error sentence; `isShort`: there are fewer.
  [[nodiscard]] std::optional<std::string> take(std::uint64_t count, bool& isShort);
  [[nodiscard]] std::optional<std::string> takeHead();

  core::ByteSource* source_;
  std::uint64_t maximumEventBytes_;
  std::uint64_t position_ = 0;  // bytes that were read
  std::string piece_;           // the bytes that were read last
};

/// Where a run that is made again is not the recorded one.
struct Divergence {
  std::uint64_t step = 0;  // completed steps when it showed
  std::optional<std::uint32_t> plant;
  std::optional<std::uint64_t> module;  // index in the plant's string
  std::string message;                  // a whole sentence that names all of them
};

struct ReplayResult {
  std::uint64_t steps = 0;
  std::uint64_t queries = 0;
  std::optional<Divergence> divergence;
};

/// An observer of a replay, as another environment that receives the same queries. Empty functions are not called.
struct ReplayWitness {
  bool needsGeometry = false;  // the queries come with the geometry of the plants
  std::function<void(const turtle::EnvironmentContext&)> opened;
  std::function<void(const turtle::QueryBatch&, const turtle::ReplyBatch& recorded)> asked;
  std::function<void(std::uint64_t step)> ticked;
};

/// Makes the recorded run again without its environment: the model and the replies come from the trace. Stops at the
/// first difference in a query, a reply or a string. An error sentence when the trace cannot be read or its model does
/// not compile. `threads` and `limits` as in SimulationOptions. The questions and replies of one step have at most
/// `maximumEventBytes` in the trace: the replay holds them together.
[[nodiscard]] tl::expected<ReplayResult, std::string> replayTrace(core::ByteSource& trace,
                                                                  std::uint64_t maximumEventBytes, unsigned threads,
                                                                  const ReplayWitness& witness = {},
                                                                  const core::Limits& limits = {});

/// The same for a trace in memory.
[[nodiscard]] tl::expected<ReplayResult, std::string> replayTrace(std::string_view trace, unsigned threads,
                                                                  const ReplayWitness& witness = {},
                                                                  const core::Limits& limits = {});

}  // namespace espalier::simulation
