#pragma once

#include <string>

#include "engine/language/program.h"

namespace espalier::language {

/// The code of a Program as text, one instruction a line, for tests and for people: the same Program always gives the same
/// text. L-systems in order, each with its blocks, axiom and productions; numbers in their shortest form.
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
[[nodiscard]] std::string disassemble(const Program& program);

}  // namespace espalier::language
