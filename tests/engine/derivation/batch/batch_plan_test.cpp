#include "engine/derivation/batch/batch_plan.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "engine/derivation/plan_text.h"
#include "engine/derivation/system_tables.h"
#include "tests/support/derived_model.h"

namespace espalier::batch_plan_test {
namespace {

using derivation::BatchPlan;
using derivation::BatchRule;
using derivation::SystemTables;
using test::DerivedModel;
using test::modelText;

/// A model and the plan of its L-system.
struct Planned {
  explicit Planned(const std::string& items, const std::string& productions)
      : model(modelText(items, "AB(1)C(1)%", productions)), tables(model.program(), 0) {}
  [[nodiscard]] const BatchPlan& plan() const { return tables.batches; }
  [[nodiscard]] BatchPlan::Class classOf(const std::string& name, std::uint16_t arity) const {
    return plan().classOf(model.program().findType(name, arity));
  }
  [[nodiscard]] core::ModuleTypeId type(const std::string& name, std::uint16_t arity) const {
    return model.program().findType(name, arity);
  }
  DerivedModel model;
  SystemTables tables;
};

TEST(BatchPlan, PureProductionsOfOneModuleMakeGroups) {
  EXPECT_EQ(Planned("", "B(x) --> B(x+1)\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "A < B(x) > C(y) : x>y && sqrt(x)<2 --> B(x+1)\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "B(x) --> B(x != 0 && 1/x > 2 ? x : 3)\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "B(x) --> B(ran(x))C(1-ran(2))\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "B(x) --> B(x>1 ? nran(x,1) : 0)C(bran(1,x))\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "B(x) : ran(x)>1 --> B(2)\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "B(x) : {n=ran(1);} n>0.5 {m=nran(n,1);} --> B(m)\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("Seed: 1\n", "A --> x : 1\nA --> y : 2\n").classOf("A", 0), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("Seed: 1\n", "A : {n=ran(1);} n>0.5 --> B(n) : ran(2)\nA --> y : 2\n").classOf("A", 0),
            BatchPlan::Class::Group);
}

TEST(BatchPlan, BlocksDecompositionAndLongPredecessorsMakeGroups) {
  EXPECT_EQ(Planned("", "B(x) : {n=x;} * --> A\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "B(x) : {x=x+1;} x<3 {x=x*2;} --> B(x)\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "B(x) : {if (x>2) {x=1;}} * --> B(x)\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("Start: {n=0;}\n", "B(x) : x<n --> A\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "A --> B(1)\ndecomposition\nB(x) --> A\n").classOf("A", 0), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "A --> B(1)\ndecomposition\nB(x) : {n=x;} 1 --> A\n").classOf("A", 0), BatchPlan::Class::Group);
  const Planned planned("", "AB(x) --> A\n");
  EXPECT_EQ(planned.classOf("A", 0), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "AB(x) --> A\nB(x) : {n=x;} * --> A\n").classOf("B", 1), BatchPlan::Class::Group);
  EXPECT_EQ(Planned("", "AB(x) : {n=x;} * --> A\n").classOf("A", 0), BatchPlan::Class::Group);
  EXPECT_TRUE(planned.plan().hasLongPredecessors());
  EXPECT_FALSE(planned.plan().isChunkable());
}

TEST(BatchPlan, ModulesThatStayAndFixedBlocksAreNoGroups) {
  const Planned planned("", "A --> AA\n");
  EXPECT_EQ(planned.classOf("A", 0), BatchPlan::Class::Fixed);
  EXPECT_EQ(planned.classOf("B", 1), BatchPlan::Class::Kept);
  EXPECT_FALSE(planned.plan().isUseful());
}

TEST(BatchPlan, WhatHasSideEffectsOrReachesFurtherIsGeneral) {
  EXPECT_EQ(Planned("", "B(x) : {n=n+x;} * --> A\n").classOf("B", 1), BatchPlan::Class::General);
  EXPECT_EQ(Planned("Start: {n=0;}\n", "B(x) : {n=n+x;} * --> A\n").classOf("B", 1), BatchPlan::Class::General);
  EXPECT_EQ(Planned("", "B(x) --> B(biran(x,0.5))\n").classOf("B", 1), BatchPlan::Class::General);
  EXPECT_EQ(Planned("", "A << B(x) --> A\n").classOf("B", 1), BatchPlan::Class::General);
  EXPECT_EQ(Planned("", "A --> B(1)\ndecomposition\nA < B(x) --> A\n").classOf("A", 0), BatchPlan::Class::General);
  // a predecessor of several modules may take the cut symbol with it, decomposition may replace it
  EXPECT_EQ(Planned("", "AB(x) --> A\n").classOf("%", 0), BatchPlan::Class::General);
  EXPECT_EQ(Planned("", "A --> x\ndecomposition\n% --> A\n").classOf("%", 0), BatchPlan::Class::General);
  EXPECT_FALSE(Planned("", "AB(x) --> A\n").plan().isComplete());
}

TEST(BatchPlan, CodeAndChoicesByWeightAreWorthBatchesSooner) {
  EXPECT_TRUE(Planned("", "B(x) : x<3 --> B(x+1)\n").plan().isCheap());
  EXPECT_TRUE(Planned("Seed: 1\n", "B(x) --> B(x+1) : 1\n").plan().isCheap());
  EXPECT_FALSE(Planned("Seed: 1\n", "B(x) --> B(x+1) : 1\nB(x) --> A : 2\n").plan().isCheap());
  EXPECT_FALSE(Planned("", "B(x) : x*x+1<3 --> B(x+1)\n").plan().isCheap());
}

TEST(BatchPlan, CutsBelongToBatchesOfOneThread) {
  const Planned planned("", "A --> x\n");
  EXPECT_EQ(planned.classOf("%", 0), BatchPlan::Class::Cut);
  EXPECT_TRUE(planned.plan().isComplete());
  EXPECT_FALSE(planned.plan().isFixedOnly());
  EXPECT_FALSE(planned.plan().isChunkable());
}

TEST(BatchPlan, RulesWithTheSameContextsShareWhatTheFirstFinds) {
  const auto sharing = [](const std::string& items, const std::string& productions) {
    const Planned planned(items, productions);
    std::string text;
    for (const BatchRule& rule : planned.plan().rules()) {
      text += rule.keepsPlaces ? 'k' : rule.sharesPlaces ? 's' : '-';
    }
    return text;
  };
  const std::string same = "A B(x) < C(y) : x>y --> A\nA B(u) < C(v) : u<v --> B(u)\n";
  EXPECT_EQ(sharing("", same + "A < C(y) --> B(y)\nA B(x) < C(y) --> A\n"), "ks-s");
  EXPECT_EQ(sharing("", same + "A C(x) < C(y) : x>2 --> A\nA B(x) < C(y) --> A\n"), "ks--");
  EXPECT_EQ(sharing("", "C(y) > [A=]B(x) : x>1 --> A\nC(y) > [A=]B(x) : x<1 --> B(x)\n"), "ks");
  EXPECT_EQ(sharing("", "C(y) > [A=]B(x) : x>1 --> A\nC(y) > [A]B(x) : x<1 --> B(x)\n"), "--");
  EXPECT_EQ(sharing("", "C(y)A > A A : y>1 --> A\nC(y)B(x) > A A : x<1 --> B(x)\n"), "--");
  // the choice by weight searches again
  EXPECT_EQ(sharing("Seed: 1\n", "A A < C(y) --> A : 1\nA A < C(y) --> B(y) : 2\n"), "--");
}

TEST(BatchPlan, RulesThatBeginAtTheSameNeighbourFindItOnce) {
  const auto starts = [](const std::string& items, const std::string& productions) {
    const Planned planned(items, productions);
    std::string text;
    for (const BatchRule& rule : planned.plan().rules()) {
      text += rule.startsLeft ? (rule.startsRight ? 'b' : 'l') : rule.startsRight ? 'r' : '-';
    }
    const auto& group = planned.plan().groups().front();
    return text + (group.looksLeft ? " left" : "") + (group.looksRight ? " right" : "") +
           (group.keepsModules ? " kept" : "");
  };
  const std::string first = "A B(x) < C(y) : x>y --> A\n";
  EXPECT_EQ(starts("", first), "-");
  EXPECT_EQ(starts("", first + "B(x)A < C(y) --> B(x)\n"), "ll left kept");
  EXPECT_EQ(starts("", first + "A < C(y) --> B(y)\n"), "l- left kept");
  EXPECT_EQ(starts("", first + "B(x)A < C(y) > A A : x>0 --> A\nC(y) > B(x) --> A\n"), "lb- left right kept");
  EXPECT_EQ(starts("", first + "B(x)A < C(y) > [A=]A --> A\n"), "ll left kept");
  // the second takes what the first has found, so the neighbour is needed once
  EXPECT_EQ(starts("", first + "A B(u) < C(v) : u<v --> B(u)\n"), "--");
  // only predecessors of one module have a nearest neighbour, and a ring has no first one
  EXPECT_EQ(starts("", "C(y)A > A A : y>1 --> A\nC(y)B(x) > B(x) A : x<1 --> B(x)\n"), "--");
  EXPECT_EQ(starts("Ring Lsystem\n", first + "B(x)A < C(y) --> B(x)\n"), "--");
}

TEST(BatchPlan, TheTextOfThePlanSaysHowNeighboursAreFound) {
  const Planned planned("", "A B(x) < C(y) : x>y --> A\nA B(u) < C(v) : u<v --> B(u)\n");
  EXPECT_EQ(
      derivation::planText(planned.model.program()),
      "L-system 1\nproduction 0: A B(x) < C(y) : x>y --> A\n"
      "  in batches; its neighbours are searched for all modules at once, one element of the context after the other\n"
      "production 1: A B(u) < C(v) : u<v --> B(u)\n"
      "  in batches; a production before it has found the same neighbours\n");
}

TEST(BatchPlan, PairsOfNeighboursRuleOutProductions) {
  const Planned planned("ignore: +\n", "A < B(x) --> A\nB(x) > C(y) --> +\n");
  const BatchPlan& plan = planned.plan();
  ASSERT_TRUE(plan.hasPairs());
  const core::ModuleTypeId a = planned.type("A", 0);
  const core::ModuleTypeId b = planned.type("B", 1);
  const core::ModuleTypeId c = planned.type("C", 1);
  const core::ModuleTypeId plus = planned.type("+", 0);
  const std::size_t stride = plan.pairStride();
  // the first production is bit 0 and needs A, the second is bit 1 and looks at nothing on the left
  EXPECT_EQ(plan.leftBits()[a * stride + b], 3);
  EXPECT_EQ(plan.leftBits()[c * stride + b], 2);
  EXPECT_EQ(plan.rightBits()[b * stride + c], 3);
  EXPECT_EQ(plan.rightBits()[b * stride + a], 1);
  // an ignored module, a branch and the string's ends say nothing
  EXPECT_EQ(plan.leftBits()[plus * stride + b], 3);
  EXPECT_EQ(plan.leftBits()[planned.model.program().closeBranch * stride + b], 3);
  EXPECT_EQ(plan.rightBits()[b * stride + planned.model.program().openBranch], 3);
  EXPECT_EQ(plan.rightBits()[b * stride + planned.model.program().moduleTypeCount()], 3);
  EXPECT_EQ(plan.rightBits()[b * stride + planned.model.program().closeBranch], 1);
  // modules without productions stay, whatever stands beside them
  EXPECT_EQ(plan.leftBits()[plus * stride + a], 0);
}

TEST(BatchPlan, OneModuleContextsAreNearAndOthersSearched) {
  const auto contextOf = [](const std::string& items, const std::string& productions) {
    return Planned(items, productions).plan().rules()[0].context;
  };
  EXPECT_EQ(contextOf("", "B(x) --> B(x+1)\n"), BatchRule::Context::None);
  EXPECT_EQ(contextOf("", "A < B(x) > C(y) --> A\n"), BatchRule::Context::Near);
  EXPECT_EQ(contextOf("", "B(x) > ] --> A\n"), BatchRule::Context::Near);
  EXPECT_EQ(contextOf("", "A A < B(x) --> A\n"), BatchRule::Context::Searched);
  EXPECT_EQ(contextOf("", "B(x) > [A --> A\n"), BatchRule::Context::Searched);
  EXPECT_EQ(contextOf("Ring Lsystem\n", "A < B(x) --> A\n"), BatchRule::Context::Searched);
}

TEST(BatchPlan, ThresholdsChooseAsTheWeightsDo) {
  for (const std::vector<std::string>& weights : std::vector<std::vector<std::string>>{{"1", "1", "1"},
                                                                                       {"0.1", "0.2", "0.3", "0.4"},
                                                                                       {"0", "5", "0"},
                                                                                       {"0", "0"},
                                                                                       {"1.0e-300", "1"},
                                                                                       {"3", "1.0e-12"}}) {
    std::string productions;
    std::vector<double> numbers;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      productions += "A --> " + std::string(1, static_cast<char>('a' + i)) + " : " + weights[i] + "\n";
      numbers.push_back(std::stod(weights[i]));
    }
    const Planned planned("Seed: 1\n", productions);
    const derivation::BatchGroup& group = planned.plan().groups().at(0);
    ASSERT_TRUE(group.hasThresholds);
    ASSERT_EQ(group.thresholds.size(), weights.size() - 1);
    const auto chosen = [&group](std::uint64_t word) {
      std::size_t count = 0;
      for (const std::uint64_t threshold : group.thresholds) {
        count += word < threshold ? 1U : 0U;
      }
      return count;
    };
    // around each threshold, and the ends
    std::vector<std::uint64_t> words{0, 1, 0x7FFFFFFF, 0xFFFFFFFE, 0xFFFFFFFF};
    for (const std::uint64_t threshold : group.thresholds) {
      for (std::uint64_t word = threshold < 2 ? 0 : threshold - 2; word < threshold + 2 && word < (1ULL << 32U);
           ++word) {
        words.push_back(word);
      }
    }
    for (const std::uint64_t word : words) {
      EXPECT_EQ(chosen(word), derivation::chooseByWeight(numbers, 1.0 - static_cast<double>(word) * 0x1.0p-32, false))
          << weights[0] << " " << word;
    }
  }
}

TEST(BatchPlan, WeightsThatDependOnParametersHaveNoThresholds) {
  const Planned planned("Seed: 1\n", "B(x) --> A : x\nB(x) --> C(x) : 1\n");
  EXPECT_FALSE(planned.plan().groups().at(0).hasThresholds);
}

}  // namespace
}  // namespace espalier::batch_plan_test
