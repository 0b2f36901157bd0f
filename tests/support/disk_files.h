#pragma once

#include <fstream>
#include <iterator>
#include <optional>
#include <string>

#include "engine/core/streams.h"

namespace espalier::test {

/// The whole content of a file, or nothing when it cannot be opened.
inline std::optional<std::string> readFile(const std::string& name) {
  std::ifstream stream(name, std::ios::binary);
  if (!stream) {
    return std::nullopt;
  }
  return std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
}

/// Files of the local disk for tests of libraries that do no input of their own.
class DiskFiles final : public core::FileProvider {
 public:
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override { return readFile(name); }
};

}  // namespace espalier::test
