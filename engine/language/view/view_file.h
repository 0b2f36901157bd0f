#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/identifiers.h"
#include "engine/core/limits.h"
#include "engine/core/streams.h"
#include "engine/files/source_map.h"
#include "engine/files/view_settings.h"

namespace espalier::language {

/// A file of a surface, contour or texture that is missing or broken. The view file has a warning about it; the model
/// gets an error when it draws with the file (neededFiles).
struct UnusableFile {
  enum class Kind : std::uint8_t { Surface, Contour, Texture };
  Kind kind = Kind::Surface;
  int id = 0;                     // the character of a surface, the number of a contour or texture
  core::SourceLocation location;  // of the command that names it
  std::string file;               // as the view file names it
};

struct ViewFileResult {
  files::ViewSettings settings;
  core::DiagnosticList diagnostics;    // only warnings: a view file alone never causes an error
  std::vector<UnusableFile> unusable;  // in the order of the commands
  std::vector<files::SourceMap::File>
      sources;  // the view file, its includes and every file it names that could be read
};

/// Reads a view file and the functions, curves, surfaces and contours that it names (beside it). The formats are in
/// docs/model-files.md.
[[nodiscard]] ViewFileResult readViewFile(const std::string& file, core::FileProvider& files,
                                          core::Compatibility compatibility, const core::Limits& limits);

}  // namespace espalier::language
