#pragma once

#include <cstdint>
#include <memory>

#include "engine/core/worker_team.h"
#include "engine/derivation/scan/backward_scan.h"
#include "engine/derivation/scan/batch_scan.h"
#include "engine/derivation/scan/general_scan.h"
#include "engine/derivation/scan/module_rewriter.h"
#include "engine/derivation/scan/plain_scan.h"
#include "engine/derivation/scan/scan_context.h"
#include "engine/derivation/scan/sub_system_scan.h"

namespace espalier::derivation {

class ParallelBatchScan;
class ParallelGeneralScan;

/// The scan of one step: chooses the kind of scan that is quickest for the model and the string, and runs it. All kinds
/// give the same string, bit by bit.
class StepScan {
 public:
  /// Both must outlive the object.
  StepScan(ScanContext& context, SubSystems& calls);
  ~StepScan();

  /// Reads the string of the context's plant and writes the new one to the context's output.
  void run();
  /// The context's output becomes the plant's string; the old string stays in the output until the next step.
  void swapStrings();

 private:
  enum class Kind : std::uint8_t {
    SubSystems,       // the model calls sub-L-systems
    Backward,         // it has `>>`
    General,          // the caller wants a record of one module, or counts of productions
    ParallelBatch,    // a long string, several threads, batches can do every module
    ParallelGeneral,  // a long string, several threads, no module depends on another
    Batch,            // batches can do many modules
    Plain,            // everything else
  };

  [[nodiscard]] Kind chooseKind(const ModuleString& old) const;
  void begin(Kind kind, const ModuleString& old);
  void finish(Kind kind, const ModuleString& old);
  void reserveEstimate(const ModuleString& old);
  [[nodiscard]] core::WorkerTeam& team();

  ScanContext* context_;
  unsigned threadCount_ = 1;  // DerivationOptions::threads within 1 to kMostThreads
  bool needsLinks_ = false;   // contexts follow the brackets of the old string
  ModuleRewriter rewriter_;
  PlainScan plain_;
  BatchScan batch_;
  GeneralScan general_;
  BackwardScan backward_;
  SubSystemScan subSystems_;
  // made when a string is long enough for several threads
  std::unique_ptr<core::WorkerTeam> team_;
  std::unique_ptr<ParallelBatchScan> parallelBatch_;
  std::unique_ptr<ParallelGeneralScan> parallelGeneral_;

  bool areLinksRight_ = false;  // in the step: the context's index is that of the old string
  double moduleGrowth_ = 2.0;   // new modules per old one in the last step, for the first reservation
  double parameterGrowth_ = 2.0;
};

}  // namespace espalier::derivation
