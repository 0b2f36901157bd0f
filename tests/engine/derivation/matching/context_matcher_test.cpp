#include "engine/derivation/matching/context_matcher.h"

#include <gtest/gtest.h>

#include "tests/support/derived_model.h"

namespace espalier::context_matcher_test {
namespace {

using test::derive;
using test::modelText;

/// The string after one step of productions.
std::string once(const std::string& items, const std::string& axiom, const std::string& productions) {
  return derive(modelText(items, axiom, productions), 1);
}

TEST(ContextMatcher, LeftContextSkipsBranchesAndEntersTheMotherAxis) {
  EXPECT_EQ(once("", "A[B[C]]J[J]", "A < J --> a\nJ < J --> j\n"), "A[B[C]]a[j]");
}

TEST(ContextMatcher, LeftContextSkipsIgnoredSymbols) {
  EXPECT_EQ(once("ignore: +F\n", "A+F(2)J", "A < J --> a\n"), "A+F(2)a");
  EXPECT_EQ(once("", "A+F(2)J", "A < J --> a\n"), "A+F(2)J");
}

TEST(ContextMatcher, ContextNeedsTheSameParameterCountAndBindsIt) {
  EXPECT_EQ(once("", "S(1,2)J", "S(x) < J --> a(x)\nS(x,y) < J --> b(x+y)\n"), "S(1,2)b(3)");
}

TEST(ContextMatcher, NearestContextModuleIsWrittenNextToThePredecessor) {
  EXPECT_EQ(once("", "P(1)Q(2)J(3)R(4)S(5)", "P(a)Q(b) < J(c) > R(d)S(e) --> J(a+10*b+100*c+1000*d+10000*e)\n"),
            "P(1)Q(2)J(54321)R(4)S(5)");
}

TEST(ContextMatcher, RightContextSkipsBranchesAndStaysInItsBranch) {
  EXPECT_EQ(once("", "J[B]C", "J > B --> b\nJ > C --> c\n"), "c[B]C");
  EXPECT_EQ(once("", "[J]C", "J > C --> c\n"), "[J]C");
}

TEST(ContextMatcher, RightContextMatchesLiteralBrackets) {
  EXPECT_EQ(once("", "J[B]CJ[BD]C", "J > [B]C --> p\nJ > [B --> r\n"), "p[B]Cr[BD]C");
  EXPECT_EQ(once("", "A[J]B", "J > ]B --> e\n"), "A[e]B");
}

TEST(ContextMatcher, EqualsSkipsToTheEndOfTheBranch) {
  EXPECT_EQ(once("", "J[BX[C]Y]DJ[XB]D", "J > [B=]D --> q\n"), "q[BX[C]Y]DJ[XB]D");
  EXPECT_EQ(once("", "JB", "J > B=] --> q\n"), "JB");
}

TEST(ContextMatcher, IgnoredBracketsLetTheRightContextWalkIntoBranches) {
  EXPECT_EQ(once("ignore: []\n", "J[B]C", "J > B --> b\n"), "b[B]C");
  EXPECT_EQ(once("consider: JBC\n", "[J]yC", "J > C --> c\n"), "[c]yC");
  EXPECT_EQ(once("consider: JBC[]\n", "[J]yC", "J > C --> c\n"), "[J]yC");
}

TEST(ContextMatcher, BindsParametersBehindSkippedBranches) {
  EXPECT_EQ(once("", "J(1)[B(7)[D(8,9)]]C(3)", "J(x) > C(y) --> J(y)\n"), "J(3)[B(7)[D(8,9)]]C(3)");
  EXPECT_EQ(once("", "C(3)[B(7)[D(8,9)]]J(1)", "C(y) < J(x) --> J(y)\n"), "C(3)[B(7)[D(8,9)]]J(3)");
  EXPECT_EQ(once("", "J(1)[B(7)C(8)[D(9)]D(6)]C(3)", "J(x) > [B(a)=]C(y) --> J(a+y)\n"),
            "J(10)[B(7)C(8)[D(9)]D(6)]C(3)");
}

TEST(ContextMatcher, StringEndsDoNotMatch) {
  EXPECT_EQ(once("", "UUU", "U < U > U --> V\nU > U --> L\nU < U --> R\n"), "LVR");
}

TEST(ContextMatcher, RingContinuesAtTheOtherEnd) {
  EXPECT_EQ(once("Ring Lsystem\n", "B(9)A(1)A(2)", "B(p) < A(q) --> B(q+10)\nA(p) > B(q) --> A(p*2)\n"),
            "B(9)B(11)A(4)");
  // all around to the module itself, and no further
  EXPECT_EQ(once("Ring Lsystem\n", "A(1)", "A(p) < A(q) > A(r) --> A(p+q+r)\n"), "A(3)");
  EXPECT_EQ(once("Ring Lsystem\nignore: x\n", "xA(1)x", "A(p) < A(q) > A(r) --> A(p+q+r)\n"), "xA(3)x");
}

TEST(ContextMatcher, RingOfIgnoredSymbolsEndsTheSearch) {
  EXPECT_EQ(once("Ring Lsystem\nignore: x\n", "xxx", "A < x --> y\nx > A --> z\n"), "xxx");
}

TEST(ContextMatcher, UnmatchedBracketsEndTheSearch) {
  EXPECT_EQ(once("", "A]J", "A < J --> a\n"), "A]J");
  EXPECT_EQ(once("", "J[A", "J > A --> a\n"), "J[A");
}

TEST(ContextMatcher, NewLeftContextSeesTheStringBeingProduced) {
  // in one step the signal runs through the whole string
  EXPECT_EQ(once("", "SJJ[J]J", "S << J --> S\n"), "SSS[S]S");
  EXPECT_EQ(once("", "S(1)J(0)J(0)", "S(a) << J(b) --> S(a+1)\n"), "S(1)S(2)S(3)");
  // several modules stand in the order of the string
  EXPECT_EQ(once("", "A(1)B(2)C", "A(x) B(y) << C --> C(x,y)\n"), "A(1)B(2)C(1,2)");
  EXPECT_EQ(once("", "B(2)A(1)C", "A(x) B(y) << C --> C(x,y)\n"), "B(2)A(1)C");
}

TEST(ContextMatcher, NewRightContextSeesTheStringBeingProducedFromTheRight) {
  EXPECT_EQ(once("", "JJ[J]J[K]S", "J >> S --> S\n"), "SS[J]S[K]S");
  EXPECT_EQ(once("", "J(0)J(0)S(5)", "J(b) >> S(a) --> S(a+1)x(a)\nx(a) --> y(a)\n"), "S(7)x(6)S(6)x(5)S(5)");
  EXPECT_EQ(once("ignore: +\n", "J+K[X]L", "J >> [Y=]L --> j\nX --> YZ\nK --> *\n"), "j+[YZ]L");
  EXPECT_EQ(once("", "A[JB%CD[E]]J", "J >> B --> b\nC --> CC\n"), "A[bB]J");
  EXPECT_EQ(once("", "[JB%C%DD]J", "J >> B --> b\nC --> CC\n"), "[bB]J");
  // a part that is cut away takes its own cuts with it; kept parts stand in the order of the string
  for (const char* context : {"J >> B --> b\n", "J > B --> b\n"}) {
    EXPECT_EQ(once("", "[JB%(1)C[%(2)D]%(3)E]F[G%(4)H%I%(5)]K[L%M%(6)N]%(7)O", std::string(context) + "A --> %(9,9)\n"),
              "[bB]F[G]K[L]%(1,0)C[%(2)D]%(3)E%(4,1)H%I%(5)%(7,2)O");
  }
}

}  // namespace
}  // namespace espalier::context_matcher_test
