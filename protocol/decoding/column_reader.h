#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/blocks.h"
#include "protocol/decoding/member.h"
#include "protocol/payload.h"

namespace espalier::protocol {

// For protocol's own decoders. A mistake in a block is thrown as MemberFailure.

/// A block that is wrong: `bin.PLACE: WHAT`.
[[noreturn]] inline void failBlock(const std::string& place, const std::string& what) {
  throw MemberFailure{memberError("bin." + place, what)};
}

/// `[2,3]`
inline std::string shapeText(const BlockDescription& block) {
  std::string text = "[";
  for (const std::uint64_t extent : block.shape) {
    text += (text.size() > 1 ? "," : "") + std::to_string(extent);
  }
  return text + "]";
}

/// Reads the blocks of one message.
class ColumnReader {
 public:
  explicit ColumnReader(const Payload& payload) : blocks_(payload.blocks()) {}

  /// The block, or null. Its shape must be [rows], or [rows, width].
  [[nodiscard]] const BlockDescription* column(std::string_view name, std::uint64_t rows,
                                               std::optional<std::uint64_t> width = std::nullopt) const {
    const BlockDescription* block = blocks_->find(name);
    if (block == nullptr) {
      return nullptr;
    }
    const std::vector<std::uint64_t> expected =
        width ? std::vector<std::uint64_t>{rows, *width} : std::vector<std::uint64_t>{rows};
    if (block->shape != expected) {
      failBlock(block->name,
                "expected the shape " + shapeText({"", block->type, expected, 0, 0}) + ", found " + shapeText(*block));
    }
    return block;
  }
  [[nodiscard]] const BlockDescription& required(std::string_view name) const {
    const BlockDescription* block = blocks_->find(name);
    if (block == nullptr) {
      failBlock(std::string(name), "the block is missing");
    }
    return *block;
  }

  [[nodiscard]] std::span<const std::uint32_t> integers(const BlockDescription* block) const {
    if (block == nullptr) {
      return {};
    }
    if (block->type != BlockType::Unsigned32) {
      failBlock(block->name, "expected the dtype <u4, found " + std::string(nameOf(block->type)));
    }
    return blocks_->integers(*block);
  }

  /// Finite numbers; single precision is widened into `storage`.
  [[nodiscard]] std::span<const double> numbers(const BlockDescription* block, std::vector<double>& storage) const {
    if (block == nullptr) {
      return {};
    }
    std::span<const double> numbers;
    if (block->type == BlockType::Float64) {
      numbers = blocks_->doubles(*block);
    } else if (block->type == BlockType::Float32) {
      const auto floats = blocks_->floats(*block);
      storage.assign(floats.begin(), floats.end());
      numbers = storage;
    } else {
      failBlock(block->name, "expected the dtype <f8 or <f4, found " + std::string(nameOf(block->type)));
    }
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (!std::isfinite(numbers[i])) {
        failBlock(block->name + "[" + std::to_string(i) + "]", "NaN and infinity are not numbers of the protocol");
      }
    }
    return numbers;
  }

  /// Where each row's numbers lie in a block of the shape [rows, width], or of the shape [total] together with the
  /// block `offsetName` of the shape [rows + 1].
  [[nodiscard]] std::span<const std::uint64_t> offsets(const BlockDescription& block, std::string_view offsetName,
                                                       std::uint64_t rows, std::vector<std::uint64_t>& storage) const {
    storage.resize(rows + 1);
    if (block.shape.size() == 2) {
      (void)column(block.name, rows, block.shape[1]);
      for (std::uint64_t i = 0; i <= rows; ++i) {
        storage[i] = i * block.shape[1];
      }
      return storage;
    }
    if (block.shape.size() != 1) {
      failBlock(block.name, "expected the shape [rows, numbers] or [numbers], found " + shapeText(block));
    }
    (void)required(offsetName);
    const auto given = integers(column(offsetName, rows + 1));
    std::uint64_t before = 0;
    for (std::uint64_t i = 0; i <= rows; ++i) {
      const bool isRight = given[i] >= before && (i > 0 || given[i] == 0) && (i < rows || given[i] == block.count());
      if (!isRight) {
        failBlock(std::string(offsetName) + "[" + std::to_string(i) + "]", "expected offsets that rise from 0 to " +
                                                                               std::to_string(block.count()) +
                                                                               ", found " + std::to_string(given[i]));
      }
      before = given[i];
      storage[i] = before;
    }
    return storage;
  }

 private:
  const Blocks* blocks_;
};

/// The first extent of a block.
inline std::uint64_t rowsOf(const BlockDescription& block) {
  if (block.shape.empty()) {
    failBlock(block.name, "expected an array, found one number");
  }
  return block.shape[0];
}

}  // namespace espalier::protocol
