#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/errors.h"

namespace espalier::protocol {

/// Numbers of a block, little-endian: <f8, <f4, <u4.
enum class BlockType : std::uint8_t { Float64, Float32, Unsigned32 };

/// "<f8", and so on.
[[nodiscard]] std::string_view nameOf(BlockType type);
[[nodiscard]] std::size_t bytesOf(BlockType type);

/// One entry of `bin`: an array among the raw bytes that follow a message.
struct BlockDescription {
  std::string name;
  BlockType type = BlockType::Float64;
  std::vector<std::uint64_t> shape;  // row-major; at most three dimensions
  std::uint64_t offset = 0;          // in bytes, a multiple of 8
  std::uint64_t bytes = 0;           // the product of shape and the size of one number
  [[nodiscard]] std::uint64_t count() const { return bytes / bytesOf(type); }
};

/// The first mistake in the entries of `bin`, with its path, or nothing. Names must differ. Shape and bytes must agree.
/// Offsets must be multiples of 8. Blocks must lie within `totalBytes` raw bytes and not overlap.
[[nodiscard]] std::optional<Error> problemOf(const std::vector<BlockDescription>& blocks, std::uint64_t totalBytes);

/// The blocks that came with a message. Never changes; the spans live as long as the object.
class Blocks {
 public:
  /// `bytes` has room for all of them and begins at a multiple of 8; `descriptions` have no problemOf.
  Blocks(std::vector<BlockDescription> descriptions, std::shared_ptr<const std::uint64_t[]> bytes)
      : descriptions_(std::move(descriptions)), bytes_(std::move(bytes)) {}

  [[nodiscard]] const std::vector<BlockDescription>& descriptions() const { return descriptions_; }
  /// Null when there is none of the name.
  [[nodiscard]] const BlockDescription* find(std::string_view name) const;

  // the numbers of a block of that type
  [[nodiscard]] std::span<const double> doubles(const BlockDescription& block) const;
  [[nodiscard]] std::span<const float> floats(const BlockDescription& block) const;
  [[nodiscard]] std::span<const std::uint32_t> integers(const BlockDescription& block) const;

 private:
  [[nodiscard]] const char* at(const BlockDescription& block) const {
    return reinterpret_cast<const char*>(bytes_.get()) + block.offset;
  }

  std::vector<BlockDescription> descriptions_;
  std::shared_ptr<const std::uint64_t[]> bytes_;
};

/// Columns to be sent after a message. It refers to the numbers of add(), which must live until they are sent. It owns
/// the numbers of keep().
class BlockWriter {
 public:
  void add(std::string name, std::span<const double> numbers, std::vector<std::uint64_t> shape);
  void add(std::string name, std::span<const float> numbers, std::vector<std::uint64_t> shape);
  void add(std::string name, std::span<const std::uint32_t> numbers, std::vector<std::uint64_t> shape);
  // the same for numbers that were made for this message
  void keep(std::string name, std::vector<double> numbers, std::vector<std::uint64_t> shape);
  void keep(std::string name, std::vector<float> numbers, std::vector<std::uint64_t> shape);
  void keep(std::string name, std::vector<std::uint32_t> numbers, std::vector<std::uint64_t> shape);

  /// Keeps the owner of numbers that were added.
  void own(std::shared_ptr<const void> owner) { kept_.push_back(std::move(owner)); }

  [[nodiscard]] bool isEmpty() const { return descriptions_.empty(); }
  /// Raw bytes of all blocks, with the zeros between them.
  [[nodiscard]] std::uint64_t totalBytes() const { return totalBytes_; }
  /// `"bin":[...],"binBytes":N`
  [[nodiscard]] std::string members() const;
  /// Appends the raw bytes.
  void appendTo(std::string& bytes) const;

 private:
  void describe(std::string name, BlockType type, const void* numbers, std::size_t count,
                std::vector<std::uint64_t> shape);

  std::vector<BlockDescription> descriptions_;
  std::vector<const void*> numbers_;               // of each block
  std::vector<std::shared_ptr<const void>> kept_;  // owners of the numbers
  std::uint64_t totalBytes_ = 0;
};

/// The params or the result of a message to be sent: JSON text, and blocks when the peer takes them.
struct Body {
  Body() = default;
  Body(std::string text) : json(std::move(text)) {}  // NOLINT: a text is a body
  Body(const char* text) : json(text) {}             // NOLINT

  std::string json;
  BlockWriter blocks;  // empty: none
};

}  // namespace espalier::protocol
