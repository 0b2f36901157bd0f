#pragma once

#include "engine/core/limits.h"

namespace espalier::fuzz {

/// Small enough that a text which stays within them takes well under a second.
inline core::Limits smallLimits() {
  core::Limits limits;
  limits.maximumModules = 5'000;
  limits.maximumStringBytes = 1'000'000;
  limits.maximumArity = 100;
  limits.maximumLoopIterations = 200;
  limits.maximumRecursion = 50;
  limits.maximumQueries = 5'000;
  limits.maximumTurtleStack = 1'000;
  limits.maximumFileBytes = 100'000;
  limits.maximumSourceBytes = 200'000;
  limits.maximumIncludeDepth = 8;
  limits.maximumMacroDepth = 32;
  limits.maximumArrayElements = 10'000;
  limits.maximumExpressionDepth = 200;
  return limits;
}

}  // namespace espalier::fuzz
