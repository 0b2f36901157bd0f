#pragma once

#include <map>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/files/model_folder.h"

namespace espalier::server {

/// The files of one model, as names that its FileProvider reads.
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

/// The files of a model, or a sentence that says what is wrong and what to do.
using FoundModel = tl::expected<ModelFiles, std::string>;

/// The files of a model on the disk, given as `MODEL.l` or as a folder:
/// - beside `MODEL.l`, the `.v`, `.e` (or `.json`, a configuration), `.a`, `.map` and `.mat` files of the same stem;
/// - in a folder with a file `specifications`, the files of its first cpfg command, or of the command that `object`
///   chooses: by its title in the menu, the end of the title, the name of its model, or its number from 1;
/// - in any other folder, its only `.l` or the one with the folder's name, with its only `.v`, `.e` and colour file
/// when
///   none has the stem of the model.
[[nodiscard]] FoundModel findModelFiles(const std::string& path, const std::string& object = {});

/// The same for files that came in a message, by name. `main` names the model; empty: the files are a folder.
[[nodiscard]] FoundModel findModelFiles(const std::map<std::string, std::string>& files, const std::string& main);

}  // namespace espalier::server
