#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/language/program.h"

namespace espalier::derivation {

/// A file that a plant has open.
struct OpenFile {
  std::uint32_t file = 0;      // index into Program::files
  language::FileMode mode;     // how it was opened
  std::uint64_t position = 0;  // where the next byte is read or written
  bool isOpen = false;         // the next fopen takes the place of a closed file
};

/// The present content of a file that a model both writes and reads.
struct KeptFile {
  std::uint32_t file = 0;  // index into Program::files
  std::string text;
};

/// Bytes on their way to a file.
struct FileOutput {
  std::uint32_t file = 0;  // index into Program::files
  bool replaces = false;   // the bytes become the whole content, otherwise they go to its end
  std::string bytes;       // empty for a kept file: its KeptFile is the whole content
};

/// The files of one plant. They are part of its state, so a step that fails takes its writing back. Nothing here
/// reaches a disk: the simulation takes `output` when it completes a step, and passes it on.
struct FileState {
  std::vector<OpenFile> open;      // by handle - 1
  std::vector<KeptFile> kept;      // files written by this plant that the model reads somewhere
  std::vector<FileOutput> output;  // since the last completed step; at most one for each file
};

}  // namespace espalier::derivation
