#include "server/language_server/handbook_rows.h"

#include <algorithm>
#include <array>

namespace espalier::server {
namespace {

struct Row {
  std::string_view name, usage, meaning;
};

constexpr std::array kFunctions{
#define ESPALIER_FUNCTION(name, text, least, most, isPure, usage, meaning) Row{text, usage, meaning},
#define ESPALIER_SPECIAL_FUNCTION(callee, text, usage, meaning) Row{text, usage, meaning},
#include "engine/language/function.def"
};

constexpr std::array kSymbols{
#define ESPALIER_TURTLE_SYMBOL(command, text, least, most, usage, meaning) Row{text, usage, meaning},
#define ESPALIER_TURTLE_AFTER_AT(command, text, usage, meaning) Row{"@" text, usage, meaning},
#include "engine/language/turtle_symbols.def"
};

std::optional<std::string> findIn(const auto& rows, std::string_view name) {
  const auto found = std::ranges::find(rows, name, &Row::name);
  if (found == rows.end()) {
    return std::nullopt;
  }
  return "`" + std::string(found->usage) + "`\n\n" + std::string(found->meaning);
}

}  // namespace

std::optional<std::string> handbookFunction(std::string_view name) {
  return findIn(kFunctions, name);
}

std::optional<std::string> handbookSymbol(std::string_view symbol) {
  return findIn(kSymbols, symbol);
}

}  // namespace espalier::server
