#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/core/streams.h"

namespace espalier::command {

/// Writes the files of a model into the folder of the model and nowhere else. It does not follow symbolic links, writes
/// only ordinary files and makes no folders.
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
