// The operators new and delete of a program with a server: as the standard library's, and they tell the meter of the
// calling thread. A thread without a meter pays for one look at a thread-local pointer.

#include <malloc.h>

#include <cstdlib>
#include <new>

#include "engine/core/work_meter.h"
#include "server/running/turn_meter.h"

namespace {

using espalier::core::WorkMeter;

void* takeBlock(std::size_t size, std::size_t alignment) noexcept {
  const std::size_t wanted = size == 0 ? 1 : size;
  return alignment <= __STDCPP_DEFAULT_NEW_ALIGNMENT__
             ? std::malloc(wanted)
             : std::aligned_alloc(alignment, (wanted + alignment - 1) / alignment * alignment);
}

[[gnu::noinline]] void* takeMeteredBlock(WorkMeter& meter, std::size_t size, std::size_t alignment) noexcept {
  if (!meter.take(static_cast<std::int64_t>(size))) {
    return nullptr;
  }
  void* const block = takeBlock(size, alignment);
  // the block may be larger; that is what free() will give back
  const auto more = block == nullptr
                        ? -static_cast<std::int64_t>(size)
                        : static_cast<std::int64_t>(malloc_usable_size(block)) - static_cast<std::int64_t>(size);
  if (more != 0) {
    static_cast<void>(meter.take(more));
  }
  return block;
}

inline void* allocate(std::size_t size, std::size_t alignment) noexcept {
  WorkMeter* const meter = WorkMeter::current();
  return meter == nullptr ? takeBlock(size, alignment) : takeMeteredBlock(*meter, size, alignment);
}

[[gnu::noinline]] void* allocateByHandler(std::size_t size, std::size_t alignment) {
  while (true) {
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) {
      throw std::bad_alloc();
    }
    handler();
    if (void* const block = allocate(size, alignment)) {
      return block;
    }
  }
}

inline void* allocateOrThrow(std::size_t size, std::size_t alignment) {
  void* const block = allocate(size, alignment);
  return block != nullptr ? block : allocateByHandler(size, alignment);
}

[[gnu::noinline]] void releaseMetered(WorkMeter& meter, void* block) noexcept {
  static_cast<void>(meter.take(-static_cast<std::int64_t>(malloc_usable_size(block))));
  std::free(block);
}

inline void release(void* block) noexcept {
  if (WorkMeter* const meter = WorkMeter::current(); meter != nullptr && block != nullptr) {
    releaseMetered(*meter, block);
  } else {
    std::free(block);
  }
}

constexpr std::size_t kPlain = __STDCPP_DEFAULT_NEW_ALIGNMENT__;

}  // namespace

bool espalier::server::isHeapMetered() {
  return true;
}

void* operator new(std::size_t size) {
  return allocateOrThrow(size, kPlain);
}
void* operator new[](std::size_t size) {
  return allocateOrThrow(size, kPlain);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocateOrThrow(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocateOrThrow(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocate(size, kPlain);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return allocate(size, kPlain);
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* block) noexcept {
  release(block);
}
void operator delete[](void* block) noexcept {
  release(block);
}
void operator delete(void* block, std::size_t) noexcept {
  release(block);
}
void operator delete[](void* block, std::size_t) noexcept {
  release(block);
}
void operator delete(void* block, std::align_val_t) noexcept {
  release(block);
}
void operator delete[](void* block, std::align_val_t) noexcept {
  release(block);
}
void operator delete(void* block, std::size_t, std::align_val_t) noexcept {
  release(block);
}
void operator delete[](void* block, std::size_t, std::align_val_t) noexcept {
  release(block);
}
void operator delete(void* block, const std::nothrow_t&) noexcept {
  release(block);
}
void operator delete[](void* block, const std::nothrow_t&) noexcept {
  release(block);
}
void operator delete(void* block, std::align_val_t, const std::nothrow_t&) noexcept {
  release(block);
}
void operator delete[](void* block, std::align_val_t, const std::nothrow_t&) noexcept {
  release(block);
}
