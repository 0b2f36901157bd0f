#pragma once

#include <optional>
#include <string>

#include "engine/core/streams.h"

namespace espalier::server {

/// Files of the local disk, names relative to the working directory. A file above `maximumBytes` is not read.
class DiskFileProvider final : public core::FileProvider {
 public:
  explicit DiskFileProvider(std::size_t maximumBytes = 256'000'000) : maximumBytes_(maximumBytes) {}
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override;
  [[nodiscard]] std::optional<std::string> readInside(const std::string& folder, const std::string& name) override;

 private:
  std::size_t maximumBytes_;
};

/// Writes a file so that a reader sees the old content or the new, never a part: temporary file beside it, then rename.
/// Returns an error sentence, or nothing on success.
[[nodiscard]] std::optional<std::string> writeFileAtomically(const std::string& name, std::string_view content);

}  // namespace espalier::server
