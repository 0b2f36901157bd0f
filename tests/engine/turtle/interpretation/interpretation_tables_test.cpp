#include "engine/turtle/interpretation/interpretation_tables.h"

#include "tests/engine/turtle/turtle_fixture.h"

namespace espalier::turtle::interpretation_tables_test {
namespace {

InterpretationTables tablesOf(const std::string& text) {
  return InterpretationTables(TurtleRun(text).program);
}

TEST(InterpretationTables, ModulesWithoutEffectAreSkippedUnlessTheyHaveAnImage) {
  TurtleRun run("AF[]");
  const auto skips = [&](const char* name) {
    return InterpretationTables(run.program).isSkipped[run.program.findType(name, 0)] != 0;
  };
  EXPECT_TRUE(skips("A"));
  EXPECT_FALSE(skips("F"));
  EXPECT_FALSE(skips("["));
  language::Production production;
  production.predecessor.emplace_back();
  production.predecessor.front().type = run.program.findType("A", 0);
  run.program.systems.front().homomorphism.productions.push_back(std::move(production));
  EXPECT_FALSE(skips("A"));
  EXPECT_FALSE(InterpretationTables(run.program).hasIndependentBranches);
}

TEST(InterpretationTables, BranchesAreIndependentWithoutScaledCalls) {
  EXPECT_TRUE(tablesOf("F[+F]?E(1)@O(1)").hasIndependentBranches);
  EXPECT_FALSE(tablesOf("F[+F]?(1,2)F$").hasIndependentBranches);
  EXPECT_FALSE(tablesOf("F[+F$]").hasIndependentBranches);
}

TEST(InterpretationTables, BranchesAreDrawnApartUnlessAPatchIsThere) {
  EXPECT_TRUE(tablesOf("F[+F{F.}%]@O(1)~l@M(1,2)@GsF@Ge").mayDrawApart);
  EXPECT_FALSE(tablesOf("F[@PS(1)@PD(1)]").mayDrawApart);
  EXPECT_FALSE(tablesOf("F[+F$]").mayDrawApart);
}

TEST(InterpretationTables, CutsAreKnown) {
  EXPECT_FALSE(tablesOf("F@O(1)").hasCut);
  EXPECT_TRUE(tablesOf("F[%F]").hasCut);
  EXPECT_TRUE(tablesOf("F@mc(1)").hasCut);
}

}  // namespace
}  // namespace espalier::turtle::interpretation_tables_test
