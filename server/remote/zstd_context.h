#pragma once

#include <memory>

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace espalier::server {

struct ZstdFree {
  void operator()(ZSTD_CCtx_s* context) const;
  void operator()(ZSTD_DCtx_s* context) const;
};

/// Contexts that take their memory by `new`: the meter of the thread counts it and may refuse it.
using ZstdCompressor = std::unique_ptr<ZSTD_CCtx_s, ZstdFree>;
using ZstdDecompressor = std::unique_ptr<ZSTD_DCtx_s, ZstdFree>;

/// Throws std::bad_alloc.
[[nodiscard]] ZstdCompressor makeZstdCompressor();
[[nodiscard]] ZstdDecompressor makeZstdDecompressor();

}  // namespace espalier::server
