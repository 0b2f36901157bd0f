#pragma once

#include <span>

namespace espalier::turtle {

/// A row of turtle_symbols.def, for people.
struct SymbolInfo {
  const char* text = "";  // the symbol; with `@` in front where that is needed
  const char* usage = "";
  const char* meaning = "";
};

/// All rows, in the order of turtle_symbols.def.
[[nodiscard]] std::span<const SymbolInfo> allSymbols();

}  // namespace espalier::turtle
