#pragma once

#include <string_view>

#include "engine/language/message_list.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Warns about habits of other languages that are legal here and mean something else: a comment behind '#', ';' or '%',
/// which becomes modules; a ';' at the end of every line; `if` and `else` in a successor; `0 < n < 2`; a decimal comma
/// in a command of the turtle; a surface with a long name.
void checkHabits(std::string_view text, const ModelSyntax& model, MessageList& messages);

}  // namespace espalier::language
