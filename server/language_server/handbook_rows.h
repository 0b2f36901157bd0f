#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace espalier::server {

/// The text of the handbook about a function: its row of function.def, as Markdown. Nothing for other names.
[[nodiscard]] std::optional<std::string> handbookFunction(std::string_view name);

/// The same for a turtle symbol (turtle_symbols.def): `F`, `[`, `@M`, `~`. `symbol` has one character, or begins with
/// `@`.
[[nodiscard]] std::optional<std::string> handbookSymbol(std::string_view symbol);

}  // namespace espalier::server
