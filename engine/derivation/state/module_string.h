#pragma once

#include <cstdint>
#include <span>
#include <utility>

#include "engine/core/buffer.h"
#include "engine/core/identifiers.h"

namespace espalier::derivation {

/// A bracketed string of modules as a structure of arrays: 2 bytes a module and 8 bytes a parameter. The arity of a
/// module is that of its type (Program::arity), so the parameters of module i begin where those of i - 1 end.
class ModuleString {
 public:
  [[nodiscard]] std::uint64_t size() const { return types_.size(); }
  [[nodiscard]] bool empty() const { return types_.empty(); }
  [[nodiscard]] std::uint64_t parameterCount() const { return parameters_.size(); }
  [[nodiscard]] std::uint64_t bytes() const { return types_.size() * 2 + parameters_.size() * 8; }
  [[nodiscard]] std::span<const core::ModuleTypeId> types() const { return types_.view(); }
  [[nodiscard]] std::span<const double> parameters() const { return parameters_.view(); }
  [[nodiscard]] std::span<double> mutableParameters() { return parameters_.span(); }
  void setParameter(std::uint64_t offset, double value) { parameters_[offset] = value; }

  void clear() {
    types_.clear();
    parameters_.clear();
  }
  void swap(ModuleString& other) noexcept {
    types_.swap(other.types_);
    parameters_.swap(other.parameters_);
  }
  void append(core::ModuleTypeId type, std::span<const double> parameters) {
    types_.push_back(type);
    parameters_.append(parameters);
  }
  void appendAll(std::span<const core::ModuleTypeId> types, std::span<const double> parameters) {
    types_.append(types);
    parameters_.append(parameters);
  }
  /// The raw arrays (moduleCount) and (parameterCount), for passes that count first and then write.
  [[nodiscard]] core::Buffer<core::ModuleTypeId>& typeBuffer() { return types_; }
  [[nodiscard]] core::Buffer<double>& parameterBuffer() { return parameters_; }

  /// The same string in the same memory, without a copy (core::Buffer::share). The two belong to different threads if
  /// their owners wish. The one that is written first goes on in memory of its own.
  [[nodiscard]] ModuleString share() { return {types_.share(), parameters_.share()}; }
  /// The same for a string that came from share(). Several threads may call it.
  [[nodiscard]] ModuleString share() const { return {types_.share(), parameters_.share()}; }

  ModuleString() = default;

 private:
  ModuleString(core::Buffer<core::ModuleTypeId> types, core::Buffer<double> parameters)
      : types_(std::move(types)), parameters_(std::move(parameters)) {}

  core::Buffer<core::ModuleTypeId> types_;  // type of each module (moduleCount)
  core::Buffer<double> parameters_;         // parameters of all modules, concatenated (parameterCount)
};

}  // namespace espalier::derivation
