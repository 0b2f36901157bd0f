#pragma once

#include <string_view>

#include "engine/language/message_list.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Warns about words that a person means as the name of one module but that are read letter by letter, as `Apex(1)` is
/// without `Module: Apex(age)`. True: there are such words.
bool checkWords(std::string_view text, const ModelSyntax& model, MessageList& messages);

}  // namespace espalier::language
