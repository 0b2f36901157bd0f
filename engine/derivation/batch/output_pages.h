#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace espalier::derivation {

/// The huge pages of a block of memory that several threads write from front to back. Two threads that touch the same
/// fresh page at the same time both wait for it to be cleared, and would gain nothing from being two; here one of them
/// has the page cleared and the other meanwhile the next one.
class OutputPages {
 public:
  /// `bytes` of memory from `memory` on; nothing is touched yet.
  void cover(void* memory, std::size_t bytes);
  /// Returns when the bytes [begin, end) can be written without a page fault, or the system gives no such help.
  void prepare(std::size_t begin, std::size_t end);

 private:
  enum State : std::uint8_t { Untouched, InWork, Ready };
  bool claim(std::size_t page);

  char* memory_ = nullptr;
  std::size_t bytes_ = 0;
  std::vector<std::atomic<std::uint8_t>> states_;  // by page
};

}  // namespace espalier::derivation
