#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace espalier::derivation {

/// The huge pages of a block of memory that several threads write from front to back. Two threads that touch the same
/// fresh page at the same time both wait while the system clears it. With this class one thread has the page cleared,
/// and the other thread the next page meanwhile.
class OutputPages {
 public:
  /// `bytes` of memory from `memory` on; nothing is touched yet.
  void cover(void* memory, std::size_t bytes);
  /// Returns when the bytes [begin, end) can be written without a page fault, or at once where the system cannot clear
  /// pages ahead.
  void prepare(std::size_t begin, std::size_t end);

 private:
  enum State : std::uint8_t { Untouched, InWork, Ready };
  bool claim(std::size_t page);

  char* memory_ = nullptr;
  std::size_t bytes_ = 0;
  std::vector<std::atomic<std::uint8_t>> states_;  // by page
};

}  // namespace espalier::derivation
