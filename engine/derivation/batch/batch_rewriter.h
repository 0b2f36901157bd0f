#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/random.h"
#include "engine/derivation/batch/batch_plan.h"
#include "engine/derivation/batch/column_evaluator.h"
#include "engine/derivation/batch/context_columns.h"
#include "engine/derivation/batch/last_stores.h"
#include "engine/derivation/batch/scratch.h"
#include "engine/derivation/batch/type_sum.h"
#include "engine/derivation/matching/context_matcher.h"
#include "engine/derivation/state/module_finder.h"
#include "engine/derivation/state/step_changes.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// Rewrites a chunk of a string in two passes: choose() decides about every module and counts the result, write()
/// writes the result. Between the two the caller learns its length. The object reads the old string and writes only to
/// the given place, so several threads can work on one step, each with its own object.
///
/// It neither warns nor fails. Where the Evaluator would warn or the step would fail, it calls the chunk unusual; the
/// caller then repeats the chunk by the PlainScan, in the order of the string.
class BatchRewriter {
 public:
  /// The most modules of one chunk. Where every module becomes a fixed block or stays, chunks may be of any length.
  static constexpr std::uint64_t kChunkModules = 2048;

  /// The facts that all chunks of a step share.
  struct Step {
    ContextString old;  // the string that is read; its shortcuts are for this object alone
    std::uint32_t number = 0;
    ColumnInputs inputs;            // that code reads; unchanged until the next begin
    core::CounterRandom selection;  // Espalier's own mode
    bool storesFloats = false;      // parameters are rounded to 32-bit floats and may be anything
  };

  struct Outcome {
    // the end of the chunk: a General module, the end that the caller gave, or the end of a predecessor that reaches
    // over it
    std::uint64_t endModule = 0;
    std::uint64_t endParameter = 0;  // of the old string
    std::uint64_t moduleCount = 0;   // that write() will make
    std::uint64_t parameterCount = 0;
    bool isUnusual = false;
    std::uint64_t lightSites = 0;  // modules of light groups and fixed blocks
    bool isChanged = true;         // some production applies
  };

  /// `program`, `rules`, `plan` and `productions` must outlive the object.
  BatchRewriter(const language::Program& program, const ContextRules& rules, const BatchPlan& plan,
                const ProductionPlan& productions);

  void begin(const Step& step);
  /// Decides about the modules [first, end), no more than a chunk; the parameters of the first begin at `offset`.
  [[nodiscard]] Outcome choose(std::uint64_t first, std::uint64_t end, std::uint64_t offset);
  /// Writes the last choice: exactly the modules and parameters of its Outcome. False: a value is unusual. The result
  /// is then right if the step only warns, and of no use if it fails.
  [[nodiscard]] bool write(core::ModuleTypeId* types, double* parameters);
  /// The place in the result of what a module of the last choice has become, counted from the result's first module.
  [[nodiscard]] std::uint64_t placeOfResult(std::uint64_t module) const;
  /// The values that blocks have left in local variables since the last choice, as far as write() has run.
  [[nodiscard]] const LastStores& stores() const { return stores_; }
  /// Notes the modules that the last choice leaves as they are; `target` is the module of the new string where its
  /// result begins. Some may be missing.
  void noteKept(std::uint64_t target, StepChanges& changes) const;

 private:
  /// Sites that one rule rewrites: entries [begin, begin + count) of the lane arrays.
  struct RuleLanes {
    const BatchRule* rule = nullptr;
    std::size_t begin = 0;
    std::size_t count = 0;
  };

  /// An assignment in the block before a condition.
  struct PossibleStore {
    std::uint32_t site = 0;
    std::uint32_t variable = 0;  // the static
    double value = 0.0;
  };

  static constexpr std::uint64_t kNoRow = ~std::uint64_t{0};

  [[nodiscard]] Outcome countFixed();
  void writeFixed(core::ModuleTypeId* types, double* parameters) const;
  void collectSites();
  void dropPairs();
  void dropCutParts();
  void sortSites();
  [[nodiscard]] std::span<const std::uint32_t> sitesOf(std::size_t group) const {
    return {sorted_.data() + group * kChunkModules, groupEnds_[group] - group * kChunkModules};
  }
  void chooseGroup(const BatchGroup& group, std::span<const std::uint32_t> sites);
  void chooseFirst(const BatchGroup& group, std::span<const std::uint32_t> sites);
  void chooseByThresholds(const BatchGroup& group, std::span<const std::uint32_t> sites);
  void chooseByWeights(const BatchGroup& group, std::span<const std::uint32_t> sites);
  [[nodiscard]] double draw(std::uint64_t module);
  void loadDraws();
  std::size_t match(const BatchRule& rule, std::span<const std::uint32_t> sites);
  template <bool kLooksLeft, bool kLooksRight>
  std::size_t matchNear(const BatchRule& rule, std::span<const std::uint32_t> sites);
  template <bool kKeepsModules>
  void findLeft(std::span<const std::uint32_t> sites);
  template <bool kKeepsModules>
  void findRight(std::span<const std::uint32_t> sites);
  void findNeighbours(const BatchGroup& group, std::span<const std::uint32_t> sites);
  std::size_t matchSearched(const BatchRule& rule, std::span<const std::uint32_t> sites);
  [[nodiscard]] bool standsAt(const language::Production& production, std::uint64_t module) const;
  /// The number of lanes for which a condition holds; they are in true_ when it does not hold for all.
  std::size_t findTrue(const ColumnValue& truth, std::size_t count);
  std::size_t keepWhereTrue(const BatchRule& rule, std::size_t count);
  void noteStores(const BatchRule& rule, const ColumnCode& code, std::size_t begin, std::size_t count, bool isBehind);
  void loadKept(const BatchRule& rule, std::size_t begin, std::size_t count);
  void moveLane(const BatchRule& rule, std::size_t from, std::size_t to);
  void accept(const BatchRule& rule, std::size_t count);
  void dropOverlapped();
  void setLanes(const BatchRule& rule, std::size_t begin, std::size_t count);
  void place();
  [[nodiscard]] bool staysAsItIs(std::size_t site) const;
  void noteKeptFixed(std::uint64_t target, StepChanges& changes) const;
  void writeBlocks(core::ModuleTypeId* types, double* parameters) const;
  [[nodiscard]] bool writeValues(const RuleLanes& lanes, double* parameters);

