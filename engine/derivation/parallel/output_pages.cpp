#include "engine/derivation/parallel/output_pages.h"

#include <algorithm>

#include "engine/core/buffer.h"

namespace espalier::derivation {

void OutputPages::cover(void* memory, std::size_t bytes) {
  memory_ = static_cast<char*>(memory);
  bytes_ = bytes;
  states_ = std::vector<std::atomic<std::uint8_t>>((bytes + core::kHugePageBytes - 1) / core::kHugePageBytes);
}

bool OutputPages::claim(std::size_t page) {
  std::uint8_t expected = Untouched;
  if (!states_[page].compare_exchange_strong(expected, InWork, std::memory_order_acq_rel)) {
    return false;
  }
  const std::size_t begin = page * core::kHugePageBytes;
  core::populatePages(memory_ + begin, std::min(core::kHugePageBytes, bytes_ - begin));
  states_[page].store(Ready, std::memory_order_release);
  states_[page].notify_all();
  return true;
}

void OutputPages::prepare(std::size_t begin, std::size_t end) {
  if (begin == end) {
    return;
  }
  for (std::size_t page = begin / core::kHugePageBytes; page <= (end - 1) / core::kHugePageBytes; ++page) {
    if (states_[page].load(std::memory_order_acquire) == Ready || claim(page)) {
      continue;
    }
    // another thread clears this page: clear the next page, which is needed soon
    if (page + 1 < states_.size()) {
      claim(page + 1);
    }
    states_[page].wait(InWork, std::memory_order_acquire);
  }
}

}  // namespace espalier::derivation
