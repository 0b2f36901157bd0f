#pragma once

#include <embree3/rtcore.h>

#include <new>

namespace espalier::environment {

/// Embree reports that memory ran out as a code of its device and goes on with a scene that nothing meets: this throws
/// std::bad_alloc instead, as everything else does. `device`: nullptr when it could not be made.
inline void throwWithoutMemory(RTCDevice device) {
  if (device == nullptr || rtcGetDeviceError(device) != RTC_ERROR_NONE) {
    throw std::bad_alloc();
  }
}

}  // namespace espalier::environment
