#pragma once

#include <dlfcn.h>

namespace espalier::core {

/// A shared library of the system that need not be installed. It is loaded here and stays loaded.
class OptionalLibrary {
 public:
  /// `file`: the name under which the dynamic loader finds it.
  explicit OptionalLibrary(const char* file)
      : library_(::dlopen(file, RTLD_NOW | RTLD_LOCAL)), isComplete_(library_ != nullptr) {}

  /// Looks for a function; null when there is none.
  template <typename Function>
  void find(Function*& function, const char* name) {
    function = library_ == nullptr ? nullptr : reinterpret_cast<Function*>(::dlsym(library_, name));
    isComplete_ = isComplete_ && function != nullptr;
  }

  /// Whether the library is there and had all functions so far.
  [[nodiscard]] bool isComplete() const { return isComplete_; }

 private:
  void* library_;
  bool isComplete_;
};

}  // namespace espalier::core
