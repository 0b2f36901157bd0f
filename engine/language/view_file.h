#pragma once

#include <string>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/identifiers.h"
#include "engine/core/limits.h"
#include "engine/core/streams.h"
#include "engine/language/source_map.h"
#include "engine/language/view_settings.h"

namespace espalier::language {

struct ViewFileResult {
  ViewSettings settings;
  core::DiagnosticList diagnostics;      // a view file never causes an error: warnings only
  std::vector<SourceMap::File> sources;  // the view file, its includes and every file it names that could be read
};

/// Reads a view file and the functions, curves, surfaces and contours that it names (beside it). FILES §4 to §9.
[[nodiscard]] ViewFileResult readViewFile(const std::string& file, core::FileProvider& files,
                                          core::Compatibility compatibility, const core::Limits& limits);

}  // namespace espalier::language
