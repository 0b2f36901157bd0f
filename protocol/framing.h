#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "protocol/bulk_text.h"
#include "protocol/envelope.h"

namespace espalier::protocol {

/// Cuts a stream of bytes into lines that end in `\n`. A `\r` before it is dropped and empty lines are skipped, so that
/// `nc` and readline work. A line longer than the limit loses the framing: the next message cannot be found.
///
///     splitter.feed(bytes);
///     while (auto line = splitter.next()) { ... }
///     if (splitter.isOverflowed()) { close }
class LineSplitter {
 public:
  /// An idle side keeps no more memory of its lines.
  static constexpr std::size_t kIdleBytes = 16'384;

  explicit LineSplitter(std::size_t maximumLineBytes) : maximumLineBytes_(maximumLineBytes) {}

  /// Appends received bytes. Views returned by next() become invalid.
  void feed(std::string_view bytes);

  /// The next complete line without its end, or a null data() when there is none. Valid until the next feed().
  [[nodiscard]] std::string_view next();

  /// Bytes of the line that next() would return, its end not counted; 0: none is complete. Valid until the next feed().
  [[nodiscard]] std::size_t nextBytes();
  /// The limit of the lines that next() has not returned yet.
  void setMaximumLineBytes(std::size_t bytes) { maximumLineBytes_ = bytes; }

  /// A line, complete or not, is longer than the limit. next() returns no more lines.
  [[nodiscard]] bool isOverflowed() const { return isOverflowed_; }
  /// Bytes of the line that overflowed, as far as received.
  [[nodiscard]] std::size_t overflowBytes() const { return overflowBytes_; }
  [[nodiscard]] std::size_t maximumLineBytes() const { return maximumLineBytes_; }

  /// Takes up to `count` of the bytes that follow the last line returned; how many there were. Only directly after
  /// next().
  [[nodiscard]] std::size_t take(char* target, std::size_t count);

  /// The caller is done with what next() returned: no more memory than kIdleBytes is kept for lines that are gone.
  void rest();
  /// Whether the end of the stream now would cut a line.
  [[nodiscard]] bool hasPartialLine() const { return begin_ < buffer_.size(); }
  /// Bytes that next() has not returned yet.
  [[nodiscard]] std::size_t heldBytes() const { return buffer_.size() - begin_; }

 private:
  void dropReturned();

  std::size_t maximumLineBytes_;
  std::string buffer_;
  std::size_t begin_ = 0;    // first byte not yet returned
  std::size_t scanned_ = 0;  // bytes before it hold no newline after begin_
  std::size_t overflowBytes_ = 0;
  bool isOverflowed_ = false;
};

/// The limits of the messages that one side accepts.
struct FrameLimits {
  std::size_t lineBytes = 256'000'000;
  std::size_t blockBytes = 1'000'000'000;  // raw bytes of one message
};

/// Cuts a stream of bytes into messages: lines, and behind a line with `binBytes` its raw bytes. Blocks are accepted
/// once both sides agreed on them. Earlier blocks lose the framing.
class MessageReader {
 public:
  /// A message, or why a line is none.
  using Read = tl::expected<Message, BadMessage>;

  explicit MessageReader(const FrameLimits& limits) : limits_(limits), lines_(limits.lineBytes) {}

  void feed(std::string_view bytes);
  /// The next complete message, or nothing when there is none.
  [[nodiscard]] std::optional<Read> next();
  void allowBlocks() { areBlocksAllowed_ = true; }
  /// Gives back the memory of messages that are gone. For a side that may now be silent for long.
  void rest() {
    lines_.rest();
    bulk_.rest();
  }
  /// The limit of the lines that have not been returned yet.
  void setLineBytes(std::size_t bytes) { lines_.setMaximumLineBytes(bytes); }
  /// Bytes of the line that the next call of next() would decode; 0: none.
  [[nodiscard]] std::size_t nextLineBytes() { return waiting_ ? 0 : lines_.nextBytes(); }
  /// Bytes of messages that next() has not returned yet.
  [[nodiscard]] std::size_t heldBytes() const { return lines_.heldBytes() + (waiting_ ? filled_ : 0); }

  /// The reason why the framing is lost: a line or a block beyond its limit, or blocks that were not agreed. The caller
  /// tells the peer and closes the connection. next() returns nothing more.
  [[nodiscard]] const std::optional<Error>& lost() const { return lost_; }
  /// Whether the end of the stream now would cut a message.
  [[nodiscard]] bool hasPartialMessage() const { return lines_.hasPartialLine() || waiting_.has_value(); }

 private:
  /// Whether the bytes behind `waiting_` are all there.
  [[nodiscard]] bool isFilled() const { return filled_ == blockBytes_; }
  [[nodiscard]] std::optional<Read> finish();

  FrameLimits limits_;
  LineSplitter lines_;
  BulkTextReader bulk_;
  std::optional<Read> waiting_;  // a message whose raw bytes are not all there
  std::shared_ptr<std::uint64_t[]> block_;
  std::uint64_t blockBytes_ = 0;
  std::uint64_t filled_ = 0;  // of blockBytes_
  std::optional<Error> lost_;
  bool areBlocksAllowed_ = false;
};

/// The message of one WebSocket frame: text is one message; binary is the length of the JSON (u32, little-endian), the
/// JSON, zeros up to a multiple of 8 and the raw bytes. `problem` receives the reason when the frame cannot be read at
/// all.
[[nodiscard]] std::optional<MessageReader::Read> readFrame(std::string_view frame, bool isBinary, bool areBlocksAllowed,
                                                           BulkTextReader& bulk, std::optional<Error>& problem);
/// The binary frame of a message as it goes over a stream (a line and raw bytes).
[[nodiscard]] std::string binaryFrame(std::string_view message);
/// Whether a message as it goes over a stream has raw bytes behind its line.
[[nodiscard]] bool hasBlocks(std::string_view message);

}  // namespace espalier::protocol
