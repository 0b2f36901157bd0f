#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/core/worker_team.h"
#include "engine/derivation/batch/batch_scan.h"
#include "engine/derivation/batch/type_sum.h"
#include "engine/derivation/derivation.h"
#include "engine/derivation/expressions/call_stack.h"
#include "engine/derivation/expressions/evaluator.h"
#include "engine/derivation/expressions/random_source.h"
#include "engine/derivation/rewrite_record.h"
#include "engine/derivation/rewriter.h"
#include "engine/derivation/state/string_index.h"
#include "engine/derivation/system_tables.h"

namespace espalier::derivation {

/// Derivation's working memory and the parts of a step. derivation.cpp holds the outline of a step and interpretation,
/// scan.cpp the scan of a model without sub-L-systems, sub_systems.cpp the scan with them.
class Derivation::Implementation {
 public:
  Implementation(const language::Program& program, DerivationOptions options);

  void rewind(PlantState& state, const ModuleString* start);
  void derive(PlantState& state);
  [[nodiscard]] bool hasHomomorphism() const { return hasHomomorphism_; }
  void beginInterpretation(PlantState& state);
  std::uint64_t expand(PlantState& state, std::uint32_t instance, std::uint64_t module, std::uint64_t parameterOffset,
                       ModuleString& image);
  void endInterpretation();
  void deriveRecorded(PlantState& state, ModuleRecord& record);
  [[nodiscard]] const DerivationOptions& options() const { return options_; }

 private:
  /// The blocks of an L-system; the number is part of the key of their draws.
  enum class Block : std::uint8_t { Start = 0, Axiom = 1, StartEach = 2, EndEach = 3, End = 4 };

  /// What happened to the module at a position.
  enum class Fate : std::uint8_t { Rewritten, Copied, Cut };
  struct Outcome {
    std::uint64_t modules = 1;  // of the old string consumed
    std::uint64_t parameters = 0;
    Fate fate = Fate::Rewritten;
  };

  /// A part of the old string.
  struct StringPart {
    std::uint64_t firstModule = 0;
    std::uint64_t endModule = 0;
    std::uint64_t firstParameter = 0;
    std::uint64_t endParameter = 0;
  };

  /// The small parts of a PlantState, kept to undo a step that fails.
  struct Backup {
    std::uint64_t step = 0;
    std::uint64_t derivationLength = 0;
    bool isStopped = false;
    std::vector<double> statics;
    std::vector<InstanceState> instances;
    RandomState random;
    FileState files;
    void save(const PlantState& state);
    void restore(PlantState& state) const;
  };

  // derivation.cpp
  void attach(PlantState& state, std::uint64_t step, std::uint64_t failingStep);
  void runStep(PlantState& state);
  void runBlock(language::CodeRange code, Block block, std::uint32_t instance);
  void appendAxiom(ModuleString& string);
  void seedStreams(RandomState& random) const;
  [[nodiscard]] bool needsIndex(const language::LSystem& system) const;
  void buildIndex(const ModuleString& string);
  void findParents(const ModuleString& string);
  [[noreturn]] void failArity(core::ModuleTypeId type) const;

  // scan.cpp
  void scan(PlantState& state);
  /// A place in the old string.
  struct ScanPlace {
    std::uint64_t module = 0;
    std::uint64_t offset = 0;  // its parameters
  };
  void scanUpTo(const PlantState& state, std::uint64_t end, ScanPlace& place);
  template <bool kDrawsEachPosition, bool kHasParameters>
  void scanPlain(const PlantState& state, std::uint64_t end, ScanPlace& place);
  [[nodiscard]] bool usesBatches(const ModuleString& old) const;
  void scanInBatches(const PlantState& state, std::uint64_t end, ScanPlace& place);
  [[nodiscard]] BatchScan::Step batchStep(const PlantState& state) const;
  [[nodiscard]] bool appendBatch(const BatchScan::Outcome& outcome);
  [[nodiscard]] bool isWithinLimits(std::uint64_t moduleCount, std::uint64_t parameterCount) const;
  [[nodiscard]] const QuickRule* chooseQuickRule(const QuickRule* first, const QuickRule* last, double* frame,
                                                 std::uint64_t module, double draw);
  [[noreturn]] void failQuickValue(const QuickRule& rule, std::uint32_t valueIndex, double value, std::uint64_t module,
                                   core::ModuleTypeId type);

  // parallel_scan.cpp
  [[nodiscard]] bool isThreaded(const ModuleString& old) const;
  [[nodiscard]] bool canScanInParallel(const ModuleString& old);
  void scanInParallel(const PlantState& state);
  void makeTeam();
  void findChunkOffsets(const ModuleString& old, std::uint64_t chunkModules);
  std::uint64_t scanRound(const ModuleString& old, const BatchScan::Step& step, std::uint64_t firstChunk);

  // parted_scan.cpp
  [[nodiscard]] bool canScanInParts(const ModuleString& old) const;
  void scanInParts(const PlantState& state);
  [[nodiscard]] ScanPlace chunkStart(const ModuleString& old, std::uint64_t chunk) const;
  std::uint64_t scanPartRound(const PlantState& state, std::uint64_t firstChunk, ScanPlace& place);
  [[nodiscard]] std::unique_ptr<Implementation> makeHelper() const;
  void beginParts(const PlantState& state, const Implementation& owner);
  [[nodiscard]] bool scanPart(const PlantState& state, std::uint64_t end, ScanPlace& place);

