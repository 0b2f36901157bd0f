#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/derivation/batch/column_evaluator.h"
#include "engine/derivation/batch/column_plan.h"
#include "engine/derivation/batch/fixed_blocks.h"
#include "engine/derivation/matching/context_matcher.h"
#include "engine/derivation/matching/production_plan.h"
#include "engine/derivation/state/module_finder.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The modules that take the place of a module, without the values of their parameters.
struct BatchBlock {
  std::array<core::ModuleTypeId, TypePlan::kInlineTypes> types{};  // the modules, when they fit in here
  std::uint32_t length = 0;                                        // modules
  std::uint32_t valueCount = 0;                                    // parameters
  std::uint32_t readModules = 1;                                   // of the old string whose place it takes
  std::uint32_t readParameters = 0;                                // of these modules
  std::int32_t moduleGrowth = 0;                                   // new modules minus old modules
  std::int32_t parameterGrowth = 0;                                // the same for parameters
  const core::ModuleTypeId* allTypes = nullptr;                    // (length), in the BatchPlan
  bool isResizing = false;  // the size changes, so the modules behind the block move
};

/// A production without effects on other modules, compiled for batches.
struct BatchRule {
  enum class Context : std::uint8_t {
    None,
    Near,      // at most one module on each side, found in a few moves
    Searched,  // all others, and predecessors of several modules: element by element
  };
  const language::Production* production = nullptr;  // in the Program
  Context context = Context::None;
  core::ModuleTypeId left = core::kNoModuleType;   // Near: type of the left neighbour, or kNoModuleType: any or none
  core::ModuleTypeId right = core::kNoModuleType;  // Near: the same on the right
  std::vector<SlotSource> slots;                   // by formal parameter (Production::slotCount)
  std::vector<std::uint32_t> statics;              // by local variable: in PlantState::statics
  ColumnCode before;                               // the block before the condition
  std::optional<ColumnCode> condition;
  ColumnCode weight;  // 1 when there is none
  ColumnCode behind;  // the block behind the condition
  std::vector<ColumnCode> values;
  std::vector<std::uint32_t> kept;  // columns that `before` assigns and the weight, `behind` or the values read
  std::uint32_t block = 0;          // in BatchPlan::blocks
  bool changesParts = false;        // the block is one module of the same size, but of another type
  bool needsLanes = false;          // it has values or a block behind the condition, or changes parts
  bool drawsRandom = false;         // any of this code draws
  bool drawsAgain = false;          // `before` or the condition draws, and `before` does something
  bool hasBefore = false;           // `before` does something
  bool hasBehind = false;           // `behind` does something
  bool keepsPlaces = false;         // Searched: a later rule of the group has the same contexts
  bool sharesPlaces = false;        // Searched: an earlier rule has searched, and found the same places
  std::uint8_t mark = 0;            // bit of a site (ModuleFinder) where the nearest modules allow the rule
  bool startsLeft = false;          // Searched: the group looks left, and the search goes on behind that module
  bool startsRight = false;         // Searched: the same on the right
};

/// The productions of one module type.
struct BatchGroup {
  std::uint32_t firstRule = 0;  // in BatchPlan::rules
  std::uint32_t ruleCount = 0;
  bool isWeighted = false;    // one is chosen by weight, else the first that matches
  bool looksLeft = false;     // the nearest module on the left is found for all rules at once
  bool looksRight = false;    // and on the right
  bool keepsModules = false;  // with its place in the string, because a rule has startsLeft or startsRight
  bool isLight = false;       // the PlainScan is faster: a quick condition, another size, constant parameters
  bool hasThresholds = false;
  /// When only constant weights decide: rule k is chosen when exactly k thresholds are greater than the module's draw
  /// word (ruleCount - 1).
  std::vector<std::uint64_t> thresholds;
};

/// The ways in which a batch rewrites the module types. A table over the Program and the SystemTables' rules, which
/// must outlive it.
class BatchPlan {
 public:
  enum class Class : std::uint8_t {
    Kept,     // no production: the module stands for itself
    Fixed,    // always the same block, without parameters
    Cut,      // `%`: the rest of its branch goes with it
    Group,    // a BatchGroup decides
    General,  // a batch cannot do it: it ends before such a module
  };
  /// The most module types for which there are tables of pairs of neighbours.
  static constexpr std::size_t kMaximumPairTypes = 512;

