#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "engine/derivation/expressions/evaluator.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The L-systems that are active at one place of the string: the main L-system and the calls of sub-L-systems around
/// the place, outermost first. Entering a call copies each external variable from the nearest enclosing L-system that
/// has a variable of that name; leaving the call copies it back (docs/language.md, 1.4).
class CallStack {
 public:
  static constexpr std::size_t kMaximumDepth = 100;

  /// `program` and `evaluator` must outlive the object.
  CallStack(const language::Program& program, Evaluator& evaluator);

  /// Only the main L-system is active. `instances` must stay in place while the stack is used.
  void reset(std::vector<InstanceState>& instances);

  /// Makes a call the active L-system. Fails when its L-system is active already or 100 calls are open.
  void push(std::uint32_t instance, core::SourceRange range = {});
  /// Makes the enclosing L-system active.
  void pop();

  [[nodiscard]] std::size_t depth() const { return frames_.size(); }  // 1: only the main L-system
  [[nodiscard]] std::uint32_t instance() const { return frames_.back().instance; }
  [[nodiscard]] InstanceState& state() { return (*instances_)[frames_.back().instance]; }

 private:
  struct Binding {
    std::uint32_t slot = 0;           // variable of the call
    std::uint32_t outerInstance = 0;  // whose variable it is
    std::uint32_t outerSlot = 0;
  };
  struct Frame {
    std::uint32_t instance = 0;    // index into the instances
    std::size_t firstBinding = 0;  // in bindings_
  };

  const language::Program* program_;
  Evaluator* evaluator_;
  std::vector<InstanceState>* instances_ = nullptr;  // of the plant that reset was called for
  std::vector<Frame> frames_;
  std::vector<Binding> bindings_;
  std::vector<std::uint8_t> hasWarned_;  // by L-system: an external variable that no caller has was reported
};

}  // namespace espalier::derivation
