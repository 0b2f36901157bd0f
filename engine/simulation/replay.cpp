#include <cmath>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/language/compiler.h"
#include "engine/simulation/snapshot.h"
#include "engine/simulation/trace.h"
#include "engine/simulation/trace_format.h"

namespace espalier::simulation {
namespace {

std::string numberText(double value) {
  std::string text;
  core::appendNumber(text, value, core::NumberStyle::Shortest);
  return text;
}

bool isSame(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

/// The replies of a trace in place of the environment. Compares every question with the recorded one.
class ReplayProcess final : public turtle::EnvironmentProcess {
 public:
  ReplayProcess(turtle::EnvironmentDescription description, std::vector<std::string> symbols,
                const ReplayWitness& witness)
      : description_(std::move(description)), symbols_(std::move(symbols)), witness_(&witness) {}

  /// The events that the next calls must fit, one after the other; null: none.
  void expect(std::vector<TraceEvent>* events) {
    events_ = events;
    next_ = 0;
  }
  [[nodiscard]] std::optional<Divergence> takeDivergence() { return std::exchange(divergence_, std::nullopt); }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return description_; }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    const TraceEvent* const expected = next();
    if (queries.size() == 0 && (expected == nullptr || expected->kind == TraceEventKind::Tick)) {
      // the recorded environment needed no geometry, the witness does
      tell(queries, replies);
      return std::nullopt;
    }
    if (expected == nullptr || expected->kind != TraceEventKind::Step) {
      return differ({queries.step, queries.plant[0], queries.module[0],
                     placeOf(queries, 0) + ": the run asks its environment, the recorded one did not."});
    }
    if (auto found = differenceOf(expected->queries, queries)) {
      return differ(std::move(*found));
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      if (checkOfReply(queries, expected->replies, query) != expected->replyChecks[query]) {
        return differ({queries.step, queries.plant[query], queries.module[query],
                       placeOf(queries, query) +
                           ": the recorded reply is not the one that was given: the trace was changed there."});
      }
    }
    replies.values = expected->replies.values;
    replies.isSet = expected->replies.isSet;
    replies.surplusCount = expected->replies.surplusCount;
    tell(queries, replies);
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t step) override {
    const TraceEvent* const expected = next();
    // a process that needs geometry is asked a step without queries
    if (expected != nullptr && expected->kind == TraceEventKind::Step && expected->queries.size() > 0) {
      const turtle::QueryBatch& recorded = expected->queries;
      return differ({step, recorded.plant[0], recorded.module[0],
                     placeOf(recorded, 0) + ": the recorded run asked its environment, this one asks nothing."});
    }
    if (witness_->ticked) {
      witness_->ticked(step);
    }
    return std::nullopt;
  }
  // iterated coupling gives it back its state before each iteration
  [[nodiscard]] std::string save() const override { return "replayed"; }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view) override { return std::nullopt; }

 private:
  void tell(const turtle::QueryBatch& queries, const turtle::ReplyBatch& replies) const {
    if (witness_->asked) {
      witness_->asked(queries, replies);
    }
  }

