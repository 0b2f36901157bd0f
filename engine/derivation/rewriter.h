#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/derivation/expressions/evaluator.h"
#include "engine/derivation/expressions/random_source.h"
#include "engine/derivation/matching/context_matcher.h"
#include "engine/derivation/matching/produced_pieces.h"
#include "engine/derivation/production_counts.h"
#include "engine/derivation/rewrite_record.h"
#include "engine/derivation/state/module_string.h"
#include "engine/derivation/state/string_index.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The place where a predecessor must match. A view.
struct PredecessorPlace {
  const core::ModuleTypeId* types = nullptr;
  const double* parameters = nullptr;
  std::uint64_t size = 0;    // of the string that `types` begins
  std::uint64_t module = 0;  // first module of the predecessor
  std::uint64_t offset = 0;  // of its parameters
};

/// The places in the ContextString where context searches begin.
struct Surroundings {
  std::uint64_t left = 0;        // the left context ends before this module
  std::uint64_t leftOffset = 0;  // its parameters
  std::uint64_t right = 0;       // the right context begins here
  std::uint64_t rightOffset = 0;
  bool isBehindPredecessor = true;  // the right context begins behind the predecessor; `right` is not used
};

/// Matches, chooses and applies single productions of any kind: contexts, conditions, blocks, weights, and the nested
/// rewriting of decomposition and homomorphism. The clear and complete way; the scans have shortcuts for simple cases.
class Rewriter {
 public:
  /// All must outlive the object.
  Rewriter(const language::Program& program, Evaluator& evaluator, RandomSource& random, const core::Limits& limits);

  /// Gives the string around the predecessors, and the string being produced: `produced` from left to right, where `<<`
  /// looks, or `pieces` from right to left, where `>>` looks. Null: such contexts never match.
  void setStrings(const ContextString& around, const ModuleString* produced, ProducedPieces* pieces = nullptr);
  [[nodiscard]] const ContextString& around() const { return around_; }

  /// Gives the module types that a predecessor may begin with but never reach over, by type: calls of sub-L-systems and
  /// their `$`.
  void setBarriers(std::vector<std::uint8_t> isBarrier) { isBarrier_ = std::move(isBarrier); }

  /// Is silent from now on about the lists about which `other`, of the same Program, has warned, and only about these.
  void adoptWarnings(const Rewriter& other) { warnedLists_ = other.warnedLists_; }
  /// Warns about every list again.
  void forgetWarnings() { warnedLists_.clear(); }

  /// Whether it has warned about the maximum depth of the list.
  [[nodiscard]] bool hasWarnedAbout(const language::ProductionList& list) const {
    return std::find(warnedLists_.begin(), warnedLists_.end(), &list) != warnedLists_.end();
  }

  /// Adds every search and application from now on to `record`; null: to no record. Changes nothing else.
  void setRecord(ModuleRecord* record) { record_ = record; }
  /// Adds every application from now on to `counts`; null: nowhere. Changes nothing else.
  void setCounts(ProductionCounts* counts) { counts_ = counts; }

  /// The first production of the list that matches, or null. Runs the pre-blocks of all candidates up to it.
  [[nodiscard]] const language::Production* chooseFirst(const language::ProductionList& list, const ContextRules& rules,
                                                        const PredecessorPlace& place,
                                                        const Surroundings& surroundings);

  /// One of all productions that match, chosen by weight, or null. Runs the pre-blocks of all candidates. `draw` is the
  /// selection draw in the compatible modes; Espalier's own mode makes it here, from (step, module).
  [[nodiscard]] const language::Production* chooseByWeights(const language::ProductionList& list,
                                                            const ContextRules& rules, const PredecessorPlace& place,
                                                            const Surroundings& surroundings, std::uint64_t step,
                                                            double draw);

  /// Runs the post-block of the production chosen last, then appends its successor with evaluated parameters.
  void apply(const language::Production& production, ModuleString& output);

  /// The same, with every module of the successor rewritten further by `list`, depth first; the successor is at
  /// `depth`. Contexts are those of the original predecessor. `dropsCut` leaves `%` out of the result.
  void applyNested(const language::Production& production, const language::ProductionList& list,
                   const ContextRules& rules, const Surroundings& surroundings, std::uint32_t depth, bool dropsCut,
                   core::DrawDomain domain, std::uint64_t step, std::uint64_t index, ModuleString& output);

