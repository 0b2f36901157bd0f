#include "protocol/blocks.h"

#include <algorithm>
#include <bit>
#include <limits>

#include "protocol/json_writer.h"

namespace espalier::protocol {

static_assert(std::endian::native == std::endian::little, "blocks are little-endian and sent as they lie in memory");

namespace {

constexpr std::size_t kMostDimensions = 3;
constexpr std::size_t kMostBlocks = 64;
constexpr std::size_t kLongestNameBytes = 64;
constexpr std::uint64_t kAlignment = 8;

/// Bytes of an array, or nothing beyond 64 bits.
std::optional<std::uint64_t> bytesOf(const BlockDescription& block) {
  std::uint64_t bytes = bytesOf(block.type);
  for (const std::uint64_t extent : block.shape) {
    if (extent != 0 && bytes > std::numeric_limits<std::uint64_t>::max() / extent) {
      return std::nullopt;
    }
    bytes *= extent;
  }
  return bytes;
}

}  // namespace

std::string_view nameOf(BlockType type) {
  switch (type) {
    case BlockType::Float64:
      return "<f8";
    case BlockType::Float32:
      return "<f4";
    case BlockType::Unsigned32:
      return "<u4";
  }
  return "unknown";
}

std::size_t bytesOf(BlockType type) {
  return type == BlockType::Float64 ? 8 : 4;
}

std::optional<Error> problemOf(const std::vector<BlockDescription>& blocks, std::uint64_t totalBytes) {
  if (blocks.size() > kMostBlocks) {
    return memberError("bin",
                       "at most " + std::to_string(kMostBlocks) + " blocks, found " + std::to_string(blocks.size()));
  }
  std::vector<std::size_t> order(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const BlockDescription& block = blocks[i];
    const std::string path = "bin[" + std::to_string(i) + "]";
    if (block.name.empty() || block.name.size() > kLongestNameBytes) {
      return memberError(path + ".name", "expected 1 to " + std::to_string(kLongestNameBytes) + " bytes");
    }
    for (std::size_t before = 0; before < i; ++before) {
      if (blocks[before].name == block.name) {
        return memberError(path + ".name", "'" + block.name + "' is there twice");
      }
    }
    if (block.shape.size() > kMostDimensions) {
      return memberError(path + ".shape", "expected at most " + std::to_string(kMostDimensions) + " dimensions");
    }
    if (const auto bytes = bytesOf(block); bytes != block.bytes) {
      return memberError(path + ".bytes", "shape and dtype make " + (bytes ? std::to_string(*bytes) : "too many") +
                                              " bytes, found " + std::to_string(block.bytes));
    }
    if (block.offset % kAlignment != 0) {
      return memberError(path + ".offset", "expected a multiple of 8, found " + std::to_string(block.offset));
    }
    if (block.offset > totalBytes || block.bytes > totalBytes - block.offset) {
      return memberError(path + ".offset", "the block ends beyond binBytes=" + std::to_string(totalBytes));
    }
    order[i] = i;
  }
  // blocks side by side
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return blocks[a].offset != blocks[b].offset ? blocks[a].offset < blocks[b].offset
                                                : blocks[a].bytes < blocks[b].bytes;
  });
  for (std::size_t i = 1; i < order.size(); ++i) {
    const BlockDescription& before = blocks[order[i - 1]];
    const BlockDescription& block = blocks[order[i]];
    if (before.offset + before.bytes > block.offset) {
      return memberError("bin[" + std::to_string(order[i]) + "].offset",
                         "'" + block.name + "' overlaps '" + before.name + "'");
    }
  }
  return std::nullopt;
}

const BlockDescription* Blocks::find(std::string_view name) const {
  const auto found = std::find_if(descriptions_.begin(), descriptions_.end(),
                                  [&](const BlockDescription& block) { return block.name == name; });
  return found == descriptions_.end() ? nullptr : &*found;
}

std::span<const double> Blocks::doubles(const BlockDescription& block) const {
  return {reinterpret_cast<const double*>(at(block)), block.count()};
}

std::span<const float> Blocks::floats(const BlockDescription& block) const {
  return {reinterpret_cast<const float*>(at(block)), block.count()};
}

std::span<const std::uint32_t> Blocks::integers(const BlockDescription& block) const {
  return {reinterpret_cast<const std::uint32_t*>(at(block)), block.count()};
}

void BlockWriter::describe(std::string name, BlockType type, const void* numbers, std::size_t count,
                           std::vector<std::uint64_t> shape) {
  const std::uint64_t bytes = count * bytesOf(type);
  descriptions_.push_back({std::move(name), type, std::move(shape), totalBytes_, bytes});
  numbers_.push_back(numbers);
  totalBytes_ += (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

void BlockWriter::add(std::string name, std::span<const double> numbers, std::vector<std::uint64_t> shape) {
  describe(std::move(name), BlockType::Float64, numbers.data(), numbers.size(), std::move(shape));
}

void BlockWriter::add(std::string name, std::span<const float> numbers, std::vector<std::uint64_t> shape) {
  describe(std::move(name), BlockType::Float32, numbers.data(), numbers.size(), std::move(shape));
}

void BlockWriter::add(std::string name, std::span<const std::uint32_t> numbers, std::vector<std::uint64_t> shape) {
  describe(std::move(name), BlockType::Unsigned32, numbers.data(), numbers.size(), std::move(shape));
}

void BlockWriter::keep(std::string name, std::vector<double> numbers, std::vector<std::uint64_t> shape) {
  auto owner = std::make_shared<const std::vector<double>>(std::move(numbers));
  add(std::move(name), std::span<const double>(*owner), std::move(shape));
  kept_.push_back(std::move(owner));
}

void BlockWriter::keep(std::string name, std::vector<float> numbers, std::vector<std::uint64_t> shape) {
  auto owner = std::make_shared<const std::vector<float>>(std::move(numbers));
  add(std::move(name), std::span<const float>(*owner), std::move(shape));
  kept_.push_back(std::move(owner));
}

void BlockWriter::keep(std::string name, std::vector<std::uint32_t> numbers, std::vector<std::uint64_t> shape) {
  auto owner = std::make_shared<const std::vector<std::uint32_t>>(std::move(numbers));
  add(std::move(name), std::span<const std::uint32_t>(*owner), std::move(shape));
  kept_.push_back(std::move(owner));
}

std::string BlockWriter::members() const {
  JsonWriter writer;
  writer.key("bin").beginArray();
  for (const BlockDescription& block : descriptions_) {
    writer.beginObject().key("name").text(block.name).key("dtype").text(nameOf(block.type)).key("shape").beginArray();
    for (const std::uint64_t extent : block.shape) {
      writer.integer(extent);
    }
    writer.endArray().key("offset").integer(block.offset).key("bytes").integer(block.bytes).endObject();
  }
  return writer.endArray().key("binBytes").integer(totalBytes_).take();
}

void BlockWriter::appendTo(std::string& bytes) const {
  for (std::size_t i = 0; i < descriptions_.size(); ++i) {
    const std::uint64_t count = descriptions_[i].bytes;
    if (count > 0) {
      bytes.append(static_cast<const char*>(numbers_[i]), count);
    }
    bytes.append((kAlignment - count % kAlignment) % kAlignment, '\0');
  }
}

}  // namespace espalier::protocol
