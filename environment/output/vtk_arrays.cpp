#include "environment/output/vtk_arrays.h"

#include <zlib.h>

#include <algorithm>
#include <cstdint>

#include "engine/core/base64.h"

namespace espalier::environment {

namespace {

/// A number of the header that stands before the data.
std::uint64_t headerNumber(std::string_view bytes, std::size_t index, std::size_t size) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < size; ++i) {
    number |= std::uint64_t{static_cast<unsigned char>(bytes[index * size + i])} << (8 * i);
  }
  return number;
}

}  // namespace

std::optional<std::string> fromBase64Pieces(std::string_view text, std::size_t most) {
  std::string bytes;
  std::uint32_t group = 0;
  int digits = 0;
  int padding = 0;
  for (const char character : text) {
    if (character == '<' || bytes.size() >= most) {
      break;
    }
    if (character == ' ' || character == '\n' || character == '\r' || character == '\t') {
      continue;
    }
    const std::size_t digit = character == '=' ? 0 : core::kBase64Digits.find(character);
    if (digit == std::string_view::npos) {
      return std::nullopt;
    }
    padding += character == '=' ? 1 : 0;
    group = (group << 6U) | static_cast<std::uint32_t>(digit);
    if (++digits == 4) {
      for (int k = 0; k < 3 - padding; ++k) {
        bytes.push_back(static_cast<char>((group >> (16 - 8 * k)) & 0xFFU));
      }
      group = 0;
      digits = 0;
      padding = 0;
    }
  }
  bytes.resize(std::min(bytes.size(), most));
  return digits == 0 ? std::optional(bytes) : std::nullopt;
}

tl::expected<std::string, std::string> unpackedBytes(std::string_view data, bool isBase64, const VtkPacking& packing,
                                                     std::size_t most) {
  const tl::unexpected<std::string> damaged("has a data array that is damaged or cut short. Get a complete copy");
  const tl::unexpected<std::string> tooLong("has a data array that is too long for its cells. Get an undamaged copy");
  const std::size_t size = packing.hasLongHeader ? 8 : 4;
  const auto taken = [&](std::uint64_t count) -> std::optional<std::string> {
    auto bytes = isBase64 ? fromBase64Pieces(data, count) : std::optional(std::string(data.substr(0, count)));
    return bytes && bytes->size() == count ? std::move(bytes) : std::nullopt;
  };
  if (!packing.isCompressed) {
    // the number of bytes, then the bytes
    const auto header = taken(size);
    if (!header) {
      return damaged;
    }
    const std::uint64_t length = headerNumber(*header, 0, size);
    if (length > most) {
      return tooLong;
    }
    auto bytes = taken(size + length);
    return bytes ? tl::expected<std::string, std::string>(bytes->substr(size)) : damaged;
  }
  // the number of blocks, the unpacked size of a block and that of the last if it is smaller, the packed size of each
  const auto start = taken(3 * size);
  if (!start) {
    return damaged;
  }
  const std::uint64_t blocks = headerNumber(*start, 0, size);
  const std::uint64_t blockBytes = headerNumber(*start, 1, size);
  const std::uint64_t lastBytes = headerNumber(*start, 2, size);
  if (blocks == 0) {
    return std::string();
  }
  if (blocks > data.size() / size) {
    return damaged;
  }
  const std::uint64_t wholeBlocks = lastBytes == 0 ? blocks : blocks - 1;
  if (lastBytes > most || (wholeBlocks > 0 && blockBytes > (most - lastBytes) / wholeBlocks)) {
    return tooLong;
  }
  const std::uint64_t length = wholeBlocks * blockBytes + lastBytes;
  const std::uint64_t headerBytes = (3 + blocks) * size;
  const auto header = taken(headerBytes);
  if (!header) {
    return damaged;
  }
  std::uint64_t packedBytes = 0;
  for (std::uint64_t i = 0; i < blocks; ++i) {
    const std::uint64_t packed = headerNumber(*header, 3 + i, size);
    if (packed > data.size() - packedBytes) {
      return damaged;
    }
    packedBytes += packed;
  }
  const auto packed = taken(headerBytes + packedBytes);
  if (!packed) {
    return damaged;
  }
  std::string bytes(length, '\0');
  std::size_t from = headerBytes;
  for (std::uint64_t i = 0; i < blocks; ++i) {
    const std::uint64_t wanted = i < wholeBlocks ? blockBytes : lastBytes;
    const std::uint64_t given = headerNumber(*header, 3 + i, size);
    uLongf written = wanted;
    const int status = uncompress(reinterpret_cast<Bytef*>(bytes.data() + i * blockBytes), &written,
                                  reinterpret_cast<const Bytef*>(packed->data() + from), given);
    if (status != Z_OK || written != wanted) {
      return damaged;
    }
    from += given;
  }
  return bytes;
}

}  // namespace espalier::environment
