#pragma once

#include "engine/derivation/parallel/text_writer.h"
#include "engine/derivation/state/module_string.h"
#include "engine/language/program.h"

namespace espalier::command {

/// Writes the text form of a string of modules and a newline on standard output, in pieces: a string of a hundred
/// million modules needs no copy of its text in memory.
void printString(derivation::TextWriter& writer, const language::Program& program,
                 const derivation::ModuleString& string);

}  // namespace espalier::command
