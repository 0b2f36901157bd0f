#include "server/stream/viewers.h"

#include <algorithm>
#include <new>
#include <utility>

#include "server/log.h"
#include "server/running/turn_meter.h"

namespace espalier::server {
namespace {

// states that wait: small plants are shown step by step, the memory for others stays small
constexpr std::size_t kMostWaiting = 1000;
constexpr std::uint64_t kMostWaitingBytes = 512'000;

std::uint64_t bytesOf(const simulation::PlantsView& view) {
  return view.statistics.bytes;
}

}  // namespace

Viewers::Viewers(Options options, WorkerPool& pool, const Log& log)
    : options_(std::move(options)), pool_(&pool), log_(&log), kept_(*options_.account, MemoryKind::Frames) {}

void Viewers::noteWishes() {
  count_ = viewers_.size();
  wantQueries_ = std::any_of(viewers_.begin(), viewers_.end(),
                             [](const Viewer& viewer) { return viewer.stream->params().what == "queries"; });
  wantDifferences_ = std::any_of(viewers_.begin(), viewers_.end(),
                                 [](const Viewer& viewer) { return viewer.stream->params().isDelta; });
}

void Viewers::add(std::shared_ptr<Stream> stream) {
  stream->follow(lastNumber_);
  const std::lock_guard lock(mutex_);
  viewers_.push_back({std::move(stream), *lastNumber_ + 1});
  noteWishes();
}

bool Viewers::takeState(std::uint64_t step, std::uint64_t bytes, bool isDue) {
  const std::lock_guard lock(mutex_);
  const bool isFree = queue_.empty() && !isWorking_;
  if (isFree || (queue_.size() < kMostWaiting && queuedBytes_ + bytes <= kMostWaitingBytes)) {
    return true;
  }
  isStale_ = true;
  if (isDue && !skipped_.empty() && skipped_.back().last + 1 == step) {
    skipped_.back().last = step;
  } else if (isDue) {
    skipped_.push_back({step, step});
  }
  return false;
}

void Viewers::handOver(ShownState state) {
  const std::lock_guard lock(mutex_);
  queuedBytes_ += bytesOf(*state.plants);
  const bool isForAll = state.first == nullptr;
  queue_.push_back({std::move(state), ++*lastNumber_, {}});
  if (isForAll) {
    queue_.back().skipped = std::exchange(skipped_, {});
    isStale_ = false;
  }
  schedule();
}

void Viewers::schedule() {
  if (!isWorking_ && !queue_.empty()) {
    isWorking_ = true;
    const auto self = shared_from_this();
    pool_->post({.run = [self] { self->work(); },
                 .lane = Lane::Frame,
                 .owner = options_.simulation,
                 .limit = std::chrono::seconds(options_.limits->get().callSeconds),
                 .onLimit = [self] { self->giveUp(); }});
  }
}

void Viewers::giveUp() {
  const std::lock_guard lock(mutex_);
  if (meter_ != nullptr) {
    meter_->stop();
  }
}

void Viewers::setMeter(TurnMeter* meter) {
  const std::lock_guard lock(mutex_);
  meter_ = meter;
}

void Viewers::work() {
  Waiting waiting;
  {
    const std::lock_guard lock(mutex_);
    // the streams have ended
    if (queue_.empty()) {
      isWorking_ = false;
      return;
    }
    waiting = std::move(queue_.front());
    queue_.pop_front();
    queuedBytes_ -= bytesOf(*waiting.state.plants);
  }
  std::string problem;
  TurnMeter meter(*options_.account, MemoryKind::Frames);
  const core::WorkMeter::Scope scope(&meter);
  setMeter(&meter);
  try {
    show(waiting, meter);
  } catch (const std::bad_alloc&) {
    problem = memoryProblem(meter);
  } catch (const std::exception& exception) {
    problem = std::string("Espalier has a bug: ") + exception.what() + ". Please report it.";
    log_->error("streams ended after an internal error: " + problem, {.simulation = options_.simulation});
  }
  setMeter(nullptr);
  // the simulation may write into the memory again
  drawing_.close();
  waiting = {};
  if (!problem.empty()) {
    end(problem);
  }
  bool isBehind = false;
  {
    const std::lock_guard lock(mutex_);
    isWorking_ = false;
    isBehind = queue_.empty() && std::exchange(isStale_, false);
    schedule();
  }
  if (isBehind) {
    options_.askLatest();
  }
}

std::string Viewers::memoryProblem(const TurnMeter& meter) const {
  return meter.isRefused()
             ? options_.account->memoryError().message
             : "The server has not enough memory for a frame. Select fewer symbols, or use a smaller model.";
}

void Viewers::show(const Waiting& waiting, TurnMeter& meter) {
  std::vector<Viewer> viewers;
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(viewers_, [](const Viewer& viewer) { return viewer.stream->isClosed(); });
    noteWishes();
    viewers = viewers_;
  }
  const ShownState& state = waiting.state;
  drawing_.show(state.plants);
  FrameMaker maker(drawing_, state.milliseconds, state.queries);
  for (const Viewer& viewer : viewers) {
    if (waiting.number < viewer.firstState) {
      continue;
    }
    Stream& stream = *viewer.stream;
    if (state.first != nullptr) {
      if (state.first == viewer.stream) {
        showTo(stream, maker, meter);
      }
      continue;
    }
    stream.skip(waiting.skipped);
    const Stream::Moment moment{state.plants->completedSteps, waiting.number};
    if (state.isDue ? stream.wantsFrame(moment) : stream.wantsToCatchUp()) {
      showTo(stream, maker, meter);
    }
  }
  boundBases(viewers);
}

