#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/files/colour_files.h"
#include "engine/files/source_map.h"

namespace espalier::files {

/// A colour map or material set of a command.
struct ColourFile {
  std::string file;
  int block = 1;
  bool isMaterial = false;
};

/// One cpfg command of a model folder. File names are joined to the folder; empty: not given.
struct FolderCommand {
  std::string title;  // its place in the menu, from the top: "plant / display"; empty without `specifications`
  std::string model;
  std::string view;
  std::string animation;
  std::string environment;
  std::vector<ColourFile> colours;  // in the order of the command; the kind of the last file counts (maps or materials)
  int colourBase = 1;
  bool startsInAnimation = false;  // the animation file decides which steps are shown
  bool writesAfterHomomorphism = false;
  bool isBatch = false;  // -g: other random numbers (core::Compatibility::CpfgBatch)
};

struct ModelFolder {
  std::vector<FolderCommand> commands;   // in the order of the menu; the first is the one to run
  std::vector<std::string> listedFiles;  // the file list of `specifications`, as written
  core::DiagnosticList diagnostics;      // an error when there is no command; a note for each unused part of the folder
};

/// Finds what to run in a published model folder: the cpfg commands of its `specifications`, or its only `.l` and `.v`.
/// `names` are the files in the folder, without the folder. `folder` is put before each name, with a slash; an empty
/// folder is not.
[[nodiscard]] ModelFolder readModelFolder(const std::string& folder, const std::vector<std::string>& names,
                                          core::FileProvider& files);

/// Reads the colour maps and material sets of a command. A file that cannot be read gives a warning.
[[nodiscard]] Palette readPalette(const FolderCommand& command, core::FileProvider& files,
                                  core::DiagnosticList& diagnostics);

}  // namespace espalier::files
