#pragma once

#include <cstdint>

namespace espalier::core {

/// Bounds of one simulation. Each is configuration, never a fixed buffer, and is named in the error it causes.
struct Limits {
  std::uint64_t maximumModules = 1'000'000'000;       // modules in one string
  std::uint64_t maximumStringBytes = 16'000'000'000;  // one string's types and parameters
  std::uint32_t maximumArity = 1000;                  // parameters of one module
  std::uint64_t maximumLoopIterations = 100'000'000;  // loop turns in one execution of a block
  std::uint32_t maximumRecursion = 10'000;            // depth of decomposition or homomorphism; holds for every model
  std::uint64_t maximumHomomorphismModules = 50'000'000;  // that the homomorphism makes of one module of the string
  std::uint64_t maximumQueries = 100'000'000;             // communication modules in one step
  std::uint32_t maximumTurtleStack = 1'000'000;           // open brackets while interpreting
  std::uint32_t maximumOpenFiles = 256;                   // files that one plant has open at once (fopen)
  std::uint64_t maximumFileBytes = 1'000'000'000;         // written to files in one step, and kept of one file

  // reading a model
  std::uint64_t maximumSourceBytes = 64'000'000;  // text after preprocessing
  std::uint32_t maximumIncludeDepth = 64;
  std::uint32_t maximumMacroDepth = 256;
  std::uint64_t maximumArrayElements = 16'000'000;  // elements of all arrays of one L-system
  std::uint32_t maximumExpressionDepth = 1000;      // nesting in one expression or block
};

}  // namespace espalier::core
