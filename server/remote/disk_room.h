#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

namespace espalier::server {

/// Bytes on a disk that several files share. Bytes that are taken count for the parent, too. Thread-safe.
class DiskRoom {
 public:
  /// `what` (the files) and `limit` (the name of the bound) are for messages. `parent` lives longer; null: none.
  explicit DiskRoom(std::string what = {}, std::string_view limit = {}, DiskRoom* parent = nullptr)
      : what_(std::move(what)), limit_(limit), parent_(parent) {}
  DiskRoom(const DiskRoom&) = delete;
  DiskRoom& operator=(const DiskRoom&) = delete;

  [[nodiscard]] const std::string& what() const { return what_; }
  [[nodiscard]] std::string_view limit() const { return limit_; }
  /// UINT64_MAX: none.
  void setBound(std::uint64_t bytes) { bound_ = bytes; }
  [[nodiscard]] std::uint64_t bound() const { return bound_; }
  [[nodiscard]] std::uint64_t used() const { return used_; }
  /// The room that has nothing left: this one, or a parent. Null: there is some.
  [[nodiscard]] const DiskRoom* full() const {
    return used_ >= bound_ ? this : parent_ == nullptr ? nullptr : parent_->full();
  }

  /// Null: taken. Else nothing was taken, and this is the room that does not have so much.
  [[nodiscard]] const DiskRoom* take(std::uint64_t bytes) {
    const DiskRoom* refuses = (used_ += bytes) > bound_ ? this : nullptr;
    if (refuses == nullptr && parent_ != nullptr) {
      refuses = parent_->take(bytes);
    }
    used_ -= refuses != nullptr ? bytes : 0;
    return refuses;
  }
  /// Counts bytes that were there before, or are not there any more (below 0).
  void add(std::int64_t bytes) {
    used_ += static_cast<std::uint64_t>(bytes);
    if (parent_ != nullptr) {
      parent_->add(bytes);
    }
  }

 private:
  const std::string what_;
  const std::string_view limit_;
  DiskRoom* const parent_;
  std::atomic<std::uint64_t> bound_{UINT64_MAX};
  std::atomic<std::uint64_t> used_{0};
};

}  // namespace espalier::server