  void scanBackwards(const PlantState& state);
  void reserveOutput(std::uint64_t moduleCount, std::uint64_t parameterCount);
  void reserveEstimate(const ModuleString& old);
  Outcome rewriteModule(const SystemTables& tables, const ModuleString& old, std::uint64_t module, std::uint64_t offset,
                        double draw, ModuleString& output) {
    return record_ == nullptr ? rewrite(tables, old, module, offset, draw, output)
                              : rewriteRecorded(tables, old, module, offset, draw, output);
  }
  Outcome rewrite(const SystemTables& tables, const ModuleString& old, std::uint64_t module, std::uint64_t offset,
                  double draw, ModuleString& output);
  [[nodiscard]] StringPart cutPart(const ModuleString& old, std::uint64_t module, std::uint64_t offset) const;
  void keepCutPart(const ModuleString& old, const StringPart& part, std::uint64_t offset);
  void appendKeptParts(const ModuleString& old);

  // recording.cpp
  void scanRecorded(const PlantState& state);
  Outcome rewriteRecorded(const SystemTables& tables, const ModuleString& old, std::uint64_t module,
                          std::uint64_t offset, double draw, ModuleString& output);
  void recordCut(const StringPart& part);

  // sub_systems.cpp
  void scanWithCalls(PlantState& state);
  void enterCall(PlantState& state, std::uint32_t instance);
  void leaveCall(PlantState& state);
  void endCall(PlantState& state, std::uint32_t instance);
  StringPart cutWithCalls(PlantState& state, std::uint64_t module, std::uint64_t offset, std::uint32_t& nextCall);
  void addCalls(std::uint64_t firstModule, std::uint64_t firstParameter);
  void addCallsOf(const ModuleString& string, std::vector<InstanceState>& instances);
  [[nodiscard]] std::uint32_t systemOfCall(double id) const;
  void endAllCalls(PlantState& state);

  const language::Program* program_;
  DerivationOptions options_;
  RandomSource random_;
  Evaluator evaluator_;
  Rewriter rewriter_;
  CallStack calls_;
  std::vector<SystemTables> tables_;  // by L-system
  std::vector<std::uint8_t> isCall_;  // by module type: `?` with parameters; only when sub-L-systems are called
  core::ModuleTypeId cutWithTurtle_ = core::kNoModuleType;  // `%` with one parameter
  core::ModuleTypeId keptCut_ = core::kNoModuleType;        // `%` with two
  std::vector<core::ModuleTypeId> tooLong_;                 // types with more parameters than the limits allow
  bool hasHomomorphism_ = false;
  bool hasHomomorphismContexts_ = false;
  bool hasParameters_ = false;

  std::vector<std::unique_ptr<BatchScan>> batches_;  // by thread; made when a string is long enough to use them
  std::uint64_t scannedModules_ = 0;                 // since the beginning, or of a helper its owner
  std::uint64_t modulesAlone_ = 0;           // that one at a time is to do, over steps, before batches are tried again
  std::uint64_t generalModules_ = 1;         // how many that is behind a module of the general way
  unsigned threadCount_ = 1;                 // DerivationOptions::threads, or as many as the machine has
  std::unique_ptr<core::WorkerTeam> team_;   // made when a string is long enough for several threads
  TypeSum parameterSum_;                     // of a stretch of the string
  std::uint64_t chunkModules_ = 0;           // of a chunk of the string that several threads read
  std::vector<std::uint64_t> chunkOffsets_;  // by chunk: its first parameter in the string that is read; one more
  std::vector<StringIndex::OpenEnds> openEnds_;  // by part of the string that is read
  std::vector<std::uint64_t> unusualChunks_;     // of the last round of threads

  std::vector<std::unique_ptr<Implementation>> helpers_;  // by thread: each scans chunks by itself; made when needed
  PlantState partState_;                                  // of a helper: its owner's variables
  bool hasPartWarned_ = false;                            // of a helper: the chunk must be done by its owner

  ModuleString working_;             // the string being produced; swapped with the old one at the end of a step
  KeptModulesRecorder keptModules_;  // of a step, by batches
  ProducedPieces pieces_;            // the same while it is produced from right to left
  StringIndex index_;                // of the string that is being read
  bool isWorkingIndexed_ = false;    // between steps: `index_` is that of `working_`, the string that was read last
  bool isOldIndexed_ = false;        // the step's scan has indexed the string that it read
  bool areLinksKept_ = false;        // in the step: `index_` was right for the string that is read
  LeftShortcuts shortcuts_;          // in it, by the rules of the main L-system
  Backup backup_;
  std::vector<double> frame_;    // formal parameters of the scan's shortcuts (Program::maximumSlots)
  std::vector<double> weights_;  // of the scan's shortcuts
  std::vector<const QuickRule*> quickMatches_;
  ModuleRecord* record_ = nullptr;  // of the caller of deriveRecorded, while it runs
  std::uint64_t step_ = 0;          // the step being made; while interpreting: the completed steps
  double moduleGrowth_ = 2.0;       // new modules per old one in the last step, for the first reservation
  double parameterGrowth_ = 2.0;
  struct KeptPart {
    StringPart part;
    double parameter = 0.0;
  };
  std::vector<KeptPart> keptParts_;  // cut by `%(p)` in this step, to be appended at the end
  struct CallOrigin {
    bool isFresh = false;
    std::uint32_t index = 0;  // of the old instance, or the L-system of a fresh one
  };
  std::vector<CallOrigin> callOrigins_;      // of the calls in the string being produced, in order
  std::vector<CallOrigin> keptCallOrigins_;  // of those in keptParts_, in order
  std::vector<std::uint32_t> parents_;       // by instance: the call around it; while interpreting
  std::vector<std::uint32_t> chain_;
};

}  // namespace espalier::derivation
