#include "engine/derivation/matching/production_plan.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/support/derived_model.h"

namespace espalier::production_plan_test {
namespace {

using derivation::chooseByWeight;
using derivation::ProductionPlan;
using derivation::TypePlan;
using test::DerivedModel;
using test::modelText;

TypePlan::Kind kindOf(const std::string& items, const std::string& rest, const std::string& symbol,
                      std::uint16_t arity) {
  DerivedModel model(modelText(items, "AB(1)C(1)%", rest));
  const ProductionPlan plan(model.program(), model.program().systems[0]);
  return plan[model.program().findType(symbol, arity)].kind;
}

TEST(ProductionPlan, PlainModulesAndPlainProductionsAreFixed) {
  EXPECT_EQ(kindOf("", "A --> AxA\n", "A", 0), TypePlan::Kind::Fixed);
  EXPECT_EQ(kindOf("", "A --> AxA\n", "B", 1), TypePlan::Kind::Fixed);
  EXPECT_EQ(kindOf("", "B(x) --> A\n", "B", 1), TypePlan::Kind::Fixed);
}

TEST(ProductionPlan, ParametersAndConditionsMakeRules) {
  EXPECT_EQ(kindOf("", "B(x) --> B(x+1)\n", "B", 1), TypePlan::Kind::Rules);
  EXPECT_EQ(kindOf("", "B(x) : x>1 --> A\n", "B", 1), TypePlan::Kind::Rules);
  EXPECT_EQ(kindOf("Seed: 1\n", "A --> x : 1\nA --> y : 2\n", "A", 0), TypePlan::Kind::Weights);
}

TEST(ProductionPlan, RulesMayHaveBlocks) {
  EXPECT_EQ(kindOf("", "B(x) : {n=x;} * --> A\n", "B", 1), TypePlan::Kind::BlocksOrContexts);
  EXPECT_EQ(kindOf("", "B(x) : 1 {x=1;} --> A\n", "B", 1), TypePlan::Kind::BlocksOrContexts);
  EXPECT_EQ(kindOf("Start: {n=0;}\n", "A : 1 {n=n+1;} --> A\n", "A", 0), TypePlan::Kind::BlocksOrContexts);
  EXPECT_EQ(kindOf("Seed: 1\n", "A : {n=1;} n>0 --> x : 1\nA --> y : 2\n", "A", 0), TypePlan::Kind::BlocksOrContexts);
}

TEST(ProductionPlan, RulesMayHaveContextsWhereNoWeightDecides) {
  EXPECT_EQ(kindOf("", "A < B(x) --> A\n", "B", 1), TypePlan::Kind::BlocksOrContexts);
  EXPECT_EQ(kindOf("", "A(y) < B(x) > C : {n=x;} y>n --> A\nB(x) --> C\n", "B", 1), TypePlan::Kind::BlocksOrContexts);
  EXPECT_EQ(kindOf("Seed: 1\n", "A < B(x) --> A : 1\nB(x) --> C : 2\n", "B", 1), TypePlan::Kind::General);
  EXPECT_EQ(kindOf("", "A << B(x) --> A\n", "B", 1), TypePlan::Kind::General);
}

TEST(ProductionPlan, EverythingElseIsGeneral) {
  EXPECT_EQ(kindOf("", "AB(x) --> A\n", "A", 0), TypePlan::Kind::General);
  // the candidates of a module share its formal parameters
  EXPECT_EQ(kindOf("", "B(x) : {x=1;} x>0 --> A\n", "B", 1), TypePlan::Kind::General);
  EXPECT_EQ(kindOf("", "A --> B(1)\ndecomposition\nB(x) --> A\n", "A", 0), TypePlan::Kind::General);
  EXPECT_EQ(kindOf("", "A --> x\ndecomposition\nB(x) --> A\n", "B", 1), TypePlan::Kind::General);
  EXPECT_EQ(kindOf("", "A --> x\n", "%", 0), TypePlan::Kind::General);
}

TEST(ProductionPlan, AProductionWithoutConditionHidesLaterOnes) {
  DerivedModel model(modelText("", "A", "A --> x\nB < A --> y\nA : Q>1 --> z\n"));
  const ProductionPlan plan(model.program(), model.program().systems[0]);
  EXPECT_EQ(plan[model.program().findType("A", 0)].kind, TypePlan::Kind::Fixed);
  // one with a context applies only where it matches
  DerivedModel context(modelText("", "A", "B < A --> y\nA --> x\n"));
  const ProductionPlan contextPlan(context.program(), context.program().systems[0]);
  const TypePlan& contextType = contextPlan[context.program().findType("A", 0)];
  EXPECT_EQ(contextType.kind, TypePlan::Kind::BlocksOrContexts);
  EXPECT_EQ(contextType.ruleCount, 2U);
}

TEST(ProductionPlan, WeightsAreWalkedInOrder) {
  const std::array<double, 3> weights{1.0, 2.0, 5.0};
  // espalier's own draws are in (0, 1]: 1/8 and 3/8 are the last of their part
  EXPECT_EQ(chooseByWeight(weights, 0x1.0p-32, false), 0U);
  EXPECT_EQ(chooseByWeight(weights, 0.125, false), 0U);
  EXPECT_EQ(chooseByWeight(weights, 0.126, false), 1U);
  EXPECT_EQ(chooseByWeight(weights, 0.375, false), 1U);
  EXPECT_EQ(chooseByWeight(weights, 0.376, false), 2U);
  EXPECT_EQ(chooseByWeight(weights, 1.0, false), 2U);
}

TEST(ProductionPlan, ZeroWeightsAreNeverChosenBesideOthers) {
  const std::array<double, 3> weights{0.0, 1.0, 0.0};
  for (const double draw : {0x1.0p-32, 0.5, 1.0}) {
    EXPECT_EQ(chooseByWeight(weights, draw, false), 1U);
  }
  const std::array<double, 2> zeros{0.0, 0.0};
  EXPECT_EQ(chooseByWeight(zeros, 0.7, false), 0U);
  EXPECT_EQ(chooseByWeight(zeros, 0.7, true), 0U);
}

TEST(ProductionPlan, ReferenceSumsInFloats) {
  // 16777216 + 1 is 16777216 as a 32-bit float, so the last weight has no chance
  const std::array<double, 2> weights{16777216.0, 1.0};
  EXPECT_EQ(chooseByWeight(weights, 0.99999999999, true), 0U);
  EXPECT_EQ(chooseByWeight(weights, 1.0, false), 1U);
}

}  // namespace
}  // namespace espalier::production_plan_test
