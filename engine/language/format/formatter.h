#pragma once

#include <cstdint>
#include <string>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "engine/language/program.h"

namespace espalier::language {

struct FormatResult {
  bool isCompiled = false;           // false: the model has errors, see `diagnostics`; `text` is the file as it is
  std::string text;                  // the model file laid out anew
  std::uint32_t untouchedItems = 0;  // items left as they are because a new layout could change their meaning
  core::DiagnosticList diagnostics;  // of the model as it is
};

/// Lays out the model file `input.modelFile` (not what it includes): one blank around `:`, `-->`, `<` and `>`, around
/// operators outside parameter lists and around comparisons everywhere; no blank before a comma, and none behind it
/// inside parentheses; blocks indented by two blanks; one TAB before a continued line; no blanks at the ends of lines,
/// at most one empty line. Line breaks, comments, blanks between modules and the spelling of keywords and names stay.
///
/// The result compiles to the same Program, which is checked: an item whose new layout would not is left as it is. So
/// are items with line continuations (`\`) or directives inside, and lines that #if leaves out. Formatting a result
/// again changes nothing.
[[nodiscard]] FormatResult format(const CompileInput& input, core::FileProvider& files);

}  // namespace espalier::language
