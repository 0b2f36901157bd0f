#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

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
  }

  /// Whether the turn of the chunk came; false when the round ends before.
  [[nodiscard]] bool awaitTurn(std::uint64_t chunk) const {
    for (int spins = 0; turn.load(std::memory_order_acquire) != chunk; ++spins) {
      if (stop.load(std::memory_order_acquire) <= chunk) {
        return false;
      }
      if (spins >= kSpins) {
        std::this_thread::yield();
      }
    }
    return stop.load(std::memory_order_acquire) > chunk;
  }

  void passTurn(std::uint64_t chunk) { turn.store(chunk + 1, std::memory_order_release); }

  /// The chunk before which the round ended.
  [[nodiscard]] std::uint64_t end() const {
    const std::uint64_t stopped = stop.load();
    return stopped < chunkCount ? stopped : chunkCount;
  }

 private:
  // turns a waiting thread looks again before it lets others run
  static constexpr int kSpins = 200;
};

}  // namespace espalier::derivation
