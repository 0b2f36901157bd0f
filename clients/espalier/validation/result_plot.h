#pragma once

#include <string>
#include <vector>

#include "clients/espalier/validation/validation.h"

namespace espalier::validation {

/// An SVG of the curves of a picture: results as lines or dots, references dashed or pale, each pair in one colour.
/// Without curves an empty text.
[[nodiscard]] std::string resultPlot(const std::string& title, const Picture& picture);

}  // namespace espalier::validation
