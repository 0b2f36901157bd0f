#include "protocol/framing.h"

namespace espalier::protocol {

void LineSplitter::feed(std::string_view bytes) {
  if (isOverflowed_) {
    return;
  }
  // drop what was returned already
  if (begin_ > 0) {
    buffer_.erase(0, begin_);
    scanned_ -= begin_;
    begin_ = 0;
  }
  // memory of one long line is not kept for ever
  if (buffer_.empty() && buffer_.capacity() > 1'000'000) {
    buffer_.shrink_to_fit();
  }
  buffer_.append(bytes);
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

}  // namespace espalier::protocol
