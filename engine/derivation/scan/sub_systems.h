#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/expressions/call_stack.h"
#include "engine/derivation/scan/block_runner.h"
#include "engine/derivation/scan/scan_context.h"

namespace espalier::derivation {

/// The calls `?(id)` ... `$` of sub-L-systems in the string of a plant. Each call has an instance of the variables of
/// its L-system (PlantState::instances, in the order of the calls).
class SubSystems {
 public:
  /// Both must outlive the object.
  SubSystems(ScanContext& context, BlockRunner& blocks);

  /// The main L-system is the active one. After ScanContext::attach.
  void begin();
  /// The L-systems that are active at the present place of the string.
  [[nodiscard]] CallStack& stack() { return stack_; }
  [[nodiscard]] bool isCall(core::ModuleTypeId type) const { return isCall_[type] != 0; }

  /// The L-system with a label; fails when there is none.
  [[nodiscard]] std::uint32_t systemOfCall(double id) const;
  /// Appends fresh instances for all calls in `string`.
  void addInstances(const ModuleString& string, std::vector<InstanceState>& instances) const;

  /// Makes a call active and runs its StartEach, before the first time its Start.
  void enter(std::uint32_t instance);
  /// Runs EndEach of the active call and makes the L-system around it active.
  void leave();
  /// Runs End of the active call, if the call has started.
  void end();
  /// Runs End of every call in `string`, inner calls first, with the variables of the L-systems around it.
  void endAll(const ModuleString& string);

 private:
  [[nodiscard]] const language::LSystem& activeSystem() { return context_->program.systems[stack_.state().system]; }

  ScanContext* context_;
  BlockRunner* blocks_;
  CallStack stack_;
  std::vector<std::uint8_t> isCall_;  // by module type: `?` with parameters; empty: the Program calls none
};

}  // namespace espalier::derivation
