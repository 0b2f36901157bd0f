#pragma once

#include <cstdint>
#include <string_view>

#include "engine/core/identifiers.h"
#include "engine/language/message_list.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Where the text of a model comes from.
enum class ModelOrigin : std::uint8_t {
  Cpfg,         // a person wrote it
  Translation,  // of a foreign file; the homomorphism is the translation's drawing of the symbols
};

/// Warns about legal but probably wrong parts of an analysed model without errors: words that are read as several
/// modules, productions that are never applied, brackets without partners, parameters that no production reads, weights
/// that are all zero, calls of L-systems that do not exist, queries that nobody answers (module_checks.h). Changes
/// nothing. The rules are in engine/language/DESIGN.md, "Warnings".
void checkModel(std::string_view text, core::Compatibility compatibility, ModelOrigin origin, const ModelSyntax& model,
                MessageList& messages);

}  // namespace espalier::language