  /// Number of parameters of a production's predecessor.
  [[nodiscard]] std::uint64_t parameterCount(const language::Production& production) const;

  /// Throws LimitExceeded when a string is longer than the limits allow.
  void checkSize(std::uint64_t moduleCount, std::uint64_t parameterCount) const;

  /// The value as a string stores it: rounded to a 32-bit float in the compatible modes. In Espalier's own mode it
  /// fails when the value is not finite; `position` (from 0) and `type` name the parameter in the message.
  [[nodiscard]] double stored(double value, const language::Expression& expression, std::size_t position,
                              core::ModuleTypeId type) const {
    if (storesFloats_) {
      return static_cast<double>(static_cast<float>(value));
    }
    // false for NaN and infinities
    if (!(value - value == 0.0)) {
      failNonFinite(value, expression, position, type);
    }
    return value;
  }
  [[nodiscard]] bool storesFloats() const { return storesFloats_; }
  [[noreturn]] void failNonFinite(double value, const language::Expression& expression, std::size_t position,
                                  core::ModuleTypeId type) const;
  [[noreturn]] void failWeights(const language::Production& production) const;

 private:
  struct Level {
    std::uint64_t firstModule = 0;  // in scratch_; everything from here goes when the level is done
    std::uint64_t firstParameter = 0;
    std::uint64_t module = 0;  // next module
    std::uint64_t offset = 0;
    std::uint64_t end = 0;                             // modules of this level end here
    std::uint32_t depth = 0;                           // rewritings that made these modules
    const language::Production* production = nullptr;  // the last of them
  };

  [[nodiscard]] bool matches(const language::Production& production, const ContextRules& rules,
                             const PredecessorPlace& place, const Surroundings& surroundings, double* frame);
  [[nodiscard]] bool matchesShape(const language::Production& production, const ContextRules& rules,
                                  const PredecessorPlace& place, const Surroundings& surroundings, double* frame,
                                  CandidateRecord* record);
  [[nodiscard]] bool matchesProduced(const language::Production& production, const ContextRules& rules, double* frame);
  SearchRecord& beginSearch(const language::ProductionList& list, const PredecessorPlace& place, std::uint32_t depth);
  bool recordCondition(const language::Production& production, double* frame, CandidateRecord& record);
  void warnAtDepth(const language::ProductionList& list, const ContextRules& rules, const PredecessorPlace& place,
                   const Surroundings& surroundings);
  [[nodiscard]] bool isTooLarge(std::uint64_t moduleCount, std::uint64_t parameterCount) const;
  /// `what` is too large: the string, or what one module became.
  [[noreturn]] void failSize(std::uint64_t moduleCount, const std::string& what, core::SourceRange range) const;
  void appendSuccessor(const language::Production& production, double* frame, ModuleString& output);
  void rewriteLevels(const language::ProductionList& list, const ContextRules& rules, const Surroundings& surroundings,
                     bool dropsCut, ModuleString& output);

  const language::Program* program_;
  Evaluator* evaluator_;
  RandomSource* random_;
  const core::Limits* limits_;
  ModuleRecord* record_ = nullptr;      // of the caller; null: nothing is recorded
  ProductionCounts* counts_ = nullptr;  // of the caller; null: nothing is counted
  std::uint32_t searchDepth_ = 0;       // of the present module, for the record
  bool storesFloats_;
  ContextString around_;
  const ModuleString* produced_ = nullptr;  // the string being produced, of the caller
  ProducedPieces* pieces_ = nullptr;        // the same when it is produced from right to left
  StringIndex producedIndex_;               // its bracket links, as far as searches needed them
  SearchShortcuts producedShortcuts_;       // in it
  std::vector<std::uint8_t> isBarrier_;     // by module type; empty: none
  std::vector<double> frames_;              // formal parameters, Program::maximumSlots for each candidate
  double* chosenFrame_ = nullptr;           // in frames_: of the production chosen last
  std::vector<const language::Production*> matches_;
  std::vector<double> weights_;
  ModuleString scratch_;  // successors waiting to be rewritten further
  std::vector<Level> levels_;
  std::vector<const language::ProductionList*> warnedLists_;
};

}  // namespace espalier::derivation
