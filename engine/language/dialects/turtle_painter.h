#pragma once

#include <string>
#include <string_view>

#include "engine/language/dialects/dialect.h"

namespace espalier::language {

/// The systems of Turtle Painter: the textbook notation with turns by a random angle, +(x,y), `%` as a random whole
/// number from 0 to 99, `t` as the number of the step, objects p(x) and fruits o, stems F(d,s) and a constant vector.
/// One of these, or a first line that names the program, identifies a file.
[[nodiscard]] bool recognisesTurtlePainter(std::string_view text);
[[nodiscard]] CpfgModel translateTurtlePainter(std::string_view text, const std::string& entry, DialectReport& report);

}  // namespace espalier::language
