#pragma once

#include "engine/language/program.h"

namespace espalier::language {

/// Whether two Programs mean the same: everything that a run reads is equal. The text, its places and the hash may
/// differ.
[[nodiscard]] bool isSameProgram(const Program& first, const Program& second);

}  // namespace espalier::language
