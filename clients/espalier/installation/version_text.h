#pragma once

#include <string>

namespace espalier::command {

/// The line of --version.
[[nodiscard]] std::string versionLine();

/// The text that --version --verbose prints, without the last line end, for reports: the version, compiler and C
/// library, system and processor, and where the program finds what came with it.
[[nodiscard]] std::string verboseVersionText();

}  // namespace espalier::command
