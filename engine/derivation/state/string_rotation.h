#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/derivation/state/module_string.h"

namespace espalier::derivation {

/// Memory for strings that other threads may still read (ModuleString::share). A string that has to be written while
/// somebody reads it goes on in memory that readers have left, so that new pages are seldom touched. Between two steps
/// it keeps at most kMostSpares blocks of each kind, and none when nobody has read for a while.
class StringRotation {
 public:
  static constexpr std::size_t kMostSpares = 2;

  /// Empties the string, in memory of its own.
  void clear(ModuleString& string) {
    types_.clear(string.typeBuffer());
    parameters_.clear(string.parameterBuffer());
  }
  /// Gives the parameters of the string memory of their own.
  void ownParameters(ModuleString& string) { parameters_.own(string.parameterBuffer()); }

 private:
  template <typename T>
  class Spares {
   public:
    void clear(core::Buffer<T>& buffer) {
      if (buffer.isShared()) {
        rest(std::exchange(buffer, take()));
      } else {
        age();
      }
      buffer.clear();
    }
    void own(core::Buffer<T>& buffer) {
      if (buffer.isShared()) {
        core::Buffer<T> copy = take();
        copy.clear();
        copy.append(std::as_const(buffer).view());
        rest(std::exchange(buffer, std::move(copy)));
      } else {
        buffer.own();
      }
    }

   private:
    static constexpr std::uint32_t kUnusedCalls = 64;

    /// A block that readers have left, or an empty buffer.
    core::Buffer<T> take() {
      unused_ = 0;
      for (core::Buffer<T>& spare : spares_) {
        if (!spare.isShared()) {
          core::Buffer<T> taken = std::move(spare);
          std::swap(spare, spares_.back());
          spares_.pop_back();
          return taken;
        }
      }
      return {};
    }
    void rest(core::Buffer<T> buffer) {
      if (spares_.size() < kMostSpares) {
        spares_.push_back(std::move(buffer));
      }
    }
    void age() {
      if (!spares_.empty() && ++unused_ > kUnusedCalls) {
        spares_.clear();
      }
    }

    std::vector<core::Buffer<T>> spares_;
    std::uint32_t unused_ = 0;  // calls since a spare was last wanted
  };

  Spares<core::ModuleTypeId> types_;
  Spares<double> parameters_;
};

}  // namespace espalier::derivation
