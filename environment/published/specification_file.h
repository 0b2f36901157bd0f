#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "environment/base/process_entry.h"

namespace espalier::environment {

/// A published specification file as a configuration, and where each key was written.
struct Specification {
  ConfigurationValues values;
  std::map<std::string, core::SourceLocation> locations;  // by key
};

/// Reads the specification file of a process by its published keywords. `file` is the name for messages; `files` reads
/// the files that the specification names. Errors and warnings, each with its line, are appended. O(text).
[[nodiscard]] Specification readSpecification(const ProcessEntry& process, const std::string& file,
                                              std::string_view text, core::FileProvider& files,
                                              std::vector<core::Diagnostic>& warnings,
                                              std::vector<core::Diagnostic>& errors);

}  // namespace espalier::environment
