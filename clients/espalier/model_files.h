#pragma once

#include <string>
#include <vector>

#include "clients/espalier/result.h"
#include "engine/core/diagnostic.h"
#include "engine/files/model_folder.h"

namespace espalier::command {

/// The files of one model, as names that can be opened from the working directory.
struct ModelFiles {
  std::string model;
  std::string view;         // empty: none
  std::string environment;  // a published environment file (.e) or a configuration (.json); empty: none
  std::string animation;    // empty: none
  std::vector<files::ColourFile> colours;
  int colourBase = 1;
  bool isFolder = false;                  // found in a folder, not beside a given file
  bool startsInAnimation = false;         // the animation file decides which step is the last
  std::vector<core::Diagnostic> remarks;  // warnings and notes about the folder
};

/// The files of a model given as `MODEL.l` or as a folder:
/// - beside `MODEL.l`, the `.v`, `.e` (or `.json`, a configuration) and `.a` files of the same stem;
/// - in a folder with a file `specifications`, the files of its first cpfg command, or of the command that `object`
///   chooses: by its title in the menu, the end of the title, the name of its model, or its number from 1;
/// - in any other folder, its only `.l`, with its only `.v`, `.e` and colour file when none has the stem of the model.
[[nodiscard]] Result<ModelFiles> findModelFiles(const std::string& path, const std::string& object = {});

}  // namespace espalier::command
