#pragma once

#include <string>
#include <vector>

#include "clients/espalier/validation/validation.h"

namespace espalier::validation {

/// An SVG of the curves of a case: results as lines, references dashed, each pair in one colour. Without curves an
/// empty text.
[[nodiscard]] std::string resultPlot(const std::string& title, const CaseResult& result);

}  // namespace espalier::validation
