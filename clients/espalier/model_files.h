#pragma once

#include <string>
#include <variant>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/files/model_folder.h"

namespace espalier::command {

/// The files of one model, as names that can be opened from the working directory.
struct ModelFiles {
  std::string model;
  std::string view;         // empty: none
  std::string environment;  // a field file or a configuration; empty: none
  std::string animation;    // empty: none
  std::vector<files::ColourFile> colours;
  int colourBase = 1;
  bool isFolder = false;                  // found in a folder, not beside a file that was named
  bool startsInAnimation = false;         // the animation file decides which step is the last
  std::vector<core::Diagnostic> remarks;  // warnings and notes about the folder
};

/// The files of a model given as `MODEL.l` or as a folder:
/// - beside `MODEL.l`, the `.v`, `.e` (or `.json`, a configuration) and `.a` files of the same stem;
/// - in a folder with a file `specifications`, what its first cpfg command names, or the command that `object` chooses:
/// by
///   its place in the menu, the end of that, the name of its model, or its number from 1;
/// - in a folder without, its only `.l`, with its only `.v`, `.e` and colour file when none has the model's stem.
/// Returns the files or one sentence that says what to do.
[[nodiscard]] std::variant<ModelFiles, std::string> findModelFiles(const std::string& path,
                                                                   const std::string& object = {});

}  // namespace espalier::command
