#include "engine/core/buffer.h"

#include <sys/mman.h>

#include <cstdint>
#include <cstdlib>
#include <new>

namespace espalier::core {
namespace {

// below this a block comes from the heap: a mapping costs a system call and whole pages
constexpr std::size_t kMappedBytes = std::size_t{1} << 20U;
constexpr std::size_t kHugePageBytes = std::size_t{2} << 20U;

std::size_t mappedSize(std::size_t byteCount) {
  return (byteCount + kHugePageBytes - 1) & ~(kHugePageBytes - 1);
}

}  // namespace

void* mapPages(std::size_t byteCount) {
  if (byteCount < kMappedBytes) {
    void* memory = std::malloc(byteCount);
    if (memory == nullptr) {
      throw std::bad_alloc();
    }
    return memory;
  }
  if (byteCount > SIZE_MAX - 2 * kHugePageBytes) {
    throw std::bad_alloc();
  }
  void* memory =
      mmap(nullptr, mappedSize(byteCount), PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) {
    throw std::bad_alloc();
  }
  // advice only: without huge pages the memory works, slower to touch first
  static_cast<void>(madvise(memory, mappedSize(byteCount), MADV_HUGEPAGE));
  return memory;
}

void unmapPages(void* memory, std::size_t byteCount) noexcept {
  if (byteCount < kMappedBytes) {
    std::free(memory);
  } else {
    static_cast<void>(munmap(memory, mappedSize(byteCount)));
  }
}

}  // namespace espalier::core
