#pragma once

#include <string_view>

#include "engine/language/message_list.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Warns about formal modules of predecessors and contexts that no string can contain: neither an axiom nor a
/// production that can apply makes them. One message for modules that only make each other. `isTranslation`: a program
/// made the model, and its homomorphism draws symbols that may not occur.
void checkReach(std::string_view text, bool isTranslation, const ModelSyntax& model, MessageList& messages);

}  // namespace espalier::language
