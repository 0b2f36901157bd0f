#pragma once

#include <cstdint>
#include <string>

#include "engine/language/program.h"

namespace espalier::language {

/// Whether the text has the places of the productions.
enum class DisassemblyPlaces : std::uint8_t { Hidden, Shown };

/// The code of a Program as text, one instruction a line, for tests and for readers. The same Program always gives the
/// same text. L-systems in order, each with its blocks, axiom and productions; numbers in their shortest form.
///
///     L-system 1
///     axiom
///       module A
///         parameter 0 = 1
///     production 0: A(l) --> F(l)A(l * 2)
///       module F
///         parameter 0 = slot 0
///       module A
///         parameter 0
///          0  LoadSlot 0
///          1  Constant 2
///          2  Multiply
///
/// With places, a line `  # tree.l:7:1: A(l) --> F(l)A(l*R)` follows each production's heading: its place and its line
/// as written, before macros were expanded.
[[nodiscard]] std::string disassemble(const Program& program, DisassemblyPlaces places = DisassemblyPlaces::Hidden);

}  // namespace espalier::language
