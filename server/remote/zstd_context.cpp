#include "server/remote/zstd_context.h"

// for the functions that take an allocator
#define ZSTD_STATIC_LINKING_ONLY
#include <zstd.h>

#include <new>

namespace espalier::server {
namespace {

ZSTD_customMem memory() {
  return {[](void* /*unused*/, std::size_t size) { return ::operator new(size, std::nothrow); },
          [](void* /*unused*/, void* block) { ::operator delete(block); }, nullptr};
}

}  // namespace

void ZstdFree::operator()(ZSTD_CCtx_s* context) const {
  ZSTD_freeCCtx(context);
}

void ZstdFree::operator()(ZSTD_DCtx_s* context) const {
  ZSTD_freeDCtx(context);
}

ZstdCompressor makeZstdCompressor() {
  ZstdCompressor context(ZSTD_createCCtx_advanced(memory()));
  return context != nullptr ? std::move(context) : throw std::bad_alloc();
}

ZstdDecompressor makeZstdDecompressor() {
  ZstdDecompressor context(ZSTD_createDCtx_advanced(memory()));
  return context != nullptr ? std::move(context) : throw std::bad_alloc();
}

}  // namespace espalier::server
