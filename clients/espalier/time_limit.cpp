#include "clients/espalier/time_limit.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>

#include "server/remote/control_group.h"

namespace espalier::command {
namespace {

double processorSeconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

}  // namespace

TimeLimit::TimeLimit(simulation::Simulation& simulation, std::uint64_t seconds) : seconds_(seconds) {
  if (seconds > 0) {
    watcher_ = std::thread([this, &simulation] { watch(simulation, static_cast<double>(seconds_)); });
  }
}

TimeLimit::~TimeLimit() {
  {
    const std::lock_guard lock(mutex_);
    hasEnded_ = true;
  }
  ended_.notify_all();
  if (watcher_.joinable()) {
    watcher_.join();
  }
}

void TimeLimit::watch(simulation::Simulation& simulation, double seconds) {
  constexpr double kShortestWait = 0.01;
  const double end = processorSeconds() + seconds;
  const double threads = server::processorCount();
  std::unique_lock lock(mutex_);
  while (!hasEnded_) {
    const double left = end - processorSeconds();
    if (left <= 0.0) {
      isReached_ = true;
      simulation.setCancelled(true);
      return;
    }
    // the time cannot be used up earlier than this
    ended_.wait_for(lock, std::chrono::duration<double>(std::max(kShortestWait, left / threads)));
  }
}

core::SimulationError TimeLimit::explained(core::SimulationError error) const {
  if (isReached_ && error.code == core::SimulationErrorCode::Cancelled) {
    error.message = "step " + std::to_string(error.step) + ": the run has computed for more than " +
                    std::to_string(seconds_) + " s (--limit seconds=N sets another bound).";
  }
  return error;
}

}  // namespace espalier::command
