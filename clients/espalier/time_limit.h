#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "engine/core/simulation_error.h"
#include "engine/simulation/simulation.h"

namespace espalier::command {

/// Cancels the step of a simulation when the program has used a number of seconds of processor time on all threads
/// since the construction of the object.
class TimeLimit {
 public:
  /// `simulation` must outlive the object. 0 seconds: no limit.
  TimeLimit(simulation::Simulation& simulation, std::uint64_t seconds);
  ~TimeLimit();
  TimeLimit(const TimeLimit&) = delete;
  TimeLimit& operator=(const TimeLimit&) = delete;

  /// The error for a person: when the time limit cancelled the step, the message says so.
  [[nodiscard]] core::SimulationError explained(core::SimulationError error) const;

 private:
  void watch(simulation::Simulation& simulation, double seconds);

  std::uint64_t seconds_;
  std::atomic<bool> isReached_{false};
  std::mutex mutex_;
  std::condition_variable ended_;
  bool hasEnded_ = false;  // with mutex_ held
  std::thread watcher_;
};

}  // namespace espalier::command
