#pragma once

#include <string>
#include <vector>

namespace espalier::test {

/// A file of the repository: its name from the root with forward slashes, and its text.
struct SourceFile {
  std::string name;
  std::string text;
};

/// All files of the repository that people write: build results, version control, and the conformance cases are left
/// out.
[[nodiscard]] std::vector<SourceFile> readSourceTree(const std::string& root);

/// C++ text without its comments and with the contents of its literals removed; include lines keep their names.
[[nodiscard]] std::string withoutCommentsAndLiterals(const std::string& text);

/// Names of `#include "..."` lines.
[[nodiscard]] std::vector<std::string> quotedIncludes(const std::string& text);

}  // namespace espalier::test
