#include "server/running/turn_meter.h"

#include <malloc.h>

#include <ctime>

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

/// Gives freed memory back to the system, at most once in a second: the C library keeps it for each thread, so turns on
/// many threads would hold many times what is counted.
void trimHeap() noexcept {
  static std::atomic<std::int64_t> last{-kTrimSeconds};
  timespec now{};
  static_cast<void>(clock_gettime(CLOCK_MONOTONIC, &now));
  std::int64_t before = last;
  if (now.tv_sec - before >= kTrimSeconds && last.compare_exchange_strong(before, now.tv_sec)) {
    static_cast<void>(malloc_trim(0));
  }
}

std::uint64_t threadNanoseconds() noexcept {
  timespec time{};
  return clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time) == 0
             ? static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(time.tv_nsec)
             : 0;
}

}  // namespace

TurnMeter::~TurnMeter() {
  giveBack();
  if (wasLarge_) {
    trimHeap();
  }
}

bool TurnMeter::take(std::int64_t bytes) noexcept {
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
    if (bytes < kSmallBlockBytes && held < reserved + kGraceBytes) {
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