void Viewers::showTo(Stream& stream, FrameMaker& maker, TurnMeter& meter) {
  const simulation::PlantsView& view = drawing_.view();
  tl::expected<StreamFrame, core::SimulationError> frame;
  try {
    frame = maker.make(stream.params(), stream.base());
  } catch (const std::bad_alloc&) {
    // other viewers may want less
    stream.end(memoryProblem(meter));
    (void)meter.tryAgain();
    return;
  }
  if (!frame) {
    stream.end(meter.isRefused()   ? memoryProblem(meter)
               : meter.isStopped() ? "The frames of this state compute longer than the limit callSeconds (" +
                                         std::to_string(options_.limits->get().callSeconds) +
                                         ") allows. Select fewer symbols, or draw less in homomorphism productions."
                                   : frame.error().message);
  } else {
    stream.send(view.completedSteps, view.isFinished, std::move(*frame));
  }
}

void Viewers::boundBases(const std::vector<Viewer>& viewers) {
  std::vector<FrameBase> bases;
  std::uint64_t bytes = 0;
  for (const Viewer& viewer : viewers) {
    FrameBase base = viewer.stream->base();
    if (base.isEmpty() || std::find(bases.begin(), bases.end(), base) != bases.end()) {
      continue;
    }
    if (bytes + base.bytes() > options_.limits->get().streamBytes) {
      viewer.stream->forgetBase();
      continue;
    }
    bytes += base.bytes();
    bases.push_back(std::move(base));
  }
  // records that no viewer refers to need not be kept
  if (std::none_of(bases.begin(), bases.end(), [](const FrameBase& base) { return base.chain != nullptr; })) {
    drawing_.forgetChain();
  }
  bytes_ = bytes;
  kept_.set(bytes);
}

void Viewers::end(const std::string& reason) {
  std::vector<Viewer> viewers;
  std::deque<Waiting> dropped;
  {
    const std::lock_guard lock(mutex_);
    viewers.swap(viewers_);
    dropped.swap(queue_);
    queuedBytes_ = 0;
    isStale_ = false;
    noteWishes();
  }
  for (const Viewer& viewer : viewers) {
    viewer.stream->end(reason);
  }
}

}  // namespace espalier::server
