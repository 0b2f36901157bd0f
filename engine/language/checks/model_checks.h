#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/language/message_list.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Where the text of a model comes from.
enum class ModelOrigin : std::uint8_t {
  Cpfg,         // a person wrote it
  Translation,  // of a foreign file; the homomorphism is the translation's drawing of the symbols
};

/// What the checks know of a model beside its text.
struct CheckedModel {
  core::Compatibility compatibility = core::Compatibility::Espalier;
  ModelOrigin origin = ModelOrigin::Cpfg;
  bool beginsElsewhere = false;  // a string takes the axiom's place, so any module may occur
};

/// Warns about legal but probably wrong parts of an analysed model without errors: words that are read as several
/// modules, productions that are never applied, brackets without partners, parameters that no production reads, weights
/// that are all zero, calls of L-systems that do not exist, queries that nobody answers (module_checks.h). Changes
/// nothing. The rules are in engine/language/DESIGN.md, "Warnings". Returns the symbols behind a `@` about which it has
/// warned.
[[nodiscard]] std::vector<std::string> checkModel(std::string_view text, const CheckedModel& checked,
                                                  const ModelSyntax& model, MessageList& messages);

}  // namespace espalier::language