  [[nodiscard]] const TraceEvent* next() {
    return events_ == nullptr || next_ == events_->size() ? nullptr : &(*events_)[next_++];
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> differ(Divergence divergence) {
    divergence_ = std::move(divergence);
    return turtle::EnvironmentError{divergence_->message, false};
  }

  [[nodiscard]] std::string placeOf(const turtle::QueryBatch& queries, std::size_t query) const {
    const core::SymbolId symbol = queries.symbol[query];
    return "step " + std::to_string(queries.step) + ", plant " + std::to_string(queries.plant[query]) + ", module " +
           std::to_string(queries.module[query]) + " ('" + (symbol < symbols_.size() ? symbols_[symbol] : "?") + "')";
  }

  /// The first query that is not the recorded one.
  [[nodiscard]] std::optional<Divergence> differenceOf(const turtle::QueryBatch& recorded,
                                                       const turtle::QueryBatch& now) const {
    const std::size_t common = std::min(recorded.size(), now.size());
    for (std::size_t query = 0; query < common; ++query) {
      const std::string what = whatDiffers(recorded, now, query);
      if (!what.empty()) {
        return Divergence{now.step, now.plant[query], now.module[query], placeOf(now, query) + ": " + what};
      }
    }
    if (recorded.size() == now.size()) {
      return std::nullopt;
    }
    const turtle::QueryBatch& longer = recorded.size() > common ? recorded : now;
    return Divergence{now.step, longer.plant[common], longer.module[common],
                      placeOf(longer, common) + ": the recorded run asks " + std::to_string(recorded.size()) +
                          " queries in this step, this one " + std::to_string(now.size()) + "."};
  }

  [[nodiscard]] std::string whatDiffers(const turtle::QueryBatch& recorded, const turtle::QueryBatch& now,
                                        std::size_t query) const {
    if (recorded.plant[query] != now.plant[query] || recorded.module[query] != now.module[query]) {
      return "the recorded run asks from " + placeOf(recorded, query) + " instead.";
    }
    if (recorded.symbol[query] != now.symbol[query]) {
      return "the recorded query comes from a module of another name.";
    }
    const auto before = recorded.parametersOf(query);
    const auto after = now.parametersOf(query);
    if (before.size() != after.size()) {
      return "the recorded query has " + std::to_string(before.size()) + " parameters, this one " +
             std::to_string(after.size()) + ".";
    }
    for (std::size_t k = 0; k < before.size(); ++k) {
      if (!isSame(before[k], after[k])) {
        return "parameter " + std::to_string(k + 1) + " is " + numberText(after[k]) + ", it was " +
               numberText(before[k]) + ".";
      }
    }
    const auto vector = [query](const std::vector<core::Vec3>& a, const std::vector<core::Vec3>& b) {
      return a.size() == b.size() && !a.empty() &&
             !(isSame(a[query].x, b[query].x) && isSame(a[query].y, b[query].y) && isSame(a[query].z, b[query].z));
    };
    if (vector(recorded.position, now.position)) {
      const core::Vec3& a = recorded.position[query];
      const core::Vec3& b = now.position[query];
      return "the position is (" + numberText(b.x) + ", " + numberText(b.y) + ", " + numberText(b.z) + "), it was (" +
             numberText(a.x) + ", " + numberText(a.y) + ", " + numberText(a.z) + ").";
    }
    if (vector(recorded.heading, now.heading) || vector(recorded.left, now.left) || vector(recorded.up, now.up)) {
      return "the turtle has another orientation.";
    }
    return {};
  }

  turtle::EnvironmentDescription description_;
  std::vector<std::string> symbols_;
  const ReplayWitness* witness_;
  std::vector<TraceEvent>* events_ = nullptr;
  std::size_t next_ = 0;  // of events_
  std::optional<Divergence> divergence_;
};

/// Where the plants are not the recorded ones, or nothing.
std::optional<Divergence> differenceOf(const TraceEvent& recorded, const Simulation& simulation) {
  if (recorded.hash == simulation.plantsHash()) {
    return std::nullopt;
  }
  Divergence divergence;
  divergence.step = simulation.completedSteps();
  const std::string after = "after step " + std::to_string(divergence.step);
  for (std::size_t plant = 0; plant < simulation.plantCount() && plant < recorded.pieceHashes.size(); ++plant) {
    const auto now = pieceHashesOf(simulation.program(plant), simulation.string(plant));
    const auto& before = recorded.pieceHashes[plant];
    std::size_t piece = 0;
    while (piece < now.size() && piece < before.size() && now[piece] == before[piece]) {
      ++piece;
    }
    if (piece < now.size() || piece < before.size()) {
      divergence.plant = static_cast<std::uint32_t>(plant);
      divergence.module = piece * kTracePieceModules;
      divergence.message = after + ", plant " + std::to_string(plant) + ", module " +
                           std::to_string(*divergence.module) + " or one of the " +
                           std::to_string(kTracePieceModules - 1) + " behind it: the string is not the recorded one.";
      return divergence;
    }
  }
  divergence.message = after + ": the strings are the recorded ones, variables or random numbers are not.";
  return divergence;
}

/// The run of a trace, made again event by event.
class Replay {
 public:
  Replay(core::ByteSource& trace, std::uint64_t maximumEventBytes, unsigned threads, const ReplayWitness& witness,
         const core::Limits& limits)
      : reader_(trace, maximumEventBytes),
        maximumEventBytes_(maximumEventBytes),
        threads_(threads),
        witness_(witness),
        limits_(limits) {}

  /// Nothing, or an error sentence.
  [[nodiscard]] std::optional<std::string> run() {
    while (true) {
      auto read = reader_.next();
      if (!read) {
        return std::move(read.error());
      }
      auto& event = *read;
      if (!event) {
        return simulation_ == nullptr ? std::optional<std::string>("the trace is empty.") : std::nullopt;
      }
      if (auto problem = take(std::move(*event))) {
        return problem;
      }
      if (result.divergence) {
        return std::nullopt;
      }
    }
  }

  ReplayResult result;

