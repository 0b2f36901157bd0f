#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace espalier::core {

/// Gives the engine the bytes of a file that may be longer than the memory, one piece after the other.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Appends the next `count` bytes to `bytes`, fewer only at the end. An error sentence, or nothing.
  [[nodiscard]] virtual std::optional<std::string> read(std::size_t count, std::string& bytes) = 0;
};

/// A source of bytes in memory, which must outlive it.
class ViewSource final : public ByteSource {
 public:
  explicit ViewSource(std::string_view bytes) : rest_(bytes) {}
  [[nodiscard]] std::optional<std::string> read(std::size_t count, std::string& bytes) override {
    const std::size_t given = std::min(count, rest_.size());
    bytes.append(rest_.substr(0, given));
    rest_.remove_prefix(given);
    return std::nullopt;
  }

 private:
  std::string_view rest_;
};

}  // namespace espalier::core
