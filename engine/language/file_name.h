#pragma once

#include <string>
#include <string_view>

namespace espalier::language {

/// The name by which a file named inside another one is asked of the FileProvider: `name` itself when it is absolute,
/// otherwise joined to the folder of `file`.
[[nodiscard]] inline std::string nameBeside(std::string_view file, std::string_view name) {
  const std::size_t slash = file.rfind('/');
  if (slash == std::string_view::npos || (!name.empty() && name.front() == '/')) {
    return std::string(name);
  }
  return std::string(file.substr(0, slash + 1)) + std::string(name);
}

}  // namespace espalier::language
