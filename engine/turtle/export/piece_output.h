#pragma once

#include <array>
#include <string>
#include <string_view>

#include "engine/core/streams.h"

namespace espalier::turtle {

/// Collects small writes and hands them to a sink in large pieces, or appends them to a string, which have all of them
/// after `flush`. Nothing is written at the end of the object: a sink may throw, and a string may find no memory.
class PieceOutput {
 public:
  static constexpr std::size_t kMostRoom = 512;

  explicit PieceOutput(core::ByteSink& sink) : sink_(&sink), buffer_(&own_) {}
  explicit PieceOutput(std::string& bytes) : buffer_(&bytes) {}
  PieceOutput(const PieceOutput&) = delete;
  PieceOutput& operator=(const PieceOutput&) = delete;

  void bytes(std::string_view text) {
    if (text.size() <= kMostRoom) {
      take(text.copy(room(text.size()), text.size()));
      return;
    }
    if (sink_ != nullptr && text.size() > kPieceBytes) {
      flush();
      sink_->write(text);
      return;
    }
    append();
    buffer_->append(text);
  }

  /// A place for so many bytes, at most kMostRoom. `take` says how many of them were written.
  [[nodiscard]] char* room(std::size_t size) {
    if (recentSize_ + size > recent_.size()) {
      append();
    }
    return recent_.data() + recentSize_;
  }
  void take(std::size_t size) { recentSize_ += size; }

  void flush() {
    append();
    if (sink_ != nullptr && !buffer_->empty()) {
      sink_->write(*buffer_);
      buffer_->clear();
    }
  }

 private:
  static constexpr std::size_t kPieceBytes = 65'536;

  // not at each write: for a number that would take longer than to spell it
  void append() {
    buffer_->append(recent_.data(), recentSize_);
    recentSize_ = 0;
    if (sink_ != nullptr && buffer_->size() > kPieceBytes) {
      sink_->write(*buffer_);
      buffer_->clear();
    }
  }

  core::ByteSink* sink_ = nullptr;  // null: the bytes belong to the caller
  std::string own_;
  std::string* buffer_;
  std::array<char, 2 * kMostRoom> recent_;  // what is not in the buffer yet
  std::size_t recentSize_ = 0;
};

}  // namespace espalier::turtle
