#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "engine/core/diagnostic.h"
#include "engine/core/number_text.h"
#include "engine/derivation/state/module_string.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Appends the text form of a string: each symbol, then its parameters in parentheses separated by commas; no blanks.
void appendText(std::string& text, const language::Program& program, const ModuleString& string,
                core::NumberStyle style);
[[nodiscard]] std::string toText(const language::Program& program, const ModuleString& string, core::NumberStyle style);

/// Reads the text form of a string as modules of the Program. Blanks and newlines may stand between modules. Declared
/// names count before single symbols, the longest first. Otherwise returns a sentence with the place (line:column) and
/// the mistake: a module that the model does not have, or a parameter that is not a number.
[[nodiscard]] tl::expected<ModuleString, std::string> parseText(const language::Program& program,
                                                                std::string_view text);

/// The style of the Program's mode: shortest, or %g in the compatible modes.
[[nodiscard]] core::NumberStyle numberStyle(core::Compatibility compatibility);

/// FNV-1a over the symbols' names, arities and the parameters' bits: equal strings of one model have equal hashes.
[[nodiscard]] std::uint64_t hashOf(const language::Program& program, const ModuleString& string);

}  // namespace espalier::derivation
