#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/diagnostic.h"

namespace espalier::server {

/// How often a run of a model has applied its productions: what code lenses say.
struct RunCounts {
  struct Production {
    std::string text;            // with its macros replaced, each run of blanks as one
    core::SourceLocation place;  // in the text that the run was made from
    std::uint64_t last = 0;      // in the last step
    std::uint64_t total = 0;
  };

  std::uint64_t since = 0;  // the steps behind this one were counted
  std::uint64_t step = 0;   // up to this one
  std::vector<Production> productions;
};

/// Asks for the counts of the open run. Nothing, or an empty function: there is no run, or it does not count.
using OpenRun = std::function<std::optional<RunCounts>()>;

}  // namespace espalier::server
