#pragma once

#include <functional>
#include <string>
#include <vector>

#include "clients/espalier/validation/validation.h"

namespace espalier::validation {

/// How long a case took: by the clock, which also runs while the machine does other work, and of the processor.
struct Duration {
  double seconds = 0.0;
  double processorSeconds = 0.0;
};

/// A case and what came of it.
struct Run {
  const Case* one = nullptr;
  CaseResult result;
  Duration took;
  std::string tableError;  // why a table of the data was refused; empty: it was not
};

/// Runs the cases and reports each, in their order, as soon as it and those before it have run. After a report that is
/// false no other case begins, and the answer is false. Quick cases have one thread and run beside each other, on so
/// many `threads`. A long one may have threads of its own, so nothing runs beside it.
bool runCases(const std::vector<const Case*>& chosen, const Data& data, unsigned threads,
              const std::function<bool(const Run&)>& report);

}  // namespace espalier::validation
