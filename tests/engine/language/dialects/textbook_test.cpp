#include "engine/language/dialects/textbook/textbook.h"

#include <gtest/gtest.h>

#include "tests/engine/language/dialects/dialect_text.h"

namespace espalier::language::textbook_test {
namespace {

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Textbook, BecomesCpfgText) {
  EXPECT_EQ(cpfgText("ω: F\nδ = 25,7°\nn = 2\np1: F → F[+F]F [−F] F\n"),
            "Lsystem: 1\nderivation length: 2\nAxiom: F\nF --> F[+F]F[-F]F\nendlsystem\n");
}

TEST(Textbook, ReadsEveryWayOfWritingAProduction) {
  const std::string plain = cpfgText("ω: F\nF → FF\n");
  for (const char* const production :
       {"p1: F -> FF", "p: F --> FF", "P: F ⟶ FF", "p_2: F → F F", "P: F\n→ FF", "P = {F → FF}"}) {
    EXPECT_EQ(cpfgText(std::string("ω: F\n") + production + "\n"), plain) << production;
  }
  EXPECT_TRUE(contains(cpfgText("ω: A\nA → ε\n"), "A --> *\n"));
  EXPECT_TRUE(
      contains(cpfgText("WM = 0\nPM = {0 → 1[0]0, 1 → 1, [ → [, ] → ]}\n"), "0 --> 1[0]0\n1 --> 1\nendlsystem"));
}

TEST(Textbook, ProbabilitiesStandInMostPlacesOfAProduction) {
  const std::string plain = cpfgText("ω: A\nA → F[+A]A : 0.4\nA → FA : 0.6\n");
  const auto both = [](const std::string& first, const std::string& second) {
    return cpfgText("ω: A\n" + first + "\n" + second + "\n");
  };
  EXPECT_EQ(both("A (0.4) → F[+A]A", "A (0.6) → FA"), plain);
  EXPECT_EQ(both("p1: A (0.4) -> F[+A]A", "p2: A ( 0.6 ) -> FA"), plain);
  EXPECT_EQ(both("A -(0.4)-> F[+A]A", "A -(0.6)-> FA"), plain);
  EXPECT_EQ(both("A --(0.4)--> F[+A]A", "A −(0.6)→ FA"), plain);
  EXPECT_EQ(both("A -0.4-> F[+A]A", "A -0.6-> FA"), plain);
  EXPECT_EQ(both("A : 0.4 → F[+A]A", "A : 0.6 → FA"), plain);
  EXPECT_TRUE(contains(cpfgText("ω: A(1)\nA(l) : l>1 (0.4) → F(l)\nA(l) (60%) → A(l)\n"),
                       "A(l) : l>1 --> F(l) : 0.4\nA(l) --> A(l) : 0.6\n"));
  EXPECT_EQ(both("A, 0.4 → F[+A]A", "A, 0.6 → FA"), plain);
  EXPECT_TRUE(contains(cpfgText("R = 3\nω: A(1)\nA(l), l<R → F(l)\n"), "A(l) : l<3 --> F(l)\n"));
  // a condition that ends with a number has no probability
  EXPECT_TRUE(contains(cpfgText("ω: A(1)\nA(l) : l>(0.5) → F(l)\nA(l) : l>-0.5 → F\nA(l) : 1 → F\n"),
                       "A(l) : l>(0.5) --> F(l)\nA(l) : l>-0.5 --> F\nA(l) : 1 --> F\n"));
}

TEST(Textbook, ANumberAmongModulesIsAnError) {
  const std::string end = " cannot be a module | a probability stands behind the production, as in 'F → F[+F]F : 0.33'";
  EXPECT_EQ(foreignMessages("ω: A\nA → FB [0.3]\n"), Messages{"2:11: error: the number 0.3" + end});
  EXPECT_EQ(foreignMessages("ω: A\nA → FB p .3 C\n").front(), "2:12: error: the number .3" + end);
  EXPECT_EQ(foreignMessages("ω: A\nA {0.3} → FB\n").front(), "2:4: error: the number 0.3" + end);
  EXPECT_TRUE(contains(cpfgText("ω: L\nL → {.f+f.+f1.}\n"), "L --> {.f+f.+f1.}\n"));
}

TEST(Textbook, StatementsMayStandInBracesAndOnOneLine) {
  const std::string plain = cpfgText("axiom: F\nF -> F+F--F+F\nangle: 60\nn: 2\n");
  EXPECT_EQ(cpfgText("{axiom: F; F -> F+F--F+F; angle: 60; n: 2}\n"), plain);
  EXPECT_EQ(cpfgText("{ axiom: F\n  F -> F+F--F+F\n  angle: 60\n  n: 2 }\n"), plain);
  EXPECT_EQ(cpfgText("LSystem {\n  axiom: F\n  F -> F+F--F+F\n  angle: 60\n  n: 2\n}\n"), plain);
  EXPECT_EQ(cpfgText("axiom: F, rules: F -> F+F--F+F, angle: 60, n: 2\n"), plain);
  EXPECT_EQ(cpfgText("angle: 60; n: 2; axiom: F; rules: (F -> F+F--F+F)\n"), plain);
  EXPECT_TRUE(contains(cpfgText("ω: A(1); A(d) : d != 2 → A(d+1); A(d) : d = 2 → F\n"),
                       "A(d) : d != 2 --> A(d+1)\nA(d) : d == 2 --> F\n"));
}

TEST(Textbook, AnyNeighbourIsNoContext) {
  // Hogeweg and Hesper's models, as The Algorithmic Beauty of Plants prints them
  const std::string text = cpfgText("ω : F1F1\np1 : 0 < 1 > 1 → 1F1\np9 : * < + > * → −\np10 : * < − > 0 → +\n");
  EXPECT_TRUE(contains(text, "0 < 1 > 1 --> 1F1\n+ --> -\n- > 0 --> +\n")) << text;
}

TEST(Textbook, SymbolsMayBeWords) {
  const std::string text = cpfgText(
      "n=5, δ=18°\nω : plant\np1 : plant → internode + [ plant + flower] − − //\n[ − − leaf ] internode − [ plant ]\n"
      "p2 : internode → F seg [// & & leaf ] Fseg stem\nseg → seg F seg\n");
  EXPECT_TRUE(contains(text, "Module: flower(...), internode(...), leaf(...), plant(...), seg(...), stem(...)\n"))
      << text;
  EXPECT_TRUE(contains(text, "plant --> internode+[plant+flower]--/ /[--leaf]internode-[plant]\n")) << text;
  EXPECT_TRUE(contains(text, "internode --> Fseg[/ /&&leaf]Fsegstem\n")) << text;
}

TEST(Textbook, BehindTwoSlashesAreRemarksOrModules) {
  EXPECT_TRUE(contains(cpfgText("ω: F\nF → F[+F]F // a bush, see [1]\n"), "F --> F[+F]F\n"));
  EXPECT_TRUE(contains(cpfgText("ω: F\nF → FF // trunk\n"), "F --> FF\n"));
  EXPECT_TRUE(contains(cpfgText("ω: A\nA → F // A\nB → F //\n"), "A --> F/ /A\nB --> F/ /\n"));
  EXPECT_TRUE(contains(cpfgText("ω: apex\napex → F // apex\n"), "apex --> F/ /apex\n"));
}

TEST(Textbook, RulesMayStandBelowAHeading) {
  EXPECT_TRUE(contains(cpfgText("axiom: F\nrules:\n  F: F+F−F\n  X: FX\nangle: 90 degrees\n"),
                       "F --> F+F-F\nX --> FX\nendlsystem\n"));
  EXPECT_TRUE(contains(cpfgText("Axiom: FX\nRule: X=X+YF+\nRule: Y=-FX-Y\nAngle: 90\n"), "X --> X+YF+\nY --> -FX-Y\n"));
  EXPECT_TRUE(contains(cpfgText("omega: F\ndelta = 60\nP1: F --> F+F−−F+F\nn = 2\n"), "F --> F+F--F+F\n"));
  EXPECT_TRUE(contains(cpfgText("ω: F\nF → F[+F\nF]F\n"), "F --> F[+FF]F\n")) << "a bracket is open";
}

TEST(Textbook, ReadsProbabilitiesBeforeAndBehind) {
  EXPECT_TRUE(contains(cpfgText("ω: F\nF → (1/3)FF\n"), "F --> FF : 1/3\n"));
  EXPECT_TRUE(contains(cpfgText("ω: F\nF → FF : 0.33\n"), "F --> FF : 0.33\n"));
}

TEST(Textbook, ReadsContextsAndConditions) {
  EXPECT_TRUE(contains(cpfgText("ω: AB\nXY<A>CDE → AAA\n"), "XY < A > CDE --> AAA\n"));
  EXPECT_TRUE(contains(cpfgText("ω: A(1)\nA(x) : x=3 ∧ x≤4 → B\n"), "A(x) : x==3 && x<=4 --> B\n"));
  EXPECT_TRUE(contains(cpfgText("#ignore : + - -\nω: F\nF → F\n"), "ignore: +--\n"));
}

TEST(Textbook, ASubscriptIsALevelOrAName) {
  EXPECT_TRUE(contains(cpfgText("n = 2\nL_{n+1} = +R_nF-L_n\nR_{n+1} = -L_n\n"),
                       "Axiom: L(2)\nL(n) : n > 0 --> +R(n-1)F-L(n-1)\nR(n) : n > 0 --> -L(n-1)\n"));
  // a symbol of the same level is replaced one step later
  EXPECT_TRUE(contains(cpfgText("n = 2\nx_0 → ♠\nx_n → F_n[+x_{n-1}]\nF_n → F_{n-1}F_{n-1}\n"),
                       "derivation length: 3\nAxiom: x(2)\nx(n) : n > 0 --> F(n)[+x(n-1)]\n"));
  EXPECT_TRUE(contains(cpfgText("ω: F\nF → F_b[+F_a]\nF_b < F_a → F_b\n"), "Module: F_a, F_b\n"));
}

TEST(Textbook, SeveralAxiomsAreSeveralModels) {
  EXPECT_TRUE(contains(cpfgText("w: L,R\nL -> R\n", "R"), "Axiom: R\n"));
  EXPECT_TRUE(contains(cpfgText("w: A(1,2)\nA(x,y) -> A(y,x)\n"), "Axiom: A(1,2)\n"));
}

TEST(Textbook, RollsInTheOppositeDirectionAndMayTurnClockwise) {
  const std::string text = cpfgText("ω: F/F\\F+F-\nδ = 30°\nturns: clockwise\nF → F\n");
  EXPECT_TRUE(contains(text, "+ --> -(30)\n- --> +(30)\n/ --> \\(30)\n\\ --> /(30)\n")) << text;
}

TEST(Textbook, ATurnWithANumberHasTheDirectionOfOneWithout) {
  const std::string text = cpfgText("ω: F/(10)F\\(20)F+(30)F-(x)\nx = 5\nturns: clockwise\nF → F\n");
  EXPECT_TRUE(contains(text, "+(x) --> -(x)\n-(x) --> +(x)\n/(x) --> \\(x)\n\\(x) --> /(x)\n")) << text;
  // the sign of the next colour changes no roll
  EXPECT_TRUE(contains(cpfgText("ω: F/F’F\nδ = 30°\nF → F\n"), "/ --> \\(30)\n' --> ;\n"));
  // what is drawn is not drawn once more
  EXPECT_TRUE(contains(cpfgText("ω: L\nshape L: /(x/2)F\\F\nL → L\n"), "L --> \\(x/2)F/F\n"));
  // one drawing of a symbol is enough
  const std::string alone = aloneText("ω: F/F&F\nδ = 30°\nF → F\n");
  EXPECT_TRUE(contains(alone, "/ --> \\(30)\n& --> &(30)\nendlsystem\n")) << alone;
}

TEST(Textbook, ASignOfPrintMayHaveANumber) {
  const std::string text = "ω: −(90)F(1)\nF(x) → –(30)F(x)’(0.5)⁄(5)F\n";
  const std::string cpfg = cpfgText(text);
  EXPECT_TRUE(contains(cpfg, "Axiom: -(90)F(1)\nF(x) --> -(30)F(x)'(0.5)/(5)F\n")) << cpfg;
  EXPECT_TRUE(contains(cpfgText("ω: A\nA −(0.6)→ B\nA –(0.4)→ C\n"), "A --> B : 0.6\nA --> C : 0.4\n"));
}

TEST(Textbook, AWedgeIsAPowerOutsideOfConditions) {
  EXPECT_TRUE(contains(cpfgText("ω: F(4)\nF(x) → F(x ∧ 0.5)\n"), "F(x) --> F(x ^ 0.5)\n"));
  EXPECT_TRUE(
      contains(cpfgText("ω: F(4)\nh = 4∧0.5\nF(x) : x>1 ∧ x<9 → F(h)∧F\n"), "F(x) : x>1 && x<9 --> F((4^0.5))^F\n"));
  const std::string macros = "#define c 1\n#define h ((c − 0.3) ∧ 2)\n#define k h∧2\nω: F(1)\n";
  EXPECT_EQ(foreignMessages(macros + "F(x) → F(x∗h)\n"), Messages{});
  EXPECT_EQ(foreignMessages("ω: F(1)\nF(x) → F(x ♣ 2)\n").front(),
            "2:14: error: the character '♣' cannot stand in an expression | expressions have numbers, names, + - * / ^ "
            "and parentheses");
}

TEST(Textbook, SlashesAmongWordsAreRolls) {
  EXPECT_TRUE(contains(cpfgText("ω: flower\nflower → pedicel // wedge // leaf wedge\n"),
                       "flower --> pedicel/ /wedge/ /leafwedge\n"));
  EXPECT_TRUE(contains(cpfgText("ω: flower\nflower → [ & pedicel / wedge\nwedge //// wedge ]\n"),
                       "flower --> [&pedicel/wedgewedge/ / / /wedge]\n"));
  EXPECT_TRUE(contains(cpfgText("ω: flower\nflower → [ & pedicel\n// wedge ]\n"), "[&pedicel/ /wedge]\n"));
  EXPECT_TRUE(contains(cpfgText("ω: F\nF → F[+F]F // right // or not\n"), "F --> F[+F]F\n"));
}

TEST(Textbook, ARemarkMayStandBetweenTheLinesOfASuccessor) {
  EXPECT_TRUE(contains(cpfgText("ω: F\nF → F[+F // left ] side\n# all of it\n]F # right [ side\n"), "F --> F[+F]F\n"));
}

TEST(Textbook, AListMayHaveOneRule) {
  for (const char* const rule : {"1. g → gg", "• g → gg", "- g → gg", "* g → gg", "P1 = g → gg"}) {
    EXPECT_TRUE(contains(cpfgText(std::string("axiom: g\n") + rule + "\n"), "Axiom: g\ng --> gg\n")) << rule;
  }
  EXPECT_TRUE(contains(cpfgText("axiom: g\n1. g → gf\nf → g\n"), "g --> gf\nf --> g\n"));
  // a minus that is rewritten
  EXPECT_TRUE(contains(cpfgText("axiom: F-\nF → F-F\n- → +\n"), "F --> F-F\n- --> +\n"));
}

TEST(Textbook, ArrowsMayBeLatex) {
  EXPECT_TRUE(contains(cpfgText("ω: F\np1: $F \\rightarrow GF$\np2: $G \\to GG$\n"), "F --> GF\nG --> GG\n"));
  EXPECT_TRUE(contains(
      cpfgText("- $\\omega: A(0)$\n- $p1: F < A(x) : x=1 \\longrightarrow [-L]A(x+1)$\n- P2 = $A(x) \\to B$\n"),
      "Axiom: A(0)\nF < A(x) : x==1 --> [-L]A(x+1)\nA(x) --> B\n"));
  EXPECT_TRUE(contains(cpfgText("ω: $F\nF → F\\to$F\n"), "Axiom: $F\nF --> F\\to$F\n"));
}

TEST(Textbook, AlphaIsTheAngleOfTurnsWithoutAnother) {
  const CompileResult result = compileForeign("ω: F+F\nα = 30°\nF → F\n");
  ASSERT_NE(result.program, nullptr);
  EXPECT_EQ(result.program->view.angleIncrementDegrees, 30.0);
  EXPECT_EQ(result.program->view.initialHeading, (core::Vec3{0.0, 1.0, 0.0}));
  const CompileResult heading = compileForeign("ω: F+F\nα = 0°\nδ = 60°\nF → F\n");
  ASSERT_NE(heading.program, nullptr);
  EXPECT_EQ(heading.program->view.angleIncrementDegrees, 60.0);
  EXPECT_EQ(heading.program->view.initialHeading, (core::Vec3{1.0, 0.0, 0.0}));
  EXPECT_EQ(foreignMessages("ω: F+F\nα = 0°\nδ = 60°\nF → F\n"), Messages{});
  EXPECT_TRUE(contains(cpfgText("ω: F(1)\nα = 30°\nF(x) → +(α)F(x)\n"), "F(x) --> +(30)F(x)\n"));
}

TEST(Textbook, SubscriptsMayBeSmallLetters) {
  EXPECT_EQ(cpfgText("ω: Fₗ\np₁: Fₗ → Fₗ+Fᵣ\np₂: Fᵣ → −Fₗ\n"), cpfgText("ω: F_l\nF_l → F_l+F_r\nF_r → −F_l\n"));
  EXPECT_EQ(cpfgText("Lₙ₊₁ = +RₙF\nRₙ₊₁ = −Lₙ\n"), cpfgText("L_{n+1} = +R_nF\nR_{n+1} = -L_n\n"));
}

TEST(Textbook, ASetOfProductionsMayHaveSeveralLines) {
  const std::string plain = cpfgText("ω: X\nX → [F]X\nF → FF\n");
  EXPECT_EQ(cpfgText("ω: X\nP = {\n  X → [F]X,\n  F → FF\n}\n"), plain);
  EXPECT_EQ(cpfgText("ω: X\nP = { X → [F]X,\n      F → FF }\n"), plain);
}

TEST(Textbook, StringsOfAllStepsAreSkipped) {
  const std::string text =
      "variables : A B\nconstants : none\naxiom : A\nrules : (A → AB), (B → A)\nwhich produces:\nn = 0 : A\n"
      "n = 1 : AB\n";
  EXPECT_EQ(foreignMessages(text),
            (Messages{"5:1: warning: 'which produces:' is read as a remark | begin remarks with '#'",
                      "6:1: warning: lines such as 'n = 1 : AB' show strings of the model | they are skipped; 'n = 4' "
                      "sets the number of steps"}));
  EXPECT_TRUE(contains(cpfgText(text + "n = 4\n"), "derivation length: 4\nAxiom: A\n"));
  // no list begins so
  EXPECT_EQ(foreignMessages("axiom: F\nF → FF\nn = 3 : Koch\n").size(), 1U);
  EXPECT_TRUE(foreignMessages("axiom: F\nF → FF\nn = 3 : Koch\n").front().starts_with("3:5: error"));
}

TEST(Textbook, ASentenceMayHoldTheAngle) {
  const CompileResult result = compileForeign("L-system:\nω = F\nP: F → F+F\nParametr δ wynosi 35,7° .\n");
  ASSERT_NE(result.program, nullptr);
  EXPECT_EQ(result.program->view.angleIncrementDegrees, 35.7);
}

TEST(Textbook, ExclamationMarkThickensAndCommaChangesTheColour) {
  const CompileResult result = compileForeign("ω: !F\nF → F,F\n");
  ASSERT_NE(result.program, nullptr);
  EXPECT_TRUE(contains(result.program->sources.front().text, "! --> #\n, --> ;\n"));
  EXPECT_EQ(result.program->view.lineWidthIncrement, 1.0);
}

TEST(Textbook, AStepMayShrinkWithEachGeneration) {
  EXPECT_TRUE(contains(cpfgText("l : F-F\nδ = 90°\nd : d/4\nF → FF\n"), "F --> F(1/4^Q)\n"));
  EXPECT_TRUE(contains(cpfgText("ω: F\nd = 3\nF → FF\n"), "F --> F(3)\n"));
}

TEST(Textbook, AShapeDefinesTheDrawingOfASymbol) {
  EXPECT_TRUE(contains(cpfgText("ω: A\nA → [A]A\nshape A: F\nshape ]: ]/(180)\n"), "A --> F\n] --> ]\\(180)\n"));
}

TEST(Textbook, StartsUpwardsUnlessAnAngleIsGiven) {
  const CompileResult up = compileForeign("ω: F\nF → F\n");
  const CompileResult right = compileForeign("ω: F\nα0 = 0°\nF → F\n");
  ASSERT_TRUE(up.program != nullptr && right.program != nullptr);
  EXPECT_EQ(up.program->view.initialHeading, (core::Vec3{0.0, 1.0, 0.0}));
  EXPECT_EQ(right.program->view.initialHeading, (core::Vec3{1.0, 0.0, 0.0}));
}

TEST(Textbook, ReadsTheWordsOfFilesThatPeopleHave) {
  const std::string koch = "Lsystem: 1\nderivation length: 1\nAxiom: F\nF --> F+F--F+F\nendlsystem\n";
  for (const char* const text :
       {"axiom: F\nF -> F+F--F+F\nangle: 60\n", "axiom = F\nF -> F+F--F+F\nangle = 60\n",
        "START : F\np1: F → F+F−−F+F\nδ=60\n", "axiom F\nangle 60\nF -> F+F--F+F\n",
        "Axiom: \"F\"\nAngle: 60 degrees\nRules:\n  F -> F+F--F+F;\n", "axiom: F\nangle: π/3\nF=F+F--F+F\n",
        "variables : F\nconstants : + −\nstart : F\nrules : (F → F+F−−F+F)\nangle : 60°\n",
        "/* a comment\n over lines */\naxiom: F # start\nRule 1: F -> F+F--F+F\nangle: 60 // go\n",
        "axiom: F\nF –> F+F--\n   F+F\nangle: 60◦\n"}) {
    EXPECT_EQ(cpfgText(text), koch) << text;
    EXPECT_EQ(foreignMessages(text), Messages{}) << text;
    EXPECT_EQ(compileForeign(text).program->view.angleIncrementDegrees, 60.0) << text;
  }
}

TEST(Textbook, ReadsCaptions) {
  EXPECT_EQ(cpfgText("n=5, δ=25.7◦\nF\nF→F[+F]F\n"),
            "Lsystem: 1\nderivation length: 5\nAxiom: F\nF --> F[+F]F\nendlsystem\n");
  EXPECT_EQ(foreignMessages("Koch curve of the lecture\nn=4\nδ=60\nF\nF→F+F\n"),
            (Messages{"1:1: warning: 'Koch curve of the lecture' is read as a remark | begin remarks with '#'",
                      "4:1: warning: 'F' is read as the axiom | write 'ω: F' to name the axiom"}));
}

TEST(Textbook, WikipediasRulesAreOneList) {
  const std::string text = cpfgText("variables : X F\nstart : X\nrules  : (X → F+[[X]-X]-X), (F → FF)\nangle : 25°\n");
  EXPECT_TRUE(contains(text, "Axiom: X\nX --> F+[[X]-X]-X\nF --> FF\nendlsystem\n")) << text;
}

TEST(Textbook, ListsAndQuotationMarksAreReadWhereverTheyStand) {
  EXPECT_TRUE(contains(cpfgText("Axiom: F\nRules:\n- F -> F-F\nAngle: 60\n"), "Axiom: F\nF --> F-F\n"));
  EXPECT_TRUE(contains(cpfgText("Axiom: A\n\n* A -> AB\n* B -> A\n"), "A --> AB\nB --> A\n"));
  EXPECT_TRUE(contains(cpfgText("{axiom: F; 'F' -> 'F+F'; angle: 60}\n"), "F --> F+F\n"));
  EXPECT_TRUE(contains(cpfgText("Axiom: 'F'\nRules: ('F' -> 'F+F-F'), ('X' -> 'FF')\n"), "Axiom: F\nF --> F+F-F\n"));
  // a polygon is no remark
  EXPECT_TRUE(contains(cpfgText("axiom: F\nF -> F {fff ggg fff} F\n"), "{fffgggfff}"));
}

TEST(Textbook, ConstantsStandBesideProductions) {
  EXPECT_TRUE(
      contains(cpfgText("ω: A(1)\nR = 0.7\nA(s) → F(s)[+A(s*R)][-A(s×R)]\n"), "A(s) --> F(s)[+A(s*0.7)][-A(s*0.7)]\n"));
  EXPECT_TRUE(contains(cpfgText("#define r1 0.9 /* c */\n#define d 137.5\nω : A(1)\np1 : A(l) : * → F(l)/(d)A(l*r1)\n"),
                       "A(l) --> F(l)/(137.5)A(l*0.9)\n"));
  EXPECT_TRUE(contains(cpfgText("α₁ = 30°\nω: A(1)\nA(λ) : λ>0 → +(α₁)A(λ/2)\n"),
                       "A(lambda) : lambda>0 --> +(30)A(lambda/2)\n"));
  EXPECT_TRUE(contains(cpfgText("START : F\n#define maxgen 4\nF → FF\n"), "derivation length: 4\n"));
  // a misspelt setting, and a name that nothing uses
  EXPECT_EQ(foreignMessages("axiom: F\nangel: 60\nF -> FF\n"),
            Messages{"2:1: error: there is no setting 'angel' | did you mean 'angle'?"});
  EXPECT_EQ(foreignMessages("axiom: F\nq = 60\nF -> FF\n"),
            Messages{"2:1: warning: nothing in the model uses 'q = 60' | use the name or remove the line"});
}

TEST(Textbook, ReadsProbabilitiesBeforeTheArrow) {
  for (const char* const text : {"ω: F\nF .5→ FF\n", "ω: F\nF 0.5 → FF\n", "ω: F\nF 1/2 -> FF\n", "ω: F\nF 50% → FF\n",
                                 "ω: F\nF → .5 FF\n", "ω: F\nF → FF : 50%\n"}) {
    const std::string cpfg = cpfgText(text);
    EXPECT_TRUE(contains(cpfg, "F --> FF : 0.5\n") || contains(cpfg, "F --> FF : 1/2\n") ||
                contains(cpfg, "F --> FF : .5\n"))
        << cpfg;
  }
  // a number of the condition is none
  EXPECT_TRUE(contains(cpfgText("ω: A(1)\nA(x) : x > 0.5 → F\n"), "A(x) : x > 0.5 --> F\n"));
}

TEST(Textbook, ASemicolonMayBeginTheCondition) {
  EXPECT_TRUE(contains(cpfgText("axiom: A(1)\nA(x); x != 2 -> A(x+1)\n"), "A(x) : x != 2 --> A(x+1)\n"));
  EXPECT_TRUE(contains(cpfgText("axiom: A(1)\nA(x) : x>1 and x<>3 -> A(x+1)\n"), "A(x) : x>1 && x!=3 --> A(x+1)\n"));
}

TEST(Textbook, TheBooksApostropheIsTheNextColour) {
  const std::string text = cpfgText("ω: A\nδ=22.5\nA → [&F!A]/////’[&F!A]\nL → [’’∧{−f+f}]\n");
  EXPECT_TRUE(contains(text, "A --> [&F!A]/ / / / /'[&F!A]\nL --> [''^{-f+f}]\n")) << text;
  EXPECT_TRUE(contains(text, "' --> ;\n! --> @W(0.7)\n")) << text;
}

TEST(Textbook, LettersAreStepsWhenNothingElseDraws) {
  const std::string arrowhead = "start: A\nrules: (A → B−A−B), (B → A+B+A)\nangle: 60°\n";
  EXPECT_TRUE(contains(cpfgText(arrowhead), "A --> F\nB --> F\n"));
  EXPECT_EQ(
      foreignMessages(arrowhead),
      Messages{"1:1: warning: no symbol of the model draws: A, B are drawn as steps | 'shape A: F' gives the drawing "
               "of a symbol"});
  EXPECT_FALSE(contains(cpfgText("start: X\nangle: 90\nX → X+YF\nY → FX-Y\n"), "X --> F\n"));
}

TEST(Textbook, ErrorsNameItsLinesAndTerms) {
  EXPECT_EQ(foreignMessages("F → FF\n"),
            Messages{"1:1: error: the model has no axiom | write the first string as 'ω: F'"});
  EXPECT_EQ(foreignMessages("ω: F\nn = -2\nF → FF\n"),
            Messages{"2:5: error: expected a whole number from 0 to 1000000 while reading n, found '-2' | it says how "
                     "many steps are "
                     "derived"});
  EXPECT_EQ(foreignMessages("ω: F\nδ = wide\nF → FF\n"),
            Messages{"2:6: error: expected an angle in degrees, found 'wide' | write it as δ = 25.7°"});
  EXPECT_EQ(
      foreignMessages("ω: F\nF → FF\nqqq\n"),
      Messages{
          "3:1: error: expected an axiom, a production or a setting, found 'qqq' | write 'ω: F', 'p1: F → F+F', 'δ "
          "= 60°', 'n = 3', 'd = 1', '#ignore: +-'"});
  EXPECT_EQ(
      foreignMessages("ω: F\nF → F*F\n"),
      Messages{"2:8: error: the character '*' cannot be a module here | a module is a letter or a sign of the turtle, "
               "with parameters in parentheses"});
  EXPECT_EQ(
      foreignMessages("ω: F (2)\nF → F\n"),
      (Messages{"1:7: error: the character '(' cannot be a module here | parameters stand directly behind their symbol",
                "1:9: error: the character ')' cannot be a module here | a module is a letter or a sign of the turtle, "
                "with parameters in parentheses"}));
  EXPECT_EQ(
      foreignMessages("ω: A(1\nF → F\n"),
      Messages{
          "1:6: error: the parenthesis '(' of A is never closed | the parameters of a module stand between '(' and "
          "')'"});
  EXPECT_EQ(foreignMessages("ω: F\nturns: left\nF → F\n"),
            Messages{"2:8: error: expected 'clockwise' or 'counterclockwise', found 'left' | it sets the direction in "
                     "which + turns"});
  EXPECT_EQ(foreignMessages("ω: F\nd = 0\nF → F\n"),
            Messages{"2:5: error: expected a length or a quotient such as d/4, found '0' | d is the length of a step"});
  EXPECT_EQ(foreignMessages("ω: F\nA < → F\n"),
            Messages{"2:1: error: a production without a predecessor | the symbol that is replaced stands before '→'"});
  EXPECT_EQ(
      foreignMessages("ω: F\nF → F\nshape F\n"),
      Messages{
          "3:7: error: expected a module and ':' while reading 'shape' | write 'shape L: [+(30)F]': L is drawn so"});
  // ASCII arrows and no axiom: recognised too
  EXPECT_EQ(foreignMessages("F -> F+F\n").front(),
            "1:1: error: the model has no axiom | write the first string as 'ω: F'");
  EXPECT_EQ(
      foreignMessages("ω: F\nF → FF : -0.5\nF → (-1/2)F\n").front(),
      "2:12: error: a probability is a number from 0 to 1, found '-0.5' | write it behind the production, as in 'F → "
      "F[+F]F : 0.33', or before it, as in 'F → (1/3)F[+F]F'");
  EXPECT_EQ(foreignMessages("ω: F\nδ =\nF → F\n"),
            Messages{"2:1: error: a setting without a value | write it behind the name"});
}

TEST(Textbook, ProbabilitiesThatDoNotSumToOneAreAWarning) {
  EXPECT_EQ(foreignMessages("ω: A(1)F\np1: A(x) → A(x+1) : 0.4\np2: A(x) → B(x) : 0.7\nF → F : 0.33\nF → FF : 0.66\n"),
            Messages{"2:5: warning: the probabilities of A(x) sum to 1.1 | they are scaled to 1"});
  // other left sides, or expressions: the sum is unknown
  EXPECT_EQ(foreignMessages("ω: A(1)\nA(x) : x<2 → A(x+1) : 0.4\nA(x) : x>=2 → B(x) : 1\n").size(), 1U);
  EXPECT_EQ(foreignMessages("ω: A(1)\nA(x) → A(x+1) : x/2\nA(x) → B(x) : 0.1\n"), Messages{});
}

TEST(Textbook, APrintedLessOrEqualBeforeThePredecessorIsAContextWithAWarning) {
  const std::string text = "ω: FA(1)\nF <= A(x) : x=1 → F\n";
  EXPECT_TRUE(contains(cpfgText(text), "F < A(x) : x==1 --> F\n"));
  EXPECT_EQ(foreignMessages(text), Messages{"2:3: warning: '<=' is read as '<' | contexts are written l < a > r"});
  const std::string printed = "ω: FA(1)F\nF ≤ A(x) ≥ F : x≤1 → F\n";
  EXPECT_TRUE(contains(cpfgText(printed), "F < A(x) > F : x<=1 --> F\n"));
  EXPECT_EQ(foreignMessages(printed).front(), "2:3: warning: '≤' is read as '<' | contexts are written l < a > r");
}

TEST(Textbook, FormsThatWereReadSilentlyAsSomethingElse) {
  // a typo behind a production on one line
  EXPECT_EQ(foreignMessages("axiom: F; F -> F+F; angel: 60\n").front(),
            "1:21: error: there is no setting 'angel' | did you mean 'angle'?");
  // constants in a list
  const std::string listed = cpfgText("axiom: A(1)\nconstants: r=2, s=3\nA(x) → F(x/r)A(x*s)\n");
  EXPECT_TRUE(contains(listed, "A(x) --> F(x/2)A(x*3)\n")) << listed;
  // a chance at the end, and conditions in words
  const std::string chance = cpfgText("ω: A\nA → B 50%\nA → C 50%\n");
  EXPECT_TRUE(contains(chance, "A --> B : 0.5\n")) << chance;
  EXPECT_TRUE(contains(cpfgText("ω: A(1)\nA(x) where x<3 → A(x+1)\n"), "A(x) : x<3 --> A(x+1)\n"));
  EXPECT_TRUE(contains(cpfgText("ω: A(1)\nA(x) if x<3 → A(x+1)\n"), "A(x) : x<3 --> A(x+1)\n"));
  // a setting twice
  EXPECT_EQ(foreignMessages("ω: F\nδ = 60°\nδ = 90°\nF → FF\n"),
            Messages{"3:1: warning: 'δ' is given once more | the last one counts; remove the others"});
}

TEST(Textbook, SettingsOfLatexAreReadWithoutDollars) {
  const std::string plain = cpfgText("ω: F\np: F → F+F\nδ = 90\n");
  ASSERT_FALSE(plain.empty());
  EXPECT_EQ(cpfgText("\\omega: F\np: F \\rightarrow F+F\n\\delta = 90\n"), plain);
  EXPECT_EQ(cpfgText("\\omega : F\np: F -> F+F\n\\delta = 90\n"), plain);
}

TEST(Textbook, LinesOfThePreprocessorAreWarnings) {
  EXPECT_EQ(
      foreignMessages("#include \"a.h\"\naxiom: F\n#if BIG\nF -> FF\n#endif\n"),
      (Messages{"1:1: warning: '#include \"a.h\"' has no effect in textbook notation | put the lines of the file "
                "here",
                "3:1: warning: '#if BIG' has no effect in textbook notation | every line up to '#endif' is read"}));
}

TEST(Textbook, ACommandOfLatexIsNamed) {
  EXPECT_EQ(
      foreignMessages("\\begin{align}\nω: F\nF → FF\n"),
      Messages{"1:1: error: expected an axiom, a production or a setting, found '\\begin{align}' | '\\begin' is a "
               "command of LaTeX: remove it"});
}

}  // namespace
}  // namespace espalier::language::textbook_test
