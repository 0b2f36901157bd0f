#include <gtest/gtest.h>

#include "tests/support/derived_model.h"

namespace espalier::sub_system_scan_test {
namespace {

using core::SimulationErrorCode;
using test::derive;
using test::DerivedModel;

/// A main L-system 1 and one more.
std::string two(const std::string& mainItems, const std::string& axiom, const std::string& productions,
                const std::string& second) {
  return "Lsystem: 1\nderivation length: 100\n" + mainItems + "Axiom: " + axiom + "\n" + productions + "endlsystem\n" +
         second;
}

TEST(SubSystems, RewritesTheModulesOfACallByItsProductions) {
  EXPECT_EQ(derive(two("", "J?(2)JK$J", "J --> JI\n", "Lsystem: 2\nAxiom: X\nJ --> KJ\nK --> L\nendlsystem\n"), 2),
            "JII?(2)LKJL$JII");
}

TEST(SubSystems, EachCallHasVariablesOfItsOwn) {
  DerivedModel model(two("", "?(2)J$?(2)JJ$", "x --> x\n",
                         "Lsystem: 2\nStart: {n=10;}\nStartEach: {n=n+0.5;}\nEndEach: {n=n*2;}\nAxiom: X\n"
                         "J : {n=n+1;} * --> J(n)J\nendlsystem\n"));
  EXPECT_EQ(model.state().instances.size(), 3U);
  EXPECT_FALSE(model.state().instances[1].hasStarted);
  EXPECT_EQ(model.steps(1), "?(2)J(11.5)J$?(2)J(11.5)JJ(12.5)J$");
  EXPECT_TRUE(model.state().instances[1].hasStarted);
}

TEST(SubSystems, InstancesFollowTheCallsOfTheString) {
  DerivedModel model(two("", "B(0)", "B(n) --> ?(5)L$[B(n+1)]\n",
                         "Lsystem: 5\nStart: {n=0;}\nAxiom: X\nL : {n=n+1;} * --> l(n)L\nendlsystem\n"));
  EXPECT_EQ(model.steps(3), "?(5)l(1)l(2)L$[?(5)l(1)L$[?(5)L$[B(3)]]]");
  ASSERT_EQ(model.state().instances.size(), 4U);
  EXPECT_TRUE(model.state().instances[2].hasStarted);
  EXPECT_FALSE(model.state().instances[3].hasStarted);
}

TEST(SubSystems, CutStopsAtTheEndOfTheCallAndEndsCallsInside) {
  const std::string second =
      "Lsystem: 4\nAxiom: X\nJ --> j%\nendlsystem\n"
      "Lsystem: 6\nEnd: {printf(\"end of 6 \");}\nAxiom: X\nW --> WW\nendlsystem\n";
  DerivedModel model(two("", "A?(4)JK[?(6)W$]L$B", "B --> BB\n", second));
  EXPECT_EQ(model.state().instances.size(), 3U);
  EXPECT_EQ(model.steps(1), "A?(4)j%K[?(6)WW$]L$BB");
  EXPECT_EQ(model.steps(1), "A?(4)j$BBBB");
  EXPECT_EQ(model.printed(), "end of 6 ");
  EXPECT_EQ(model.state().instances.size(), 2U);
}

TEST(SubSystems, LastStepEndsEveryCallInnerOnesFirst) {
  DerivedModel model(
      "Lsystem: 1\nderivation length: 1\nEnd: {printf(\"1\");}\nAxiom: ?(2)A?(3)A$$\nx --> x\nendlsystem\n"
      "Lsystem: 2\nEnd: {printf(\"2\");}\nAxiom: X\nx --> x\nendlsystem\n"
      "Lsystem: 3\nEnd: {printf(\"3\");}\nAxiom: X\nx --> x\nendlsystem\n");
  model.steps(1);
  EXPECT_EQ(model.printed(), "321");
}

TEST(SubSystems, ExternalVariablesAreTheCallers) {
  EXPECT_EQ(derive(two("Start: {n=100; m=1;}\n", "J?(2)K$J", "J : {n=n+1;} * --> J(n)J\n",
                       "Lsystem: 2\nDefine: { external n; }\nStart: {m=7;}\nAxiom: X\n"
                       "K : {n=n+10; m=m+1;} * --> K(n,m)K\nendlsystem\n"),
                   2),
            "J(101)J(113)J?(2)K(111,8)K(123,9)K$J(112)J(124)J");
}

TEST(SubSystems, WarnsOnceAboutAnExternalVariableThatNoCallerHas) {
  DerivedModel model(
      two("", "?(2)K$?(2)K$", "x --> x\n", "Lsystem: 2\nDefine: { external n; }\nAxiom: X\nK --> K(n)\nendlsystem\n"));
  EXPECT_EQ(model.steps(1), "?(2)K(0)$?(2)K(0)$");
  ASSERT_EQ(model.warnings().size(), 1U);
  EXPECT_NE(model.warnings()[0].find("no caller of L-system 2 has a variable 'n'; the external variable is its own"),
            std::string::npos)
      << model.warnings()[0];
}

TEST(SubSystems, EachCallUsesItsOwnIgnoreList) {
  EXPECT_EQ(derive(two("Ignore: x\n", "SxA?(2)SxA$", "S < A --> a\n",
                       "Lsystem: 2\nIgnore: z\nAxiom: X\nS < A --> B\nA --> c\nendlsystem\n"),
                   1),
            "Sxa?(2)Sxc$");
}

TEST(SubSystems, APartThatIsKeptTakesItsCallsToTheEndWithTheirVariables) {
  // the call counts on behind the cut, which sets it back neither to its Start nor to its End
  const std::string model = two("", "[%(7)?(2)K$J]?(2)K$", "J --> JJ\n",
                                "Lsystem: 2\nStart: {n=10;}\nEnd: {printf(\"end \");}\nAxiom: X\n"
                                "K : {n=n+1;} * --> K(n)\nK(x) : {n=n+1;} * --> K(n)\nendlsystem\n");
  DerivedModel run(model);
  EXPECT_EQ(run.steps(1), "[]?(2)K(11)$%(7,0)?(2)K$J");
  EXPECT_EQ(run.steps(1), "[]?(2)K(12)$%(7,0)?(2)K(11)$JJ");
  EXPECT_EQ(run.printed(), "");
  // inside a call the part ends at its `$`
  EXPECT_EQ(derive(two("", "A?(2)K%(1)KJ$B", "B --> BB\n", "Lsystem: 2\nAxiom: X\nK --> L\nendlsystem\n"), 1),
            "A?(2)L$BB%(1,0)KJ");
}

TEST(SubSystems, RecursionFails) {
  DerivedModel model(two("", "?(2)A$", "x --> x\n", "Lsystem: 2\nAxiom: X\nA --> ?(2)A$\nendlsystem\n"));
  model.steps(1);
  const core::SimulationError error = model.failingStep();
  EXPECT_EQ(error.code, SimulationErrorCode::Model);
  EXPECT_NE(error.message.find("L-system 2 is called inside itself, which the language forbids"), std::string::npos)
      << error.message;
  EXPECT_EQ(model.text(), "?(2)?(2)A$$");
  EXPECT_EQ(model.state().instances.size(), 3U);
}

TEST(SubSystems, CallsOfUnknownSystemsFail) {
  DerivedModel model(two("", "A", "A --> ?(7)$\n", "Lsystem: 2\nAxiom: X\nA --> A\nendlsystem\n"));
  EXPECT_NE(model.failingStep().message.find("?(7) calls an L-system that does not exist. Labels in this model: 1, 2."),
            std::string::npos);
}

TEST(SubSystems, FailedStepsKeepTheInstances) {
  DerivedModel model(
      two("", "?(2)A(3)$", "x --> x\n",
          "Lsystem: 2\nStart: {n=0;}\nAxiom: X\nA(x) : {n=n+1;} * --> ?(1)A(10^(1000*x))$\nendlsystem\n"));
  static_cast<void>(model.failingStep());
  ASSERT_EQ(model.state().instances.size(), 2U);
  EXPECT_FALSE(model.state().instances[1].hasStarted);
  EXPECT_EQ(model.state().instances[1].variables.at(0), 0.0);
}

}  // namespace
}  // namespace espalier::sub_system_scan_test
