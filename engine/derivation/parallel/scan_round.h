#pragma once

#include <atomic>
#include <cstdint>

namespace espalier::derivation {

/// The state that threads share in one round over the chunks of a string. Threads take chunks in order, and the places
/// of their results are decided in that order. Only the thread that has the turn reads or writes `modules` and
/// `parameters`.
struct ScanRound {
  std::uint64_t chunkCount = 0;
  std::uint64_t modules = 0;  // made by all chunks before `turn`
  std::uint64_t parameters = 0;
  std::atomic<std::uint64_t> next{0};      // the first chunk that no thread has taken
  std::atomic<std::uint64_t> turn{0};      // the chunk whose place is decided next
  std::atomic<std::uint64_t> stop{~0ULL};  // this round writes no chunk from here on
  std::atomic<std::uint32_t> changes{0};   // counts changes of `turn` and `stop`; waiting threads sleep on it

  ScanRound(std::uint64_t firstChunk, std::uint64_t count) : chunkCount(count), next(firstChunk), turn(firstChunk) {}

  /// Takes the next chunk. False when no chunk is left in this round.
  [[nodiscard]] bool take(std::uint64_t& chunk) {
    chunk = next.fetch_add(1);
    return chunk < chunkCount && chunk < stop.load();
  }

  void stopAt(std::uint64_t chunk) {
    std::uint64_t seen = stop.load();
    while (chunk < seen && !stop.compare_exchange_weak(seen, chunk)) {
    }
    tell();
  }

  /// Waits for the turn of the chunk. False when the round ends before.
  [[nodiscard]] bool awaitTurn(std::uint64_t chunk) const {
    for (int spins = 0;; ++spins) {
      const std::uint32_t seen = changes.load(std::memory_order_acquire);
      if (turn.load(std::memory_order_acquire) == chunk) {
        break;
      }
      if (stop.load(std::memory_order_acquire) <= chunk) {
        return false;
      }
      if (spins >= kSpins) {
        changes.wait(seen, std::memory_order_acquire);
      }
    }
    return stop.load(std::memory_order_acquire) > chunk;
  }

  void passTurn(std::uint64_t chunk) {
    turn.store(chunk + 1, std::memory_order_release);
    tell();
  }

  /// The chunk before which the round ended.
  [[nodiscard]] std::uint64_t end() const {
    const std::uint64_t stopped = stop.load();
    return stopped < chunkCount ? stopped : chunkCount;
  }

 private:
  // times that a waiting thread looks again before it sleeps. Yielding instead is worse where other programs keep all
  // processors busy: the thread gets its processor back before the thread that it waits for
  static constexpr int kSpins = 200;

  void tell() {
    changes.fetch_add(1, std::memory_order_release);
    changes.notify_all();
  }
};

}  // namespace espalier::derivation
