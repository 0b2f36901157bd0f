#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "engine/core/buffer.h"
#include "engine/core/identifiers.h"
#include "engine/derivation/state/string_mark.h"

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
  [[nodiscard]] std::span<double> mutableParameters() {
    forgetMark();
    return parameters_.span();
  }

  /// Writes one parameter. The string still knows its mark (earlierMark), and the blocks of parameters that changed.
  void setParameter(std::uint64_t offset, double value) {
    double& parameter = parameters_.data()[offset];
    if (std::bit_cast<std::uint64_t>(parameter) == std::bit_cast<std::uint64_t>(value)) {
      return;
    }
    parameter = value;
    if (mark_ != nullptr) [[unlikely]] {
      written_.resize(parameterCount() / kWrittenBlock + 1);
      written_[offset / kWrittenBlock] = true;
    }
  }

  /// The mark of the present contents; null: none was made.
  [[nodiscard]] const std::shared_ptr<const StringMark>& mark() const {
    return written_.empty() ? earlierMark() : noMark();
  }
  /// The mark of the contents before setParameter changed any; null: none was made.
  [[nodiscard]] const std::shared_ptr<const StringMark>& earlierMark() const {
    return mark_ != nullptr && markedModules_ == size() && markedParameters_ == parameterCount() ? mark_ : noMark();
  }
  /// Whether setParameter may have changed any of these parameters since then.
  [[nodiscard]] bool wereSet(std::uint64_t offset, std::uint64_t count) const {
    if (written_.empty() || count == 0) {
      return false;
    }
    if ((offset + count - 1) / kWrittenBlock >= written_.size()) {
      return true;
    }
    const auto block = [this](std::uint64_t at) {
      return written_.begin() + static_cast<std::ptrdiff_t>(at / kWrittenBlock);
    };
    const auto end = block(offset + count - 1) + 1;
    return std::find(block(offset), end, true) != end;
  }
  /// The mark of the present contents, made when there is none.
  [[nodiscard]] std::shared_ptr<const StringMark> marked() {
    if (mark() == nullptr) {
      setMark(std::make_shared<const StringMark>());
    }
    return mark_;
  }
  /// Gives the contents a mark. Every other change of the contents forgets it.
  void setMark(std::shared_ptr<const StringMark> mark) {
    written_.clear();
    mark_ = std::move(mark);
    markedModules_ = size();
    markedParameters_ = parameterCount();
  }

  void clear() {
    types_.clear();
    parameters_.clear();
    forgetMark();
  }
  void swap(ModuleString& other) noexcept {
    types_.swap(other.types_);
    parameters_.swap(other.parameters_);
    mark_.swap(other.mark_);
    written_.swap(other.written_);
    std::swap(markedModules_, other.markedModules_);
    std::swap(markedParameters_, other.markedParameters_);
  }
  // appending costs nothing for marks: a mark holds for the number of modules that it was made with
  void append(core::ModuleTypeId type, std::span<const double> parameters) {
    types_.push_back(type);
    parameters_.append(parameters);
  }
  void appendAll(std::span<const core::ModuleTypeId> types, std::span<const double> parameters) {
    types_.append(types);
    parameters_.append(parameters);
  }
  /// The raw arrays (moduleCount) and (parameterCount), for passes that count first and then write.
  [[nodiscard]] core::Buffer<core::ModuleTypeId>& typeBuffer() {
    forgetMark();
    return types_;
  }
  [[nodiscard]] core::Buffer<double>& parameterBuffer() {
    forgetMark();
    return parameters_;
  }

 private:
  static constexpr std::uint64_t kWrittenBlock = 256;  // parameters

  [[nodiscard]] static const std::shared_ptr<const StringMark>& noMark() {
    static const std::shared_ptr<const StringMark> kNone;
    return kNone;
  }
  void forgetMark() {
    if (mark_ != nullptr) [[unlikely]] {
      setMark(nullptr);
    }
  }

  core::Buffer<core::ModuleTypeId> types_;  // type of each module (moduleCount)
  core::Buffer<double> parameters_;         // parameters of all modules, concatenated (parameterCount)
  std::shared_ptr<const StringMark> mark_;  // of contents with the two numbers below
  std::uint64_t markedModules_ = 0;
  std::uint64_t markedParameters_ = 0;
  std::vector<bool> written_;  // by block of parameters: one was set since; empty: none was set
};

}  // namespace espalier::derivation
