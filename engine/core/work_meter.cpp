#include "engine/core/work_meter.h"

namespace espalier::core {

WorkMeter::Scope::Scope(WorkMeter* meter) noexcept
    : outer_(current_), meter_(meter), entered_(meter == nullptr ? 0 : meter->enter()) {
  current_ = meter;
}

WorkMeter::Scope::~Scope() {
  current_ = outer_;
  if (meter_ != nullptr) {
    meter_->leave(entered_);
  }
}

}  // namespace espalier::core
