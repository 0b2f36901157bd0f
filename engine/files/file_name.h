#pragma once

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace espalier::files {

/// The name under which the FileProvider finds a file that `file` names: `name` itself when it is absolute, otherwise
/// joined to the folder of `file`.
[[nodiscard]] inline std::string nameBeside(std::string_view file, std::string_view name) {
  const std::size_t slash = file.rfind('/');
  if (slash == std::string_view::npos || (!name.empty() && name.front() == '/')) {
    return std::string(name);
  }
  return std::string(file.substr(0, slash + 1)) + std::string(name);
}

/// The folder of a file with its final slash; empty for a file without one.
[[nodiscard]] inline std::string folderOf(std::string_view file) {
  const std::size_t slash = file.rfind('/');
  return slash == std::string_view::npos ? std::string{} : std::string(file.substr(0, slash + 1));
}

/// Whether a name has more than the suffix, and ends in it; the suffix is in small letters, the name in any.
[[nodiscard]] inline bool endsIn(std::string_view name, std::string_view suffix) {
  return name.size() > suffix.size() &&
         std::ranges::equal(name.substr(name.size() - suffix.size()), suffix, {},
                            [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
}

/// Whether a relative name cannot leave the folder it is joined to: not absolute, no `..`, none of the characters
/// that have a special meaning on some system. The caller that opens the file must check symbolic links.
[[nodiscard]] inline bool isNameInside(std::string_view name) {
  if (name.empty() || name.front() == '/' || name.back() == '/' || name == "." || name.ends_with("/.")) {
    return false;
  }
  for (const char c : name) {
    if (static_cast<unsigned char>(c) < 0x20 || c == '\\' || c == ':') {
      return false;
    }
  }
  for (std::size_t begin = 0; begin <= name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    if (name.substr(begin, end - begin) == "..") {
      return false;
    }
    begin = end + 1;
  }
  return true;
}

/// A relative name without the parts `.` and without empty parts, so that a file has only one name.
[[nodiscard]] inline std::string withoutDots(std::string_view name) {
  std::string plain;
  for (std::size_t begin = 0; begin < name.size();) {
    const std::size_t end = std::min(name.find('/', begin), name.size());
    const std::string_view part = name.substr(begin, end - begin);
    if (!part.empty() && part != ".") {
      plain += plain.empty() ? "" : "/";
      plain += part;
    }
    begin = end + 1;
  }
  return plain;
}

}  // namespace espalier::files
