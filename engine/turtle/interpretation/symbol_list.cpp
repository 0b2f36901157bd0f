#include "engine/turtle/interpretation/symbol_list.h"

#include <array>

namespace espalier::turtle {
namespace {

constexpr std::array kSymbols{
#define ESPALIER_TURTLE_SYMBOL(command, text, least, most, usage, meaning) SymbolInfo{text, usage, meaning},
#define ESPALIER_TURTLE_AFTER_AT(command, text, usage, meaning) SymbolInfo{"@" text, usage, meaning},
#include "engine/language/turtle_symbols.def"
};

}  // namespace

std::span<const SymbolInfo> allSymbols() {
  return kSymbols;
}

}  // namespace espalier::turtle
