#pragma once

#include <string>

#include "engine/core/number_text.h"

namespace espalier::environment {

/// A number in messages and files: the shortest text that reads back exactly.
[[nodiscard]] inline std::string numberText(double value) {
  std::string text;
  core::appendNumber(text, value, core::NumberStyle::Shortest);
  return text;
}

}  // namespace espalier::environment
