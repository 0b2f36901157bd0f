#include "environment/base/loaded_library.h"

#include <dlfcn.h>

#include <string>

#include "engine/core/simulation_error.h"

namespace espalier::environment {

void* LoadedLibrary::find(const char* name) const {
  // the loader counts, and knows a library that it has loaded
  void* const library = ::dlopen(file_, RTLD_NOW | RTLD_LOCAL);
  void* const function = library == nullptr ? nullptr : ::dlsym(library, name);
  if (function == nullptr) {
    const char* const reason = ::dlerror();
    throw core::SimulationFailure({.code = core::SimulationErrorCode::EnvironmentFailed,
                                   .message = "The library " + std::string(file_) + " cannot be loaded (" +
                                              (reason == nullptr ? "no reason given" : reason) + "). Install " +
                                              package_ + " (Debian)."});
  }
  return function;
}

}  // namespace espalier::environment