  const language::Program* program_;
  const ContextRules* rules_;
  const BatchPlan* plan_;
  const ProductionPlan* productions_;
  Step step_;
  ColumnEvaluator evaluator_;
  ModuleFinder finder_;
  TypeSum fixedModuleSum_;  // modules that a stretch becomes; fixed models only
  TypeSum fixedParameterSum_;
  TypeSum parameterSum_;

  // the chunk
  std::uint64_t first_ = 0;
  std::uint64_t end_ = 0;
  std::uint64_t offset_ = 0;        // parameters of the first module
  std::uint64_t endOffset_ = 0;     // behind the last module
  std::uint64_t fixedModules_ = 0;  // that a fixed chunk makes
  std::uint64_t fixedParameters_ = 0;
  bool isUnusual_ = false;
  bool isResized_ = false;
  bool isChanged_ = false;
  bool areDrawsLoaded_ = false;
  std::uint64_t lightSites_ = 0;

  std::vector<BatchBlock> blocks_;  // those of the plan, then one for each `%` of the chunk

  // the sites: modules that may not stay as they are
  std::size_t siteCount_ = 0;
  Scratch<std::uint32_t> siteModule_;   // counted from the chunk's first module
  Scratch<std::uint32_t> siteOffset_;   // parameters, counted from those of the chunk's first module
  Scratch<std::uint8_t> siteBits_;      // candidates that may apply
  Scratch<std::uint32_t> siteBlock_;    // the new modules: in blocks_
  std::vector<ModuleDraws> siteDraws_;  // by site, in models that draw
  Scratch<std::uint32_t> madeModule_;   // their place, counted from the beginning of the chunk's result
  Scratch<std::uint32_t> madeOffset_;
  Scratch<std::uint32_t> resizing_;  // sites whose block has another size than the module
  std::size_t resizingCount_ = 0;
  std::uint32_t madeModules_ = 0;  // of the chunk's result, when something resizes
  std::uint32_t madeParameters_ = 0;

  Scratch<std::uint32_t> allSites_;       // 0, 1, 2, ...
  Scratch<std::uint32_t> sorted_;         // sites by group, in the order of the string; kChunkModules for each group
  std::vector<std::uint32_t> groupOf_;    // by module type: the group; groupCount: fixed; groupCount + 1: general
  std::vector<std::uint32_t> groupEnds_;  // in sorted_ (groupCount + 2)
  Scratch<std::uint32_t> remaining_;      // sites that no rule has taken so far

  // the lanes of all rules that chose sites
  std::size_t laneCount_ = 0;
  Scratch<std::uint32_t> laneSite_;
  Scratch<std::uint64_t> laneLeft_;       // parameters of the left neighbour, or the begin of the search's row
  Scratch<std::uint64_t> laneRight_;      // parameters of the right neighbour
  Scratch<core::ModuleTypeId> leftType_;  // by site: the nearest neighbour, or kNoModuleType
  Scratch<core::ModuleTypeId> rightType_;
  Scratch<std::uint64_t> leftOffset_;  // by site: its parameters
  Scratch<std::uint64_t> rightOffset_;
  Scratch<std::uint64_t> leftModule_;  // by site: its place in the string, for BatchGroup::keepsModules
  Scratch<std::uint64_t> rightModule_;
  ContextColumns contexts_;
  Scratch<std::uint64_t> siteRow_;   // by site: what the last rule that keeps its places has found, or kNoRow
  std::vector<std::uint64_t> rows_;  // of context searches: where the parameters of each element begin
  std::size_t rowsUsed_ = 0;         // elements of rows_ that lanes of this chunk use
  Scratch<double> keptColumns_;      // BatchRule::kept of each lane, 2 * kChunkModules for each column
  LastStores stores_;
  std::vector<RuleLanes> ruleLanes_;
  Scratch<std::uint32_t> true_;     // lanes whose condition holds, of those that are evaluated
  Scratch<std::uint64_t> modules_;  // their places in the string, for expressions that draw

  Scratch<std::uint32_t> words_;  // draws of the chunk's modules, from a multiple of 4 on
  std::vector<double> weights_;   // by rule of a group and lane
  std::vector<std::uint8_t> isMatched_;
  Scratch<std::uint32_t> positions_;  // by site: its lane among the weighed sites
  std::vector<std::uint32_t> chosenRule_;
  std::vector<std::uint32_t> drawsBefore_;  // by rule and lane: how many draws came before the rule
  std::vector<double> candidateWeights_;
  std::vector<std::uint32_t> candidates_;

  // predecessors of several modules
  Scratch<std::uint8_t> isCovered_;            // by site: an earlier predecessor has the module
  std::vector<PossibleStore> possibleStores_;  // of the chunk; those of covered sites do not count
};

}  // namespace espalier::derivation
