#include "server/store/compression.h"

#include <zstd.h>
#include <zstd_errors.h>

#include <new>

#include "server/remote/zstd_context.h"

namespace espalier::server {
namespace {

/// Higher levels save little more and cost a multiple.
constexpr int kLevel = 1;

}  // namespace

std::string compress(std::string_view bytes) {
  const ZstdCompressor context = makeZstdCompressor();
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
  std::string packed(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size = ZSTD_compress2(context.get(), packed.data(), packed.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(size) != 0) {
    throw std::bad_alloc();
  }
  packed.resize(size);
  return packed;
}

std::optional<std::string> decompress(std::string_view packed, std::uint64_t maximumBytes) {
  const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
  if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) {
    return std::nullopt;
  }
  // no frame can hold so much: a block of 128 KB takes four bytes at least
  constexpr unsigned long long kMostBytesOfAByte = 32'768;
  if (size / kMostBytesOfAByte > packed.size() || size > maximumBytes) {
    return std::nullopt;
  }
  std::string bytes(static_cast<std::size_t>(size), '\0');
  const std::size_t found =
      ZSTD_decompressDCtx(makeZstdDecompressor().get(), bytes.data(), bytes.size(), packed.data(), packed.size());
  if (ZSTD_isError(found) != 0 && ZSTD_getErrorCode(found) == ZSTD_error_memory_allocation) {
    throw std::bad_alloc();
  }
  if (ZSTD_isError(found) != 0 || found != size) {
    return std::nullopt;
  }
  return bytes;
}

}  // namespace espalier::server
