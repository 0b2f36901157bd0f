#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/core/streams.h"

namespace espalier::command {

/// Writes what a model writes into the folder of the model and nowhere else: not through a symbolic link, not into
/// something that is no ordinary file. Folders are not made.
class FolderWriter final : public core::FileWriter {
 public:
  /// An empty folder is the working one.
  explicit FolderWriter(std::string folder);
  [[nodiscard]] std::optional<std::string> write(const std::string& name, bool replaces,
                                                 std::string_view bytes) override;

 private:
  std::string folder_;
};

}  // namespace espalier::command
