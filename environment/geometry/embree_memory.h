#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <new>

#include "engine/core/work_meter.h"

namespace espalier::environment {

/// Throws std::bad_alloc when a device has run out of memory. Embree only sets an error code of the device and
/// continues with an empty scene. `device`: nullptr when it could not be made.
inline void throwWithoutMemory(RTCDevice device) {
  if (device == nullptr || rtcGetDeviceError(device) != RTC_ERROR_NONE) {
    throw std::bad_alloc();
  }
}

/// A device of Embree, whose memory the meter of the calling thread counts and may refuse. Embree takes memory by
/// itself and on threads of its own: what it takes while the thread builds a scene, and gives back in the destructor,
/// counts for the meter that the thread has then.
class EmbreeDevice {
 public:
  EmbreeDevice() = default;
  ~EmbreeDevice() {
    if (device_ != nullptr) {
      meter_ = core::WorkMeter::current();
      rtcReleaseDevice(device_);
    }
  }
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  /// Makes the device. Throws std::bad_alloc.
  void open(const char* configuration) {
    meter_ = core::WorkMeter::current();
    device_ = rtcNewDevice(configuration);
    throwWithoutMemory(device_);
    rtcSetDeviceMemoryMonitorFunction(device_, &EmbreeDevice::note, this);
  }
  [[nodiscard]] RTCDevice get() const { return device_; }
  /// The scene is built: tracing takes no memory.
  void endBuild() { meter_ = nullptr; }
  /// To be called before scenes are released: they may be on another thread's work by now.
  void beginRelease() { meter_ = core::WorkMeter::current(); }

 private:
  // called before memory is taken, and when it was given back (below 0); false: it is not taken
  static bool note(void* self, ssize_t bytes, bool /*isAfter*/) {
    core::WorkMeter* const meter = static_cast<EmbreeDevice*>(self)->meter_;
    return meter == nullptr || meter->take(std::int64_t{bytes}) || bytes <= 0;
  }

  RTCDevice device_ = nullptr;
  core::WorkMeter* meter_ = nullptr;  // null: nobody counts
};

}  // namespace espalier::environment
