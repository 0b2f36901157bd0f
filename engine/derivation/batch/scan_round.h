#pragma once

#include <atomic>
#include <cstdint>

namespace espalier::derivation {

/// What the threads of one round over the chunks of a string share: chunks are taken in order, and in that order their
/// places in the result are decided. Only the thread whose turn it is reads or writes `modules` and `parameters`.
struct ScanRound {
  std::uint64_t chunkCount = 0;
  std::uint64_t modules = 0;  // made by all chunks before `turn`
  std::uint64_t parameters = 0;
  std::atomic<std::uint64_t> next{0};      // chunk that nobody has taken yet
  std::atomic<std::uint64_t> turn{0};      // chunk whose place is decided next
  std::atomic<std::uint64_t> stop{~0ULL};  // no chunk from here on is written in this round
  std::atomic<std::uint32_t> changes{0};   // of `turn` and `stop`, counted: what waiting threads sleep on

  ScanRound(std::uint64_t firstChunk, std::uint64_t count) : chunkCount(count), next(firstChunk), turn(firstChunk) {}

  /// Takes the next chunk; false when there is none left in this round.
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

  /// Whether the turn of the chunk came; false when the round ends before.
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
  // times a waiting thread looks again before it sleeps. One that only gave way would get its processor back before the
  // thread it waits for, where other programs keep all processors busy
  static constexpr int kSpins = 200;

  void tell() {
    changes.fetch_add(1, std::memory_order_release);
    changes.notify_all();
  }
};

}  // namespace espalier::derivation
