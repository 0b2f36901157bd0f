#pragma once

#include <atomic>

namespace espalier::environment {

/// A shared library of the system that is loaded when one of its functions is called first. Embree and OpenSSL are,
/// because most commands need neither, and loading them took two fifths of a small `derive`.
///
/// A source file names the functions that are used, so that callers include the library's own headers and call these:
///
///     const LoadedLibrary kEmbree("libembree3.so.3", "libembree3-3");
///     extern "C" { ESPALIER_LOADED(kEmbree, RTCScene, rtcNewScene, (RTCDevice device), (device)) }
///
/// A function that is used and not named there is linked as usual, and its library is loaded at the start again
/// (tests/integration/test_packaging.py notices).
class LoadedLibrary {
 public:
  /// `file`: the name under which the dynamic loader finds it. `package`: Debian's package, for messages.
  constexpr LoadedLibrary(const char* file, const char* package) : file_(file), package_(package) {}

  /// The address of a function. The library stays loaded. Threads may call it at once.
  /// Throws core::SimulationFailure (EnvironmentFailed), with a sentence that names library and package, when either
  /// cannot be found: a step that needs Embree fails and leaves its plants as they were.
  [[nodiscard]] void* find(const char* name) const;

 private:
  const char* file_;
  const char* package_;
};

}  // namespace espalier::environment

/// Defines `name`, which a header of the library declares, as a call of the library's function: a jump, but for the
/// first time. Hidden, so that other libraries that are loaded later never meet it.
#define ESPALIER_LOADED(library, result, name, parameters, arguments)              \
  static result name##First parameters;                                            \
  static std::atomic<decltype(&::name)> name##Found{&name##First};                 \
  static result name##First parameters {                                           \
    const auto found = reinterpret_cast<decltype(&::name)>((library).find(#name)); \
    name##Found.store(found, std::memory_order_release);                           \
    return found arguments;                                                        \
  }                                                                                \
  __attribute__((visibility("hidden"))) result name parameters {                   \
    return name##Found.load(std::memory_order_acquire) arguments;                  \
  }
