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

/// A file of a surface, contour or texture that is missing or broken. What is wrong with it is a warning of the view
/// file; it becomes an error when the model draws with it (unusableFilesInUse).
struct UnusableFile {
  enum class Kind : std::uint8_t { Surface, Contour, Texture };
  Kind kind = Kind::Surface;
  int id = 0;                     // the character of a surface, the number of a contour or texture
  core::SourceLocation location;  // of the command that names it
  std::string file;               // as the view file names it
};

struct ViewFileResult {
  ViewSettings settings;
  core::DiagnosticList diagnostics;      // a view file alone never causes an error: warnings only
  std::vector<UnusableFile> unusable;    // in the order of the commands
  std::vector<SourceMap::File> sources;  // the view file, its includes and every file it names that could be read
};

/// Reads a view file and the functions, curves, surfaces and contours that it names (beside it). FILES §4 to §9.
[[nodiscard]] ViewFileResult readViewFile(const std::string& file, core::FileProvider& files,
                                          core::Compatibility compatibility, const core::Limits& limits);

}  // namespace espalier::language
