#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "engine/files/images/image_file.h"
#include "environment/base/published_keyword.h"

namespace espalier::environment {

/// The picture that a line of a specification names, opaque; the file is looked for beside the specification. The error
/// is the end of a sentence whose subject is the line's keyword.
[[nodiscard]] tl::expected<files::Image, std::string> readImageBeside(const PublishedLineInput& input,
                                                                      std::string_view name);

}  // namespace espalier::environment
