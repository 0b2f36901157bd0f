#pragma once

#include <cstdint>
#include <string>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/language/program.h"

namespace espalier::language {

struct FormatResult {
  bool isCompiled = false;           // false: the model has errors, see `diagnostics`; `text` is the unchanged file
  std::string text;                  // the model file in the new layout
  std::uint32_t untouchedItems = 0;  // items that keep their layout because a new one could change their meaning
  core::DiagnosticList diagnostics;  // of the unchanged model
};

/// Lays out the model file `input.modelFile` (not what it includes): one blank around `:`, `-->`, `<` and `>`, around
/// operators outside parameter lists and around comparisons everywhere; no blank before a comma, and none behind it
/// inside parentheses; blocks indented by two blanks; one TAB before a continued line; no blanks at the ends of lines,
/// at most one empty line. Line breaks, comments, blanks between modules and the spelling of keywords and names stay.
///
/// The result compiles to the same Program. This is checked: an item keeps its layout when the new one would compile to
/// another Program. Items with line continuations (`\`) or directives inside, and lines that #if excludes, keep theirs,
/// too. Formatting a result again changes nothing.
[[nodiscard]] FormatResult format(const CompileInput& input, core::FileProvider& files);

}  // namespace espalier::language
