#include "engine/core/buffer.h"

#include <sys/mman.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stop_token>
#include <system_error>

#include "engine/core/work_meter.h"

namespace espalier::core {
namespace {

// below this a block comes from the heap: a mapping costs a system call and a whole huge page. In a virtual machine a
// page of 4 KB costs 5 to 25 us at its first touch, a huge page 200
constexpr std::size_t kMappedBytes = std::size_t{1} << 19U;

constexpr std::size_t kSharedBytes = std::size_t{8} << 20U;  // that are worth a thread to touch them

std::size_t mappedSize(std::size_t byteCount) {
  return (byteCount + kHugePageBytes - 1) & ~(kHugePageBytes - 1);
}

/// Reserves address space that begins at a huge page.
void* mapAligned(std::size_t size, int protection) {
  const std::size_t wanted = size + kHugePageBytes;
  void* memory = mmap(nullptr, wanted, protection, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) {
    throw std::bad_alloc();
  }
  // unmap the surplus at both ends
  char* begin = static_cast<char*>(memory);
  const std::size_t before =
      (kHugePageBytes - reinterpret_cast<std::uintptr_t>(begin) % kHugePageBytes) % kHugePageBytes;
  if (before > 0) {
    static_cast<void>(munmap(begin, before));
  }
  static_cast<void>(munmap(begin + before + size, kHugePageBytes - before));
  return begin + before;
}

/// The same for memory that takeMemory has counted.
void* mapCounted(std::size_t size, int protection, std::size_t counted) {
  try {
    return mapAligned(size, protection);
  } catch (const std::bad_alloc&) {
    giveMemory(counted);
    throw;
  }
}

}  // namespace

void* mapPages(std::size_t byteCount) {
  if (byteCount > SIZE_MAX - 2 * kHugePageBytes) {
    throw std::bad_alloc();
  }
  takeMemory(byteCount);
  if (byteCount < kMappedBytes) {
    void* memory = std::malloc(byteCount);
    if (memory == nullptr) {
      giveMemory(byteCount);
      throw std::bad_alloc();
    }
    return memory;
  }
  void* memory = mapCounted(mappedSize(byteCount), PROT_READ | PROT_WRITE, byteCount);
  // only advice: without huge pages the first touch is slower
  static_cast<void>(madvise(memory, mappedSize(byteCount), MADV_HUGEPAGE));
  return memory;
}

void* growPages(void* memory, std::size_t byteCount, std::size_t usedByteCount, std::size_t newByteCount) {
  if (byteCount >= kMappedBytes && newByteCount > byteCount) {
    if (newByteCount > SIZE_MAX - 2 * kHugePageBytes) {
      throw std::bad_alloc();
    }
    const std::size_t newSize = mappedSize(newByteCount);
    takeMemory(newByteCount - byteCount);
    if (newSize == mappedSize(byteCount)) {
      return memory;
    }
    // the new address is the start of a huge page too, otherwise the system splits the pages
    void* target = mapCounted(newSize, PROT_NONE, newByteCount - byteCount);
    void* moved = mremap(memory, mappedSize(byteCount), newSize, MREMAP_MAYMOVE | MREMAP_FIXED, target);
    if (moved == MAP_FAILED) {
      static_cast<void>(munmap(target, newSize));
      giveMemory(newByteCount - byteCount);
      throw std::bad_alloc();
    }
    return moved;
  }
  void* fresh = mapPages(newByteCount);
  std::memcpy(fresh, memory, usedByteCount);
  unmapPages(memory, byteCount);
  return fresh;
}

void populatePages(void* memory, std::size_t byteCount) noexcept {
#ifdef MADV_POPULATE_WRITE
  static_cast<void>(madvise(memory, byteCount, MADV_POPULATE_WRITE));
#else
  static_cast<void>(memory);
  static_cast<void>(byteCount);
#endif
}

std::jthread populatePagesFromEnd(void* memory, std::size_t byteCount) noexcept {
  if (byteCount < kSharedBytes) {
    return {};
  }
  // the whole huge pages of the block
  const auto address = reinterpret_cast<std::uintptr_t>(memory);
  const std::size_t before = (kHugePageBytes - address % kHugePageBytes) % kHugePageBytes;
  char* const begin = static_cast<char*>(memory) + before;
  const std::size_t pages = (byteCount - before) / kHugePageBytes;
  try {
    return std::jthread([begin, pages](const std::stop_token& stop) {
      for (std::size_t page = pages; page-- > 0 && !stop.stop_requested();) {
        populatePages(begin + page * kHugePageBytes, kHugePageBytes);
      }
    });
  } catch (const std::system_error&) {
    return {};
  } catch (const std::bad_alloc&) {
    return {};
  }
}

void unmapPages(void* memory, std::size_t byteCount) noexcept {
  giveMemory(byteCount);
  if (byteCount < kMappedBytes) {
    std::free(memory);
  } else {
    static_cast<void>(munmap(memory, mappedSize(byteCount)));
  }
}

void adviseHugePages(void* memory, std::size_t byteCount) noexcept {
  // the whole huge pages of the block
  const auto begin = (reinterpret_cast<std::uintptr_t>(memory) + kHugePageBytes - 1) & ~(kHugePageBytes - 1);
  const auto end = (reinterpret_cast<std::uintptr_t>(memory) + byteCount) & ~(kHugePageBytes - 1);
  if (end > begin) {
    static_cast<void>(madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE));
  }
}

}  // namespace espalier::core
