#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <new>

namespace espalier::core {

/// Watches one piece of work on its threads: the memory that it takes, its processor time, and whether it is to stop.
/// A program that serves strangers derives its own. Work without a meter is not bounded.
///
///     core::WorkMeter::Scope scope(meter);  // from here on this thread works for the meter
///     compile(input, files);                // may throw WorkStopped or std::bad_alloc
class WorkMeter {
 public:
  WorkMeter() = default;
  virtual ~WorkMeter() = default;
  WorkMeter(const WorkMeter&) = delete;
  WorkMeter& operator=(const WorkMeter&) = delete;

  /// The work takes a block of so many bytes; below 0 it gives one back. False: it may not have the block. Called on
  /// every thread of the work, by everything that allocates.
  [[nodiscard]] virtual bool take(std::int64_t bytes) noexcept = 0;
  /// The work is to stop soon: pollWork() throws. From any thread.
  [[nodiscard]] virtual bool isStopped() const noexcept = 0;
  /// The calling thread begins to work for the meter. leave() gets the value that this returns.
  [[nodiscard]] virtual std::uint64_t enter() noexcept { return 0; }
  virtual void leave(std::uint64_t /*entered*/) noexcept {}

  /// The meter of the calling thread; null: none. Every `new` of a server asks: one load.
  [[nodiscard]] static WorkMeter* current() noexcept { return current_; }

  /// While it lives, the calling thread works for a meter, or for none (null). Scopes nest.
  class Scope {
   public:
    explicit Scope(WorkMeter* meter) noexcept;
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    WorkMeter* const outer_;
    WorkMeter* const meter_;
    const std::uint64_t entered_;
  };

 private:
  // a thread does one piece of work at a time, and everything that allocates on it counts for that
  static constinit inline thread_local WorkMeter* current_ = nullptr;
};

/// Ends a piece of work that is to stop.
class WorkStopped : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "the work was stopped"; }
};

/// The work of this thread is to stop. For loops that have an error of their own for it.
[[nodiscard]] inline bool isWorkStopped() {
  const WorkMeter* const meter = WorkMeter::current();
  return meter != nullptr && meter->isStopped();
}

/// Throws WorkStopped when the work of this thread is to stop. For loops whose length a stranger chooses.
inline void pollWork() {
  if (isWorkStopped()) {
    throw WorkStopped();
  }
}

/// Tells the meter of this thread that memory is taken. Throws std::bad_alloc when it may not be.
inline void takeMemory(std::uint64_t bytes) {
  if (WorkMeter* const meter = WorkMeter::current();
      meter != nullptr && !meter->take(static_cast<std::int64_t>(bytes))) {
    throw std::bad_alloc();
  }
}

/// Tells the meter of this thread that memory is given back.
inline void giveMemory(std::uint64_t bytes) noexcept {
  if (WorkMeter* const meter = WorkMeter::current(); meter != nullptr) {
    static_cast<void>(meter->take(-static_cast<std::int64_t>(bytes)));
  }
}

}  // namespace espalier::core
