#pragma once

#include <string_view>

#include "engine/language/message_list.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Warns about words that look like the name of one module but are read letter by letter, such as `Apex(1)` without
/// `Module: Apex(age)`. True: there are such words.
bool checkWords(std::string_view text, const ModelSyntax& model, MessageList& messages);

}  // namespace espalier::language
