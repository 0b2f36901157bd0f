#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/language/message_list.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Warns about modules that have no effect: `?e(0)`, which nobody answers; a declared query that no axiom or successor
/// makes; `A(x,2)` where productions rewrite only `A(x)`. Returns the symbols behind a `@` about which it has warned.
[[nodiscard]] std::vector<std::string> checkModules(std::string_view text, const ModelSyntax& model,
                                                    MessageList& messages);

}  // namespace espalier::language
