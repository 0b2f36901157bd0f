#include "protocol/framing.h"

#include <algorithm>
#include <cstring>

namespace espalier::protocol {

void LineSplitter::feed(std::string_view bytes) {
  if (isOverflowed_) {
    return;
  }
  dropReturned();
  buffer_.append(bytes);
}

void LineSplitter::dropReturned() {
  if (begin_ > 0) {
    buffer_.erase(0, begin_);
    scanned_ -= begin_;
    begin_ = 0;
  }
}

void LineSplitter::rest() {
  dropReturned();
  if (buffer_.capacity() > kIdleBytes && buffer_.size() < buffer_.capacity() / 4) {
    buffer_.shrink_to_fit();
  }
}

std::string_view LineSplitter::next() {
  while (!isOverflowed_) {
    const std::size_t end = buffer_.find('\n', scanned_);
    const std::size_t lineBytes = (end == std::string::npos ? buffer_.size() : end) - begin_;
    if (lineBytes > maximumLineBytes_) {
      isOverflowed_ = true;
      overflowBytes_ = lineBytes;
      break;
    }
    if (end == std::string::npos) {
      scanned_ = buffer_.size();
      break;
    }
    std::string_view line(buffer_.data() + begin_, lineBytes);
    begin_ = end + 1;
    scanned_ = begin_;
    if (!line.empty() && line.back() == '\r') {
      line.remove_suffix(1);
    }
    if (!line.empty()) {
      return line;
    }
  }
  return {};
}

std::size_t LineSplitter::nextBytes() {
  const std::size_t end = buffer_.find('\n', scanned_);
  scanned_ = std::min(end, buffer_.size());
  return end == std::string::npos ? 0 : end - begin_;
}

std::size_t LineSplitter::take(char* target, std::size_t count) {
  const std::size_t taken = std::min(count, buffer_.size() - begin_);
  std::memcpy(target, buffer_.data() + begin_, taken);
  begin_ += taken;
  scanned_ = begin_;
  return taken;
}

namespace {

Error notAgreed() {
  return {ErrorCode::Capability,
          "Binary blocks were not agreed on. Name the capability 'bin' in hello, and send blocks only when the answer "
          "names it too; the connection is closed, because the next message cannot be found.",
          {}};
}

std::uint64_t blockBytesOf(const MessageReader::Read& read) {
  return read ? read->blockBytes : read.error().blockBytes;
}

MessageReader::Read decode(std::string_view line, BulkTextReader& bulk) {
  if (line.size() >= BulkTextReader::kLeastBytes) {
    if (auto message = bulk.read(line)) {
      return std::move(*message);
    }
  }
  return decodeMessage(line);
}

/// Room for so many bytes at a multiple of 8. The system gives memory as it is filled.
std::shared_ptr<std::uint64_t[]> room(std::uint64_t bytes) {
  return std::shared_ptr<std::uint64_t[]>(new std::uint64_t[bytes / 8 + 1]);
}

}  // namespace

void MessageReader::feed(std::string_view bytes) {
  if (waiting_ && !isFilled()) {
    const std::size_t taken = std::min<std::size_t>(bytes.size(), blockBytes_ - filled_);
    std::memcpy(reinterpret_cast<char*>(block_.get()) + filled_, bytes.data(), taken);
    filled_ += taken;
    bytes.remove_prefix(taken);
  }
  if (!bytes.empty()) {
    lines_.feed(bytes);
  }
}

std::optional<MessageReader::Read> MessageReader::finish() {
  std::optional<Read> read = std::move(waiting_);
  waiting_.reset();
  if (*read && !(*read)->blockTable.empty()) {
    (*read)->payload.attach(std::make_shared<const Blocks>((*read)->blockTable, std::move(block_)));
  }
  block_.reset();
  return read;
}

std::optional<MessageReader::Read> MessageReader::next() {
  if (waiting_) {
    return isFilled() ? finish() : std::nullopt;
  }
  if (lost_) {
    return std::nullopt;
  }
  const std::string_view line = lines_.next();
  if (line.data() == nullptr) {
    if (lines_.isOverflowed()) {
      lost_ = limitError("lineBytes", lines_.overflowBytes(), lines_.maximumLineBytes(),
                         "Send shorter lines; the connection is closed, because the next message cannot be found.");
    }
    return std::nullopt;
  }
  Read read = decode(line, bulk_);
  const std::uint64_t bytes = blockBytesOf(read);
  if (bytes == 0 && (!read || read->blockTable.empty())) {
    return read;
  }
  if (!areBlocksAllowed_) {
    lost_ = notAgreed();
    return std::nullopt;
  }
  if (bytes > limits_.blockBytes) {
    lost_ = limitError("blockBytes", bytes, limits_.blockBytes,
                       "Send smaller blocks; the connection is closed, because the next message cannot be found.");
    return std::nullopt;
  }
  // the bytes that are there already; feed() brings the rest
  block_ = room(bytes);
  blockBytes_ = bytes;
  filled_ = lines_.take(reinterpret_cast<char*>(block_.get()), bytes);
  waiting_ = std::move(read);
  return isFilled() ? finish() : std::nullopt;
}

std::optional<MessageReader::Read> readFrame(std::string_view frame, bool isBinary, bool areBlocksAllowed,
                                             BulkTextReader& bulk, std::optional<Error>& problem) {
  std::string_view json = frame;
  std::string_view raw;
  if (isBinary) {
    std::uint32_t length = 0;
    if (frame.size() < sizeof(length)) {
      problem =
          Error{ErrorCode::InvalidRequest, "A binary frame begins with the length of its JSON in four bytes.", {}};
      return std::nullopt;
    }
    std::memcpy(&length, frame.data(), sizeof(length));
    const std::uint64_t begin = (sizeof(length) + std::uint64_t{length} + 7) / 8 * 8;
    if (length > frame.size() - sizeof(length)) {
      problem = Error{ErrorCode::InvalidRequest,
                      "A binary frame of " + std::to_string(frame.size()) + " bytes cannot have " +
                          std::to_string(length) + " bytes of JSON.",
                      {}};
      return std::nullopt;
    }
    json = frame.substr(sizeof(length), length);
    raw = begin < frame.size() ? frame.substr(begin) : std::string_view();
  }
  MessageReader::Read read = decode(json, bulk);
  const std::uint64_t bytes = blockBytesOf(read);
  if (bytes == 0 && (!read || read->blockTable.empty())) {
    return read;
  }
  if (!areBlocksAllowed) {
    problem = notAgreed();
    return std::nullopt;
  }
  if (bytes != raw.size()) {
    return tl::unexpected(
        BadMessage{read ? read->id : read.error().id,
                   memberError("binBytes", "the frame has " + std::to_string(raw.size()) +
                                               " raw bytes behind its JSON, found " + std::to_string(bytes))});
  }
  if (read) {
    auto block = room(bytes);
    if (bytes > 0) {
      std::memcpy(block.get(), raw.data(), bytes);
    }
    read->payload.attach(std::make_shared<const Blocks>(read->blockTable, std::move(block)));
  }
  return read;
}

std::string binaryFrame(std::string_view message) {
  const std::size_t end = message.find('\n');
  const auto length = static_cast<std::uint32_t>(end);
  std::string frame(reinterpret_cast<const char*>(&length), sizeof(length));
  frame.reserve(message.size() + 16);
  frame.append(message.substr(0, end));
  frame.append((8 - frame.size() % 8) % 8, '\0');
  frame.append(message.substr(end + 1));
  return frame;
}

bool hasBlocks(std::string_view message) {
  return message.find('\n') + 1 < message.size();
}

}  // namespace espalier::protocol
