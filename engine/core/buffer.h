#pragma once

#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>

namespace espalier::core {

inline constexpr std::size_t kHugePageBytes = std::size_t{2} << 20U;

/// Maps or frees memory. A large block begins at a huge page and asks for huge pages, so that its first touch is cheap.
/// Throws std::bad_alloc.
[[nodiscard]] void* mapPages(std::size_t byteCount);
void unmapPages(void* memory, std::size_t byteCount) noexcept;
/// A block of `newByteCount` bytes in the place of one of `byteCount`, with the first `usedByteCount` bytes of its
/// contents. A large block moves with the pages it has touched, without a copy. Throws std::bad_alloc; the old block
/// stays valid then.
[[nodiscard]] void* growPages(void* memory, std::size_t byteCount, std::size_t usedByteCount, std::size_t newByteCount);
/// Touches pages of a large block without changing their contents. Address and size are whole huge pages, or reach to
/// the block's end. Does nothing where the system cannot do it.
void populatePages(void* memory, std::size_t byteCount) noexcept;

/// Asks for huge pages for memory of another allocator, before its first use. This is only advice: the system may
/// ignore it.
void adviseHugePages(void* memory, std::size_t byteCount) noexcept;

/// A growable array of trivially copyable elements. New elements are uninitialised. It grows by at least half; clear()
/// keeps the memory, release() frees it.
template <typename T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  Buffer(const Buffer& other) { append(other.view()); }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(const Buffer& other) {
    if (this != &other) {
      clear();
      append(other.view());
    }
    return *this;
  }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Buffer() { release(); }

  void swap(Buffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] T* data() { return data_; }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] T& operator[](std::size_t i) { return data_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return data_[i]; }
  [[nodiscard]] std::span<const T> view() const { return {data_, size_}; }
  [[nodiscard]] std::span<T> span() { return {data_, size_}; }

  void clear() { size_ = 0; }
  void release() noexcept {
    if (data_ != nullptr) {
      unmapPages(data_, capacity_ * sizeof(T));
    }
    data_ = nullptr;
    size_ = 0;
    capacity_ = 0;
  }
  void reserve(std::size_t count) {
    if (count > capacity_) {
      reallocate(count);
    }
  }
  /// Sets the size; elements beyond the old size are uninitialised.
  void resize(std::size_t count) {
    if (count > capacity_) {
      reallocate(count > capacity_ + capacity_ / 2 ? count : capacity_ + capacity_ / 2);
    }
    size_ = count;
  }
  void push_back(T value) {
    if (size_ == capacity_) {
      reallocate(capacity_ < 16 ? 16 : capacity_ + capacity_ / 2);
    }
    data_[size_++] = value;
  }
  void append(std::span<const T> values) {
    if (values.empty()) {
      return;
    }
    const std::size_t old = size_;
    resize(size_ + values.size());
    std::memcpy(data_ + old, values.data(), values.size() * sizeof(T));
  }

 private:
  void reallocate(std::size_t count) {
    data_ = static_cast<T*>(data_ == nullptr
                                ? mapPages(count * sizeof(T))
                                : growPages(data_, capacity_ * sizeof(T), size_ * sizeof(T), count * sizeof(T)));
    capacity_ = count;
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace espalier::core
