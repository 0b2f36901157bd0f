#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <span>
#include <thread>
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
/// Starts a thread that touches the pages of any block without changing their contents, the last ones first, while the
/// caller writes from the front: each waits for other pages. It ends with its object. Starts none when the block is too
/// small to gain, or when no thread can be had.
[[nodiscard]] std::jthread populatePagesFromEnd(void* memory, std::size_t byteCount) noexcept;

/// Asks for huge pages for memory of another allocator, before its first use. This is only advice: the system may
/// ignore it.
void adviseHugePages(void* memory, std::size_t byteCount) noexcept;

/// A growable array of trivially copyable elements. New elements are uninitialised. It grows by at least half; clear()
/// keeps the memory, release() frees it.
///
/// Buffers may share their memory (share). Each of them copies the elements before it writes, unless it is the last
/// that has them. Buffers that share memory may belong to different threads.
template <typename T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer() = default;
  Buffer(std::initializer_list<T> values) { append({values.begin(), values.size()}); }
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
    std::swap(lease_, other.lease_);
  }

  /// Another buffer with the same elements, in the same memory.
  [[nodiscard]] Buffer share() {
    if (size_ > 0 && lease_ == nullptr) {
      lease_ = new Lease(capacity_);
      capacity_ = size_;
    }
    return std::as_const(*this).share();
  }
  /// The same for a buffer that came from share() or is empty. Several threads may call it.
  [[nodiscard]] Buffer share() const {
    Buffer other;
    if (size_ > 0 && lease_ != nullptr) {
      lease_->owners.fetch_add(1, std::memory_order_relaxed);
      other.data_ = data_;
      other.size_ = size_;
      other.capacity_ = size_;
      other.lease_ = lease_;
    } else {
      other.append(view());
    }
    return other;
  }
  /// Whether another buffer shares the memory. Once none does, none will unless share() is called.
  [[nodiscard]] bool isShared() const {
    return lease_ != nullptr && lease_->owners.load(std::memory_order_acquire) > 1;
  }
  /// Makes the memory this buffer's own: pointers into it stay valid, and may be written through, until it grows.
  void own() {
    if (lease_ != nullptr) [[unlikely]] {
      leave(size_);
    }
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }
  [[nodiscard]] T* data() {
    own();
    return data_;
  }
  [[nodiscard]] const T* data() const { return data_; }
  [[nodiscard]] T& operator[](std::size_t i) {
    own();
    return data_[i];
  }
  [[nodiscard]] const T& operator[](std::size_t i) const { return data_[i]; }
  [[nodiscard]] const T& back() const { return data_[size_ - 1]; }
  [[nodiscard]] const T* begin() const { return data_; }
  [[nodiscard]] const T* end() const { return data_ + size_; }
  [[nodiscard]] T* begin() { return data(); }
  [[nodiscard]] T* end() { return data() + size_; }
  [[nodiscard]] std::span<const T> view() const { return {data_, size_}; }
  [[nodiscard]] std::span<T> span() {
    own();
    return {data_, size_};
  }

  void clear() {
    if (lease_ != nullptr && !reclaim()) [[unlikely]] {
      release();
    }
    size_ = 0;
  }
  void release() noexcept {
    if (lease_ != nullptr) {
      dropLease();
    } else if (data_ != nullptr) {
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
    // elements behind the end are still shared: the next one is not written over them
    capacity_ = lease_ == nullptr ? capacity_ : size_;
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
  /// Counts the buffers that share a block. Their capacity_ is size_, so that appending meets reallocate() first.
  struct Lease {
    explicit Lease(std::size_t blockCapacity) : capacity(blockCapacity) {}
    std::atomic<std::uint32_t> owners{1};
    const std::size_t capacity;  // of the block, elements
  };

  void dropLease() noexcept {
    if (lease_->owners.fetch_sub(1, std::memory_order_acq_rel) == 1) {
      unmapPages(data_, lease_->capacity * sizeof(T));
      delete lease_;
    }
    lease_ = nullptr;
  }
  /// True: no other buffer shares the block any more, and it belongs to this one.
  bool reclaim() {
    if (lease_->owners.load(std::memory_order_acquire) > 1) {
      return false;
    }
    capacity_ = lease_->capacity;
    delete lease_;
    lease_ = nullptr;
    return true;
  }
  /// Goes on in memory of its own, for at least `count` elements.
  void leave(std::size_t count) {
    if (reclaim() && count <= capacity_) {
      return;
    }
    if (lease_ == nullptr) {
      reallocate(count);
      return;
    }
    T* const fresh = static_cast<T*>(mapPages(count * sizeof(T)));
    std::memcpy(fresh, data_, size_ * sizeof(T));
    dropLease();
    data_ = fresh;
    capacity_ = count;
  }
  void reallocate(std::size_t count) {
    if (lease_ != nullptr) [[unlikely]] {
      leave(count);
      return;
    }
    data_ = static_cast<T*>(data_ == nullptr
                                ? mapPages(count * sizeof(T))
                                : growPages(data_, capacity_ * sizeof(T), size_ * sizeof(T), count * sizeof(T)));
    capacity_ = count;
  }

  T* data_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
  Lease* lease_ = nullptr;  // null: the memory is this buffer's alone
};

}  // namespace espalier::core
