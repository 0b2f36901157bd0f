#pragma once

#include <string>
#include <variant>

namespace espalier::command {

/// The files of one model, as names that can be opened from the working directory.
struct ModelFiles {
  std::string model;
  std::string view;         // empty: none
  std::string environment;  // a `.e` file; empty: none
};

/// The files of a model given as `MODEL.l` or as the folder that holds exactly one model: beside `MODEL.l`, the `.v` and `.e`
/// files of the same stem; in a folder, its only `.v` and `.e` when none has the model's stem. Returns the files or one
/// sentence that says what to do.
[[nodiscard]] std::variant<ModelFiles, std::string> findModelFiles(const std::string& path);

}  // namespace espalier::command
