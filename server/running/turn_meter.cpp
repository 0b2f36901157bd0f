#include "server/running/turn_meter.h"

#include <algorithm>
#include <ctime>
#include <exception>

#include "server/remote/freed_memory.h"

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

TurnMeter::~TurnMeter() {
  giveBack();
  // the worker trims the heap when the task with its parameters is gone, too
  if (wasLarge_) {
    noteFreed(kLargeBytes);
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
