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

/// Gives up what a simulation does once the program has used a number of seconds of processor time, on all threads
/// together, since the object was made.
class TimeLimit {
 public:
  /// `simulation` must outlive the object. 0 seconds: no limit.
  TimeLimit(simulation::Simulation& simulation, std::uint64_t seconds);
  ~TimeLimit();
  TimeLimit(const TimeLimit&) = delete;
  TimeLimit& operator=(const TimeLimit&) = delete;

  /// The error as a person should read it: a step that was given up for its time says so.
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
