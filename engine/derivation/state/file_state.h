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
  bool isOpen = false;         // a closed place is given to the next fopen
};

/// The present content of a file that a model both writes and reads.
struct KeptFile {
  std::uint32_t file = 0;  // index into Program::files
  std::string text;
};

/// Bytes on their way to a file.
struct FileOutput {
  std::uint32_t file = 0;  // index into Program::files
  bool replaces = false;   // they become the whole content, otherwise they are added to its end
  std::string bytes;       // of a kept file empty: its KeptFile is the whole content
};

/// The files of one plant: a part of its state like every other, so that a step that fails takes back what it wrote.
/// Nothing reaches a disk from here; whoever completes a step takes `output` and passes it on.
struct FileState {
  std::vector<OpenFile> open;      // by handle - 1
  std::vector<KeptFile> kept;      // files written by this plant that the model reads somewhere
  std::vector<FileOutput> output;  // since the last completed step; at most one for each file
};

}  // namespace espalier::derivation
