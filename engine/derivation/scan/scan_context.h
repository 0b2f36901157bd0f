#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/derivation.h"
#include "engine/derivation/expressions/evaluator.h"
#include "engine/derivation/expressions/random_source.h"
#include "engine/derivation/rewriter.h"
#include "engine/derivation/scan/cut_parts.h"
#include "engine/derivation/state/module_origins.h"
#include "engine/derivation/state/plant_state.h"
#include "engine/derivation/state/step_changes.h"
#include "engine/derivation/state/string_index.h"
#include "engine/derivation/state/string_rotation.h"
#include "engine/derivation/system_tables.h"

namespace espalier::derivation {

/// A place in the old string.
struct ScanPlace {
  std::uint64_t module = 0;
  std::uint64_t offset = 0;  // of the module's parameters
};

/// The data that every scan reads and writes. A scan goes over the modules of the old string and appends their results
/// to `output`. One thread at a time.
struct ScanContext {
  /// `program` and `tables` must outlive the object.
  ScanContext(const language::Program& program, const std::vector<SystemTables>& tables, DerivationOptions options);
  ScanContext(const ScanContext&) = delete;
  ScanContext& operator=(const ScanContext&) = delete;

  /// The following scans and blocks belong to this plant and step. `failingStep` is the step that failures name.
  void attach(PlantState& plant, std::uint64_t number, std::uint64_t failingStep);
  /// Scans read `string` from now on, whose brackets `links` knows. `produced` and `pieces` as in Rewriter::setStrings.
  void read(const ModuleString& string, const StringIndex& links, const ModuleString* produced,
            ProducedPieces* pieces = nullptr);
  /// Indexes the brackets of `string`.
  void buildIndex(const ModuleString& string);

  /// The modules of the old string from `begin` to `end` have become those of the output from `modules` and
  /// `parameters` on: notes what is equal at both ends, when somebody wants to know.
  void noteEqualEnds(const ScanPlace& begin, const ScanPlace& end, std::uint64_t modules, std::uint64_t parameters);

  /// The modules `begin` to `end` of the old string have become the modules of the output from `modules` on.
  void noteOrigins(std::uint64_t begin, std::uint64_t end, std::uint64_t modules) {
    if (origins != nullptr) {
      origins->add(program, *old, begin, end, output, modules, output.size());
    }
  }

  /// Whether the compatible modes draw a selection number at every position of this L-system.
  [[nodiscard]] bool drawsEachPosition(const language::LSystem& system) const {
    return random.isSequential() && system.isStochastic;
  }
  [[nodiscard]] bool isCancelled() const;
  [[nodiscard]] bool isWithinLimits(std::uint64_t moduleCount, std::uint64_t parameterCount) const;
  /// Makes room in `output` for so many modules and parameters in all.
  void reserveOutput(std::uint64_t moduleCount, std::uint64_t parameterCount);

  // the same in every step
  const language::Program& program;
  DerivationOptions options;                // only the seed changes, between runs
  const std::vector<SystemTables>& tables;  // by L-system
  RandomSource random;
  Evaluator evaluator;
  Rewriter rewriter;

  // of the step
  std::uint64_t step = 0;             // its number; while interpreting: the completed steps
  PlantState* plant = nullptr;        // of the caller of Derivation
  const ModuleString* old = nullptr;  // the string that is read; of the caller
  ModuleString output;                // the string being produced; between steps: the string that was read last
  StringRotation rotation;            // memory for `output` and the plant's string
  CutParts cuts;                      // of the step
  StepChanges* changes = nullptr;     // the unchanged modules of the step are noted here; null: nowhere
  StringIndex index;                  // brackets of the string that is read
  bool isOutputIndexed = false;       // between steps: `index` is that of `output`
  SearchShortcuts shortcuts;          // in the string that is read
  ModuleRecord* record = nullptr;     // of the caller of deriveRecorded, while it runs
  ModuleOrigins* origins = nullptr;   // which modules continue which is noted here; null: nowhere
  bool isCounted = false;             // the Rewriter counts how often each production is applied
  std::uint64_t scannedModules = 0;   // in all steps so far
};

}  // namespace espalier::derivation
