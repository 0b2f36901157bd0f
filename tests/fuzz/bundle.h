#pragma once

#include <string>
#include <string_view>

#include "engine/core/streams.h"

namespace espalier::fuzz {

/// The names that the main file and its view file have in a bundle.
inline constexpr const char* kModel = "model.l";
inline constexpr const char* kView = "model.v";

/// Several files in one text, as a fuzzer changes it: the main file, then for each other file a line `==== name` and
/// its content. Names are one word; a later file of a name replaces the earlier one.
[[nodiscard]] core::MemoryFileProvider unbundle(std::string_view text, const std::string& mainFile);

/// The line that begins a file of a bundle.
[[nodiscard]] std::string bundleHead(std::string_view name);

}  // namespace espalier::fuzz