  /// The plan of the productions. `decomposition` is that of the decomposition (null: the ModuleRewriter decomposes);
  /// the plan only notes that there is one.
  BatchPlan(const language::Program& program, const language::LSystem& system, const ContextRules& rules,
            const ProductionPlan& plan, const BatchPlan* decomposition);
  /// The plan of the decomposition. Nothing when there is none, or when batches cannot do all of it: they decompose
  /// level by level, so a production must depend on its one module alone.
  [[nodiscard]] static std::optional<BatchPlan> ofDecomposition(const language::Program& program,
                                                                const language::LSystem& system,
                                                                const ContextRules& rules, const ProductionPlan& plan);

  /// Whether batches gain anything: they can do some productions that need more than copying.
  [[nodiscard]] bool isUseful() const { return !groups_.empty() || decomposes_; }
  /// Whether batches decompose what the productions make.
  [[nodiscard]] bool decomposes() const { return decomposes_; }
  /// Whether batches can do every module.
  [[nodiscard]] bool isComplete() const { return isComplete_; }
  /// Whether batches can also do the parts of a string on their own, and know the sizes of their results before they
  /// write: no predecessor reaches from one into the next, and nothing is cut or decomposed.
  [[nodiscard]] bool isChunkable() const { return isComplete_ && !hasLongPredecessors_ && !decomposes_ && !hasCuts_; }
  /// Whether every module becomes a fixed block or stays.
  [[nodiscard]] bool isFixedOnly() const { return isComplete_ && groups_.empty() && !decomposes_ && !hasCuts_; }
  /// Whether the PlainScan can do everything that batches can do without calling the Rewriter.
  [[nodiscard]] bool isQuick() const { return isQuick_; }
  /// Whether it can also do all of it without the Evaluator and draws, so that short strings gain nothing from batches.
  [[nodiscard]] bool isCheap() const { return isCheap_; }
  /// Has a table in some models where isFixedOnly.
  [[nodiscard]] const FixedBlocks& fixedBlocks() const { return fixedBlocks_; }

  [[nodiscard]] Class classOf(core::ModuleTypeId type) const { return classes_[type]; }
  /// Group: in groups; Fixed: the block.
  [[nodiscard]] std::uint32_t indexOf(core::ModuleTypeId type) const { return indices_[type]; }
  [[nodiscard]] const std::vector<BatchGroup>& groups() const { return groups_; }
  [[nodiscard]] const std::vector<BatchRule>& rules() const { return rules_; }
  /// [0] is for modules that stand for themselves.
  [[nodiscard]] const std::vector<BatchBlock>& blocks() const { return blocks_; }
  [[nodiscard]] bool hasOneKindOnly() const { return hasOneKindOnly_; }
  /// Whether a predecessor has several modules, so that sites may overlap.
  [[nodiscard]] bool hasLongPredecessors() const { return hasLongPredecessors_; }
  /// Whether the string may have a Cut.
  [[nodiscard]] bool hasCuts() const { return hasCuts_; }
  /// Whether a rule has blocks.
  [[nodiscard]] bool hasBlocks() const { return hasBlocks_; }
  /// Whether a rule draws.
  [[nodiscard]] bool drawsRandom() const { return drawsRandom_; }
  /// Why the type is General, as the end of a sentence; empty for others.
  [[nodiscard]] const char* problemOf(core::ModuleTypeId type) const { return problems_[type]; }

  /// The candidates that may apply to a module of this type, as bits; the eighth bit stands for all further candidates.
  /// 0: the module stays as it is.
  [[nodiscard]] const std::uint8_t* candidateBits() const { return candidateBits_.data(); }
  /// The same by the module before, or behind, as well: at [before * pairStride + type] and [type * pairStride +
  /// behind]. The type number moduleTypeCount stands for the ends of the string.
  [[nodiscard]] const std::uint8_t* leftBits() const { return leftBits_.data(); }
  [[nodiscard]] const std::uint8_t* rightBits() const { return rightBits_.data(); }
  [[nodiscard]] std::size_t pairStride() const { return pairStride_; }
  /// Whether the two tables exist and say more than candidateBits.
  [[nodiscard]] bool hasPairs() const { return hasPairs_; }

