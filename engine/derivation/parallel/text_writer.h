#pragma once

#include <memory>

#include "engine/core/number_text.h"
#include "engine/core/streams.h"
#include "engine/core/worker_team.h"
#include "engine/derivation/state/module_string.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Writes strings as text, with several threads where a string is long. The threads spell pieces of the string and hand
/// them to the sink in the order of the string, so a text of any length needs little memory. Keeps its threads between
/// strings.
class TextWriter {
 public:
  /// `threads` at least 1.
  explicit TextWriter(unsigned threads) : threads_(threads) {}
  /// Writes the text of a string as appendText does. Throws what the sink throws.
  void write(core::ByteSink& sink, const language::Program& program, const ModuleString& string,
             core::NumberStyle style);

 private:
  unsigned threads_;
  std::unique_ptr<core::WorkerTeam> team_;  // null: not needed yet
};

}  // namespace espalier::derivation
