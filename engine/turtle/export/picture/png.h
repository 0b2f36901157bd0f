#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "engine/core/streams.h"
#include "engine/turtle/export/picture/picture.h"

namespace espalier::turtle {

/// Writes a picture as a PNG of 8 bits a channel, without opacity when every point is opaque. The bytes depend on
/// nothing but the picture (and the version of the compression library).
/// With `maximumColours` (2 to 256) above 0 the picture is opaque and has a table of at most so many colours, for small
/// files. Returns an error sentence, or nothing.
[[nodiscard]] std::optional<std::string> writePng(const PictureImage& image, core::ByteSink& sink,
                                                  int maximumColours = 0);

}  // namespace espalier::turtle