  /// The marks that find the modules that may change: at least those with a bit in the tables above. The bits differ.
  [[nodiscard]] const ModuleFinder::Marks& siteMarks() const { return siteMarks_; }
  /// Whether the tables above rule out more modules than the marks. Then their bits take the place of the marks.
  [[nodiscard]] bool needsPairBits() const { return needsPairBits_; }

  [[nodiscard]] std::size_t largestSlotCount() const { return largestSlotCount_; }
  [[nodiscard]] std::size_t largestColumnCount() const { return largestColumnCount_; }
  [[nodiscard]] std::size_t largestKeptCount() const { return largestKeptCount_; }
  [[nodiscard]] std::size_t largestRuleCount() const { return largestRuleCount_; }

 private:
  BatchPlan(const language::Program& program, const language::LSystem& system, const ContextRules& rules,
            const ProductionPlan& plan, const language::ProductionList& list, bool isDecomposition, bool decomposes);
  void planType(const language::Program& program, const language::LSystem& system, const ContextRules& rules,
                const ProductionPlan& plan, core::ModuleTypeId type);
  bool planGroup(const language::Program& program, const language::LSystem& system, const ContextRules& rules,
                 const ProductionPlan& plan, core::ModuleTypeId type);
  bool compile(const language::Program& program, const language::LSystem& system,
               const language::Production& production, BatchRule& rule);
  [[nodiscard]] bool isLeftToDecomposition(const language::LSystem& system, core::ModuleTypeId type) const {
    return !isDecomposition_ && !decomposes_ && system.decomposition.mayApplyTo(type);
  }
  void bindSlots(const language::Program& program, const ContextRules& rules, BatchRule& rule) const;
  void addRule(const language::Program& program, BatchRule rule);
  void addBlock(const std::vector<core::ModuleTypeId>& types, std::uint32_t valueCount, std::uint32_t readModules,
                std::uint32_t readParameters);
  void sharePlaces(const BatchGroup& group);
  void startNear(BatchGroup& group);
  void findThresholds(BatchGroup& group) const;
  [[nodiscard]] bool isLight(const ProductionPlan& plan, const TypePlan& typePlan) const;
  void makePairs(const language::Program& program, const ContextRules& rules);
  void makeSiteMarks(const language::Program& program, const ContextRules& rules);

  std::vector<Class> classes_;          // by module type
  std::vector<std::uint32_t> indices_;  // by module type
  std::vector<BatchGroup> groups_;
  std::vector<BatchRule> rules_;
  std::vector<BatchBlock> blocks_;
  std::vector<std::vector<core::ModuleTypeId>> blockTypes_;  // by block
  FixedBlocks fixedBlocks_;
  bool isComplete_ = true;
  bool isQuick_ = true;
  bool isCheap_ = true;
  bool hasOneKindOnly_ = false;  // one group and nothing Fixed or General: every site belongs to the group
  std::vector<std::uint8_t> candidateBits_;
  std::vector<std::uint8_t> leftBits_;
  std::vector<std::uint8_t> rightBits_;
  std::size_t pairStride_ = 0;
  bool hasPairs_ = false;
  ModuleFinder::Marks siteMarks_;
  bool needsPairBits_ = false;
  std::size_t largestSlotCount_ = 0;
  std::size_t largestColumnCount_ = 0;
  std::size_t largestRuleCount_ = 0;
  std::size_t largestKeptCount_ = 0;
  const language::ProductionList* list_;  // in the Program
  bool isDecomposition_ = false;          // it is the list of the decomposition
  bool isWeighted_ = false;
  bool decomposes_ = false;
  bool hasLongPredecessors_ = false;
  bool hasBlocks_ = false;
  bool drawsRandom_ = false;
  bool hasCuts_ = false;
  std::vector<const char*> problems_;  // by module type
  const char* problem_ = "";           // of the last production that compile refused
};

}  // namespace espalier::derivation
