#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/turtle/environment_process.h"

namespace espalier::environment {

/// A built-in process or what is wrong with the request.
using ProcessOrErrors = std::variant<std::unique_ptr<turtle::EnvironmentProcess>, std::vector<core::Diagnostic>>;

/// Names of all built-in processes, sorted, aliases left out.
[[nodiscard]] std::vector<std::string> processNames();

/// The name of a process by its name or an alias; the given name when it is unknown.
[[nodiscard]] std::string canonicalName(std::string_view name);

/// The other names of a process, which the field's programs have; empty for an unknown name.
[[nodiscard]] std::vector<std::string> aliasesOf(std::string_view name);

/// Where the model of a process was published; empty for an unknown name.
[[nodiscard]] std::string sourceOf(std::string_view name);

/// JSON Schema (as text) of a process's configuration; empty for an unknown name.
[[nodiscard]] std::string configurationSchema(std::string_view name);

/// Makes a process from its JSON configuration (text of an object; empty: all defaults). Unknown name: "environment
/// process 'chibba' is unknown. Did you mean 'chiba'? Available: ...". Unknown keys and wrong types are errors with the
/// key's path and the nearest key. Several environments: environment_entries.h reads a list of them, environment_set.h
/// makes them one.
[[nodiscard]] ProcessOrErrors makeProcess(std::string_view name, std::string_view configurationJson);

/// Makes an environment from the field's `.e` file: its program's name, its specification file (looked for beside it)
/// and its turtle formats. In the compatible modes numbers are rounded through the text forms of the field's
/// coupling; otherwise exchanged exactly. Warnings about ignored keywords go to `warnings`.
[[nodiscard]] ProcessOrErrors makeFromFieldFile(const std::string& file, core::FileProvider& files,
                                                core::Compatibility compatibility,
                                                std::vector<core::Diagnostic>& warnings);

}  // namespace espalier::environment
