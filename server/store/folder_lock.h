#pragma once

#include <memory>
#include <string>
#include <tl/expected.hpp>

namespace espalier::server {

/// The database of a data folder.
inline constexpr const char* kStoreFile = "espalier.sqlite";

/// The right to use a data folder alone, held as long as it lives.
using FolderLock = std::shared_ptr<const int>;

/// Makes a data folder for this user alone, when it is missing, and locks it. Or an error sentence.
[[nodiscard]] tl::expected<FolderLock, std::string> lockFolder(const std::string& folder);

/// Makes a file that only this user can read, or takes the rights of others to it. A file that is not there and is not
/// to be made (`isMade`) is no error. Returns 0 or an errno.
[[nodiscard]] int makePrivate(const std::string& file, bool isMade);

}  // namespace espalier::server
