#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::environment {

/// Warnings about given keys of a built-in process that another key switches off: "environment process 'xylem':
/// 'collarHead' has no effect, because 'collar' is not \"head\"." Also about `bands` that make light. None for a
/// configuration that makeProcess refuses.
[[nodiscard]] std::vector<core::Diagnostic> idleKeys(std::string_view process, std::string_view configurationJson);

/// The mistakes in the rules themselves, for tests: a process or a key that is not there, a value that no key has.
[[nodiscard]] std::vector<std::string> problemsOfIdleKeys();

}  // namespace espalier::environment
