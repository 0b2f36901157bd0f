#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/derivation/state/step_changes.h"
#include "engine/turtle/interpretation/interpretation.h"
#include "engine/turtle/interpretation/turtle_passage.h"

namespace espalier::turtle {

/// The last environment pass over a plant's string, in stretches of the string. The next pass takes over a stretch
/// whose modules were kept when the same turtle comes to it: the turtle moves behind the stretch at once, and only the
/// queries of the stretch are put again, with the parameters that they have now. The rest is interpreted. The queries,
/// their order and the parameters that are filled in the string equal those of Interpretation::run().
class QueryStretches {
 public:
  /// One environment pass. `changes`: from the string at the pass before to this one. The Program must be repeatable
  /// (record_chain.h) and without homomorphism. `output` has `queries`, and nothing that is drawn. When the pass
  /// fails, everything is forgotten. O(stretches) and O(modules) of what is new.
  void run(const Interpretation::Subject& subject, const InterpretationOutput& output,
           const derivation::StepChanges& changes);
  /// The next pass interprets the whole string.
  void forget() {
    stretches_.clear();
    bytes_ = 0;
    isWhole_ = true;
  }
  /// False: the pass was too much to remember (many queries or brackets), and the next one interprets the rest again.
  [[nodiscard]] bool isWhole() const { return isWhole_; }
  /// Bytes of memory: at most 32 for each module of the string.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  /// A query as the turtle came to it.
  struct Query {
    std::uint64_t module = 0;  // E(x), from the first module of the stretch
    std::uint64_t offset = 0;  // of its parameters, from the first of the stretch
    Interpretation::QueryPlace place;
  };
  struct Stretch {
    std::uint64_t firstModule = 0;  // in the string of the last pass
    TurtlePassage passage;
    std::vector<Query> queries;
    [[nodiscard]] std::uint64_t bytes() const;
  };
  using Stretches = std::vector<std::unique_ptr<Stretch>>;
  class Pass;

  Stretches stretches_;  // in the order of the string
  std::uint64_t bytes_ = 0;
  bool isWhole_ = true;
};

}  // namespace espalier::turtle
