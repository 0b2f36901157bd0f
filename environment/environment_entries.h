#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::environment {

/// One environment of a simulation as a configuration names it.
struct EnvironmentEntry {
  std::string type;  // a built-in process, or a type that the server and the command line resolve: offered, tcp, stdio
  std::string name;  // the Name of `?Name(...)` in a model; the type when no name is given
  std::string configuration;  // the object's other keys as JSON text
};

/// Reads `{"type":"honda","radius":0.5}` or a list of such objects, each with an optional `name`. An empty list gives
/// no entries. Types are not looked up here. Errors name the entry: "environment[1]: 'type' must be a text, found the
/// number 3". Two environments with the same name (letter case aside) are an error. O(text).
[[nodiscard]] tl::expected<std::vector<EnvironmentEntry>, std::vector<core::Diagnostic>> parseEnvironmentEntries(
    std::string_view json);

}  // namespace espalier::environment
