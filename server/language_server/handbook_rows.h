#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace espalier::server {

/// What the handbook's page of the language says about a function: the row of its table, as Markdown. Nothing when it
/// says nothing.
[[nodiscard]] std::optional<std::string> handbookFunction(std::string_view name);

/// The same for a turtle symbol: `F`, `[`, `@M`, `~`. `symbol` has one character, or begins with `@`.
[[nodiscard]] std::optional<std::string> handbookSymbol(std::string_view symbol);

}  // namespace espalier::server
