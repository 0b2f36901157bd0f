#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace espalier::protocol {

/// Cuts a stream of bytes into lines that end in `\n`. A `\r` before it is dropped and empty lines are skipped, so that
/// `nc` and readline work. A line longer than the limit loses the framing: nothing after it can be trusted.
///
///     splitter.feed(bytes);
///     while (auto line = splitter.next()) { ... }
///     if (splitter.isOverflowed()) { close }
class LineSplitter {
 public:
  explicit LineSplitter(std::size_t maximumLineBytes) : maximumLineBytes_(maximumLineBytes) {}

  /// Appends received bytes. Views returned by next() become invalid.
  void feed(std::string_view bytes);

  /// The next complete line without its end, or a null data() when there is none. Valid until the next feed().
  [[nodiscard]] std::string_view next();

  /// A line, complete or not, is longer than the limit. next() returns no more lines.
  [[nodiscard]] bool isOverflowed() const { return isOverflowed_; }
  /// Bytes of the line that overflowed, as far as received.
  [[nodiscard]] std::size_t overflowBytes() const { return overflowBytes_; }
  [[nodiscard]] std::size_t maximumLineBytes() const { return maximumLineBytes_; }

  /// Whether the end of the stream now would cut a line.
  [[nodiscard]] bool hasPartialLine() const { return begin_ < buffer_.size(); }

 private:
  std::size_t maximumLineBytes_;
  std::string buffer_;
  std::size_t begin_ = 0;    // first byte not yet returned
  std::size_t scanned_ = 0;  // bytes before it hold no newline after begin_
  std::size_t overflowBytes_ = 0;
  bool isOverflowed_ = false;
};

}  // namespace espalier::protocol
