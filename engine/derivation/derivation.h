#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>

#include "engine/core/limits.h"
#include "engine/core/streams.h"
#include "engine/derivation/production_counts.h"
#include "engine/derivation/state/module_origins.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/derivation/state/step_changes.h"
#include "engine/language/program.h"

namespace espalier::derivation {

struct ModuleRecord;

struct DerivationOptions {
  std::uint64_t seed = 0;  // Espalier mode: of all draws; cpfg mode: replaces `seed:` when hasSeed
  bool hasSeed = false;
  std::uint32_t plant = 0;
  std::optional<std::uint64_t> derivationLength;  // replaces the model's (Z and when End runs)
  unsigned threads = 1;                           // for long strings; 0 is 1. Results do not depend on them
  std::uint64_t threadedModules = 65536;          // strings with so many modules are long
  core::Limits limits;
  const std::atomic<bool>* cancelled = nullptr;  // polled about every 65,536 modules; must outlive the Derivation
  core::MessageSink messages;                    // printf and run-time warnings; may be empty
  bool canWriteFiles = false;  // the caller takes PlantState::files.output; without, fopen refuses to write
};

/// Derives the strings of one plant. It holds only working memory: PlantState has everything that must last from step
/// to step. Every function throws core::SimulationFailure when the model fails (limits, non-finite values, cancelled).
class Derivation {
 public:
  /// `program` must outlive the object.
  Derivation(const language::Program& program, DerivationOptions options);
  ~Derivation();
  Derivation(Derivation&&) noexcept;
  Derivation& operator=(Derivation&&) noexcept;

  /// The next rewind draws from this seed, which replaces the model's `seed:`.
  void setSeed(std::uint64_t seed);

  /// Sets `state` to step 0: define blocks, Start, the axiom. Warnings may come again that came before. `start` takes
  /// the axiom's place, when it is given; its types are those of the program.
  void rewind(PlantState& state, const ModuleString* start = nullptr);

  /// One DerivationStep after the environment pass (docs/language.md, 1.5): counter, StartEach, the scan with
  /// decomposition, EndEach, and End in the last step. A failure leaves `state` as it was before the call. `changes`
  /// (null: not wanted) receives the parts of the string that the step left as they were. The step adds to `counts`
  /// (null: not wanted) how often it applied each production; it then takes no shortcut and is slower. After a failure
  /// `counts` has the applications before the failure. `origins` (null: not wanted) receives which modules continue
  /// which, which is slower, too.
  void derive(PlantState& state, StepChanges* changes = nullptr, ProductionCounts* counts = nullptr,
              ModuleOrigins* origins = nullptr);

  /// Gives the parameters of the string memory that no view shares, before answers are written into them.
  void ownParameters(PlantState& state);

  /// The same as derive, and records everything that the step does with the module `record.module` of the string.
  /// Slower, because it takes no shortcut. When the step fails, the record ends at the failure.
  void deriveRecorded(PlantState& state, ModuleRecord& record);

  /// Whether the program has homomorphism productions. Without them, interpreting needs no `expand` and does not change
  /// `state`.
  [[nodiscard]] bool hasHomomorphism() const;

  /// Prepares `expand` for the string in `state` (context links, the homomorphism's own random stream).
  void beginInterpretation(PlantState& state);

  /// Applies the homomorphism to the modules from `module` on (parameters from `parameterOffset`), depth first to the
  /// maximum depth, and appends the image to `image`. Returns how many modules of the string were consumed; 0: no
  /// production applies and the module stands for itself. A `%` of the image is left out. `instance` is the index of
  /// the sub-L-system instance around the module (0: the main one). May run blocks, hence `state` is mutable.
  std::uint64_t expand(PlantState& state, std::uint32_t instance, std::uint64_t module, std::uint64_t parameterOffset,
                       ModuleString& image);

  /// Ends the interpretation: random numbers come from the main stream again.
  void endInterpretation(PlantState& state);

  [[nodiscard]] const DerivationOptions& options() const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace espalier::derivation
