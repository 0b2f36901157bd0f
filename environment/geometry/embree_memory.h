#pragma once

#include <embree3/rtcore.h>

#include <new>

namespace espalier::environment {

/// Throws std::bad_alloc when a device has run out of memory. Embree only sets an error code of the device and
/// continues with an empty scene. `device`: nullptr when it could not be made.
inline void throwWithoutMemory(RTCDevice device) {
  if (device == nullptr || rtcGetDeviceError(device) != RTC_ERROR_NONE) {
    throw std::bad_alloc();
  }
}

}  // namespace espalier::environment
