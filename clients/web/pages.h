#pragma once

#include <string_view>

namespace espalier::web {

/// The page of a server (HTML). It loads /studio.js and /studio.css and nothing else.
[[nodiscard]] std::string_view serverPage();
/// The studio, bundled with its packages. In a program that was built without Node.js the script writes into the page
/// what is missing.
[[nodiscard]] std::string_view script();
/// The same compressed by gzip; empty in a program that was built without Node.js.
[[nodiscard]] std::string_view packedScript();
[[nodiscard]] std::string_view style();

}  // namespace espalier::web
