#pragma once

#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/language/program.h"
#include "engine/language/view/view_file.h"

namespace espalier::language {

/// An error for every surface, contour or texture file that cannot be used although the model draws with it: `~x`,
/// `@#(id)` or `@Tx(id)` stands in an axiom or successor, or a surface in use has the texture. A number that is
/// computed while the model runs counts as every number. A texture gives only a warning: no string needs it. Each error
/// is at the view file's line and names the first line of the model that needs it.
[[nodiscard]] std::vector<core::Diagnostic> neededFiles(const Program& program,
                                                        const std::vector<UnusableFile>& unusable);

/// A warning for each surface `~x` of an axiom or successor that the view file does not name, at its first place.
[[nodiscard]] std::vector<core::Diagnostic> undefinedSurfaces(const Program& program,
                                                              const std::vector<UnusableFile>& unusable);

}  // namespace espalier::language
