#pragma once

#include <optional>
#include <string>

namespace espalier::server {

/// Writes a copy of the database of a data folder into a new file, as it is at one moment. A server may use the folder
/// meanwhile, and goes on saving. The copy has mode 0600. An error sentence, or nothing.
[[nodiscard]] std::optional<std::string> backUpStore(const std::string& folder, const std::string& file);

/// Puts a copy into a data folder, which is made when it is missing. The folder must hold no database, and no server
/// may use it. The copy is checked first. An error sentence, or nothing.
[[nodiscard]] std::optional<std::string> restoreStore(const std::string& file, const std::string& folder);

}  // namespace espalier::server
