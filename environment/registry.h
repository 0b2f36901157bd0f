#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/core/diagnostic.h"
#include "environment/base/process_entry.h"

namespace espalier::environment {

/// Names of all built-in processes, sorted, without aliases.
[[nodiscard]] std::vector<std::string> processNames();

/// The entry of a name or an alias; null when the name is unknown.
[[nodiscard]] const ProcessEntry* findProcess(std::string_view name);

/// The name of a process by its name or an alias; the given name when it is unknown.
[[nodiscard]] std::string canonicalName(std::string_view name);

/// The other names of a process: those of the published programs. Empty for an unknown name.
[[nodiscard]] std::vector<std::string> aliasesOf(std::string_view name);

/// Where the model of a process was published; empty for an unknown name.
[[nodiscard]] std::string sourceOf(std::string_view name);

/// JSON Schema (as text) of a process's configuration; empty for an unknown name.
[[nodiscard]] std::string configurationSchema(std::string_view name);

/// Makes a process from its JSON configuration (text of an object; empty: all defaults). Unknown keys and wrong types
/// are errors with the key's path and the nearest key; an unknown name is unknownProcess(). For several environments,
/// environment_entries.h reads a list of them and environment_set.h makes them one process.
[[nodiscard]] ProcessOrErrors makeProcess(std::string_view name, std::string_view configurationJson);

/// The error "environment process 'chibba' is unknown. Did you mean 'chiba'? Available: chiba, clover."
[[nodiscard]] core::Diagnostic unknownProcess(std::string_view name);

}  // namespace espalier::environment