 private:
  [[nodiscard]] std::optional<std::string> take(TraceEvent event) {
    if (event.kind == TraceEventKind::Start) {
      return start(event);
    }
    if (simulation_ == nullptr) {
      return "the trace does not begin with the start of a run: it is damaged.";
    }
    switch (event.kind) {
      case TraceEventKind::Step:
        result.queries += event.queries.size();
        // asked from the beginning again: the step had failed
        if (event.queries.iteration == 0) {
          forgetQuestions();
        }
        askedBytes_ += event.bytes;
        if (askedBytes_ > maximumEventBytes_) {
          return "step " + std::to_string(simulation_->completedSteps() + 1) + " has more than " +
                 std::to_string(maximumEventBytes_) +
                 " bytes of questions and replies: the trace is damaged, or needs more memory.";
        }
        asked_.push_back(std::move(event));
        break;
      case TraceEventKind::Tick:
        forgetQuestions();
        asked_.push_back(std::move(event));
        break;
      case TraceEventKind::Complete: {
        std::string damage;
        for (const TraceEvent& asked : asked_) {
          damage = damage.empty() ? asked.damage : damage;
        }
        makeStep(event);
        if (!result.divergence && !damage.empty()) {
          return damage;
        }
        break;
      }
      case TraceEventKind::Failure:
      case TraceEventKind::Start:
        break;
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<std::string> start(TraceEvent& event) {
    auto read = readSnapshotInfo(event.snapshot);
    if (!read) {
      return read.error().message;
    }
    auto& info = *read;
    auto compiled = compileModels(info, limits_);
    if (!compiled) {
      return "the model in the trace does not compile with this program: " +
             (compiled.error().entries().empty() ? std::string("no reason was given")
                                                 : compiled.error().entries().front().message) +
             ".";
    }
    // older traces hold the world only beside the snapshot
    if (info.world != turtle::World{}) {
      event.context.world = info.world;
    }
    SimulationOptions options;
    options.name = info.name;
    options.seed = info.seed;
    options.hasSeed = info.hasSeed;
    options.threads = threads_;
    options.limits = limits_;
    options.world = event.context.world;
    std::unique_ptr<ReplayProcess> process;
    if (event.hasEnvironment) {
      // the recorded environment is not here, so only the witness can need geometry
      event.description.needs.geometry = witness_.needsGeometry;
      process = std::make_unique<ReplayProcess>(event.description, event.context.symbols, witness_);
    }
    process_ = process.get();
    simulation_ = std::make_unique<Simulation>(std::move(*compiled), std::vector<PlantOrigin>(info.plantCount),
                                               std::move(process), std::move(options));
    if (const auto error = simulation_->restore(event.snapshot)) {
      return error->message;
    }
    forgetQuestions();
    if (witness_.opened) {
      witness_.opened(event.context);
    }
    return std::nullopt;
  }

  void forgetQuestions() {
    asked_.clear();
    askedBytes_ = 0;
  }

  /// Makes the step that the recorded run made, with the replies that it got.
  void makeStep(const TraceEvent& complete) {
    if (process_ != nullptr) {
      process_->expect(&asked_);
    }
    const auto error = simulation_->step();
    if (process_ != nullptr) {
      result.divergence = process_->takeDivergence();
      process_->expect(nullptr);
    }
    forgetQuestions();
    if (result.divergence) {
      return;
    }
    if (error) {
      result.divergence = Divergence{simulation_->completedSteps(), error->plant, error->module,
                                     "the step fails, the recorded one did not: " + error->message};
      return;
    }
    ++result.steps;
    result.divergence = differenceOf(complete, *simulation_);
  }

  TraceReader reader_;
  std::uint64_t maximumEventBytes_;
  unsigned threads_;
  const ReplayWitness& witness_;
  core::Limits limits_;
  std::unique_ptr<Simulation> simulation_;
  ReplayProcess* process_ = nullptr;  // the simulation's; null: it has none
  std::vector<TraceEvent> asked_;     // the questions of the step under way
  std::uint64_t askedBytes_ = 0;      // of them in the trace
};

}  // namespace

tl::expected<ReplayResult, std::string> replayTrace(std::string_view trace, unsigned threads,
                                                    const ReplayWitness& witness, const core::Limits& limits) {
  core::ViewSource source(trace);
  return replayTrace(source, UINT64_MAX, threads, witness, limits);
}

tl::expected<ReplayResult, std::string> replayTrace(core::ByteSource& trace, std::uint64_t maximumEventBytes,
                                                    unsigned threads, const ReplayWitness& witness,
                                                    const core::Limits& limits) {
  Replay replay(trace, maximumEventBytes, threads, witness, limits);
  if (auto problem = replay.run()) {
    return tl::unexpected(std::move(*problem));
  }
  return std::move(replay.result);
}

}  // namespace espalier::simulation
