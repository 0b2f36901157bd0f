#pragma once

#include <string_view>

namespace espalier::web {

/// The page of a server (HTML). It loads /espalier.js and nothing else.
[[nodiscard]] std::string_view serverPage();
/// The script of all pages, bundled with three.js. In a program that was built without Node.js the script writes into
/// the page what is missing.
[[nodiscard]] std::string_view script();

}  // namespace espalier::web
