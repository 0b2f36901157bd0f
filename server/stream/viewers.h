#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/simulation/view_drawing.h"
#include "server/running/account.h"
#include "server/running/live_limits.h"
#include "server/running/worker_pool.h"
#include "server/stream/query_recorder.h"
#include "server/stream/stream.h"
#include "server/stream/stream_frame.h"

namespace espalier::server {

class Log;
class TurnMeter;

/// A state of a simulation on its way to the viewers.
struct ShownState {
  std::shared_ptr<const simulation::PlantsView> plants;
  double milliseconds = 0.0;                   // that its last step took
  std::shared_ptr<const QueryRecord> queries;  // of its last step; null: not recorded
  bool isDue = true;                           // a change was just completed; else only for viewers that are behind
  std::shared_ptr<Stream> first;               // only for this viewer, which has just come; null: for all
};

/// The viewers of one simulation. The worker that owns the simulation hands over states and goes on with the next step.
/// Another worker makes the frames, one state after the other.
///
/// States wait in a short queue, so that viewers of small plants see every step. When the queue is full, further states
/// are skipped and count as missed. Once the queue is empty again, `askLatest` is called. So the viewers
/// share at most the memory of the queue with the simulation. Thread-safe.
class Viewers final : public std::enable_shared_from_this<Viewers> {
 public:
  struct Options {
    std::string simulation;              // the name
    Account* account = nullptr;          // that has the memory
    const LiveLimits* limits = nullptr;  // callSeconds, for the frames of one state; streamBytes
    std::function<void()> askLatest;     // calls for the latest state, with isDue false; from any thread
  };
  Viewers(Options options, WorkerPool& pool, const Log& log);

  // for the worker that owns the simulation
  /// The viewer gets its first frame of the state that is handed over next.
  void add(std::shared_ptr<Stream> stream);
  [[nodiscard]] bool exist() const { return count_ > 0; }
  [[nodiscard]] bool wantQueries() const { return wantQueries_; }
  [[nodiscard]] bool wantDifferences() const { return wantDifferences_; }
  /// Whether a state with so many bytes of strings is to be handed over. If not, it is skipped. O(1).
  [[nodiscard]] bool takeState(std::uint64_t step, std::uint64_t bytes, bool isDue);
  /// O(1); wakes a worker when none makes frames.
  void handOver(ShownState state);

  // for any thread
  /// That are kept to tell differences.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }
  /// Ends all streams with a reason.
  void end(const std::string& reason);

 private:
  struct Viewer {
    std::shared_ptr<Stream> stream;
    std::uint64_t firstState = 0;  // it sees no earlier ones
  };
  struct Waiting {
    ShownState state;
    std::uint64_t number = 0;
    std::vector<StepRange> skipped;  // before it
  };

  void schedule();  // with mutex_ held
  void work();
  void giveUp();  // the frames take too long
  void setMeter(TurnMeter* meter);
  void show(const Waiting& waiting, TurnMeter& meter);
  void showTo(Stream& stream, FrameMaker& maker, TurnMeter& meter);
  [[nodiscard]] std::string memoryProblem(const TurnMeter& meter) const;
  void boundBases(const std::vector<Viewer>& viewers);
  void noteWishes();  // with mutex_ held

  const Options options_;
  WorkerPool* pool_;
  const Log* log_;
  std::atomic<std::size_t> count_{0};
  std::atomic<bool> wantQueries_{false};
  std::atomic<bool> wantDifferences_{false};
  std::atomic<std::uint64_t> bytes_{0};
  const std::shared_ptr<std::atomic<std::uint64_t>> lastNumber_ = std::make_shared<std::atomic<std::uint64_t>>(0);

  std::mutex mutex_;
  std::vector<Viewer> viewers_;
  std::deque<Waiting> queue_;
  std::uint64_t queuedBytes_ = 0;   // of strings
  std::vector<StepRange> skipped_;  // since the last state that was handed over
  bool isStale_ = false;            // a state was skipped
  bool isWorking_ = false;          // a task is posted or runs
  TurnMeter* meter_ = nullptr;      // of the frames that are being made

  // for the worker that makes frames
  Holding kept_;  // bytes_, in the account
  simulation::ViewDrawing drawing_;
};

}  // namespace espalier::server
