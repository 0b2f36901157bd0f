#pragma once

#include <cstddef>
#include <memory>

namespace espalier::derivation {

/// An array of numbers without initial values, for working memory. Making it costs nothing, and unused memory is never
/// touched.
template <class T>
class Scratch {
 public:
  explicit Scratch(std::size_t size) : data_(std::make_unique_for_overwrite<T[]>(size)), size_(size) {}

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] T* data() { return data_.get(); }
  [[nodiscard]] const T* data() const { return data_.get(); }
  [[nodiscard]] T* begin() { return data_.get(); }
  [[nodiscard]] T* end() { return data_.get() + size_; }
  [[nodiscard]] T& operator[](std::size_t i) { return data_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return data_[i]; }

 private:
  std::unique_ptr<T[]> data_;
  std::size_t size_;
};

}  // namespace espalier::derivation
