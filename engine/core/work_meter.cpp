#include "engine/core/work_meter.h"

namespace espalier::core {
namespace {

// a thread does one piece of work at a time, and everything that allocates on it counts for that
thread_local WorkMeter* currentMeter = nullptr;

}  // namespace

WorkMeter* WorkMeter::current() noexcept {
  return currentMeter;
}

WorkMeter::Scope::Scope(WorkMeter* meter) noexcept
    : outer_(currentMeter), meter_(meter), entered_(meter == nullptr ? 0 : meter->enter()) {
  currentMeter = meter;
}

WorkMeter::Scope::~Scope() {
  currentMeter = outer_;
  if (meter_ != nullptr) {
    meter_->leave(entered_);
  }
}

}  // namespace espalier::core
