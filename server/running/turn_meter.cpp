#include "server/running/turn_meter.h"

#include <malloc.h>

#include <algorithm>
#include <ctime>
#include <exception>

namespace espalier::server {
namespace {

/// Memory is reserved in such pieces, so that small blocks seldom reach the account.
constexpr std::int64_t kPieceBytes = 1 << 20;
/// So much is not reserved: what a short turn takes for its answer never shows.
constexpr std::int64_t kFreeBytes = 1 << 18;
/// Smaller blocks are refused only when the turn has this much more than its account allows: code that makes a message
/// about a refusal needs some.
constexpr std::int64_t kSmallBlockBytes = 1 << 16;
constexpr std::int64_t kGraceBytes = 64 << 20;

/// After a turn that reserved so much.
constexpr std::int64_t kLargeBytes = 32 << 20;
constexpr std::int64_t kTrimSeconds = 1;

/// So much freed memory stays at the end of a thread's heap, which malloc_trim does not give back.
constexpr int kHeapEndBytes = 8 << 20;
/// Larger blocks are mapped, and given back when they are freed. The most that the C library accepts.
constexpr int kMappedBytes = 32 << 20;

/// A turn was large, and the heap has not been trimmed since.
std::atomic<bool> isTrimWanted{false};
std::atomic<std::int64_t> lastTrim{-kTrimSeconds};  // seconds of the monotonic clock

std::int64_t monotonicSeconds() noexcept {
  timespec now{};
  static_cast<void>(clock_gettime(CLOCK_MONOTONIC, &now));
  return now.tv_sec;
}

/// An exception ends the work: destructors that take memory for a moment, as those of the JSON library do, cannot fail.
bool isUnwinding() noexcept {
  return std::uncaught_exceptions() > 0;
}

std::uint64_t threadNanoseconds() noexcept {
  timespec time{};
  return clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time) == 0
             ? static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(time.tv_nsec)
             : 0;
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

TurnMeter::~TurnMeter() {
  giveBack();
  if (wasLarge_) {
    isTrimWanted = true;
    trimHeap();
  }
}

bool TurnMeter::take(std::int64_t bytes) noexcept {
  if (whenStopped_ == WhenStopped::GetsNoMemory && bytes > 0 && isStopped_ && !isUnwinding()) {
    return false;
  }
  const std::int64_t held = held_ += bytes;
  std::int64_t reserved = reserved_;
  while (bytes > 0 && held > reserved + kFreeBytes) {
    const std::int64_t wanted = (held - reserved + kPieceBytes - 1) / kPieceBytes * kPieceBytes;
    if (account_->take(kind_, static_cast<std::uint64_t>(wanted))) {
      reserved = reserved_ += wanted;
      if (reserved >= kLargeBytes) {
        wasLarge_ = true;
      }
      continue;
    }
    isRefused_ = true;
    if ((bytes < kSmallBlockBytes && held < reserved + kGraceBytes) || isUnwinding()) {
      return true;
    }
    held_ -= bytes;
    return false;
  }
  return true;
}

std::uint64_t TurnMeter::enter() noexcept {
  return threadNanoseconds();
}

void TurnMeter::leave(std::uint64_t entered) noexcept {
  account_->spend(threadNanoseconds() - entered);
}

void TurnMeter::giveBack() noexcept {
  account_->add(kind_, -reserved_.exchange(0));
  held_ = 0;
}

}  // namespace espalier::server
