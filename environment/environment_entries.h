#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::environment {

/// One environment of a simulation as a configuration names it.
struct EnvironmentEntry {
  std::string type;  // a built-in process, or what the server and the command line resolve: offered, tcp, stdio
  std::string name;  // what `?Name(...)` in a model refers to; the type when none is given
  std::string configuration;  // the object's other keys as JSON text
};

/// Reads `{"type":"honda","radius":0.5}` or a list of such objects. Each may have a `name`. An empty list is no
/// environment. Types are not looked up here. Errors name the entry: "environment[1]: 'type' must be a text, found the
/// number 3"; two environments of one name (letter case aside) are an error. O(text).
[[nodiscard]] std::variant<std::vector<EnvironmentEntry>, std::vector<core::Diagnostic>> parseEnvironmentEntries(
    std::string_view json);

}  // namespace espalier::environment
