#pragma once

#include <string>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "environment/base/process_entry.h"

namespace espalier::environment {

/// Makes a process from a published `.e` file: the name of its program, its specification file (beside it) and its
/// turtle formats. In the compatible modes numbers are rounded through the text forms of cpfg's coupling; otherwise
/// they are exchanged exactly. Warnings about ignored keywords go to `warnings`, at
/// most core::DiagnosticList::kLimit of them. There are no more errors than that either.
[[nodiscard]] ProcessOrErrors makeFromEnvironmentFile(const std::string& file, core::FileProvider& files,
                                                      core::Compatibility compatibility,
                                                      std::vector<core::Diagnostic>& warnings);

}  // namespace espalier::environment
