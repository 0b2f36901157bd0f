#pragma once

#include <string_view>

#include "engine/core/identifiers.h"
#include "engine/language/message_list.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Warns about what is legal but probably not meant, in an analysed model without errors: words that are read as
/// several modules, productions that can never be applied, brackets without partners, parameters that nothing reads,
/// weights that are all zero, calls of L-systems that do not exist. Changes nothing. The rules are in README.md,
/// "Warnings".
void checkModel(std::string_view text, core::Compatibility compatibility, const ModelSyntax& model,
                MessageList& messages);

}  // namespace espalier::language
