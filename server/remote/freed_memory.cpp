#include "server/remote/freed_memory.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <ctime>

namespace espalier::server {
namespace {

constexpr std::int64_t kTrimSeconds = 1;

/// So much freed memory stays at the end of a thread's heap, which malloc_trim does not give back.
constexpr int kHeapEndBytes = 8 << 20;
/// Larger blocks are mapped, and given back when they are freed. The most that the C library accepts.
constexpr int kMappedBytes = 32 << 20;

/// Much was freed, and the heap has not been trimmed since.
std::atomic<bool> isTrimWanted{false};
std::atomic<std::int64_t> lastTrim{-kTrimSeconds};  // seconds of the monotonic clock

std::int64_t monotonicSeconds() noexcept {
  timespec now{};
  static_cast<void>(clock_gettime(CLOCK_MONOTONIC, &now));
  return now.tv_sec;
}

}  // namespace

void boundHeaps(unsigned workers) {
  static_cast<void>(mallopt(M_ARENA_MAX, static_cast<int>(std::max(workers, 1U) + 1)));
  // left alone, the library raises the first bound to 64 MB for each heap
  static_cast<void>(mallopt(M_TRIM_THRESHOLD, kHeapEndBytes));
  static_cast<void>(mallopt(M_MMAP_THRESHOLD, kMappedBytes));
}

void noteFreed(std::size_t bytes) noexcept {
  if (bytes > kHeapEndBytes) {
    isTrimWanted = true;
  }
}

bool isHeapTrimDue() noexcept {
  return isTrimWanted && monotonicSeconds() - lastTrim >= kTrimSeconds;
}

void trimHeap() noexcept {
  std::int64_t before = lastTrim;
  if (isHeapTrimDue() && lastTrim.compare_exchange_strong(before, monotonicSeconds())) {
    isTrimWanted = false;
    static_cast<void>(malloc_trim(0));
  }
}

}  // namespace espalier::server
