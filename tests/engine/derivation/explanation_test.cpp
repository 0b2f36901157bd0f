#include "engine/derivation/explanation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "engine/core/number_text.h"
#include "engine/derivation/rewrite_record.h"
#include "tests/support/derived_model.h"

namespace espalier::derivation::explanation_test {
namespace {

using test::DerivedModel;
using test::modelText;

std::string explained(const std::string& text, std::uint64_t stepsBefore, std::uint64_t module,
                      core::Compatibility compatibility = core::Compatibility::Espalier) {
  DerivedModel model(text, {}, compatibility);
  model.steps(stepsBefore);
  const auto result = explain(model.program(), {}, model.state(), module);
  return result ? *result : "error: " + result.error().message;
}

/// The text after the heading: from "What happened" on.
std::string happened(const std::string& text) {
  return text.substr(std::min(text.find("What happened"), text.size()));
}

std::string events(const std::string& items, const std::string& axiom, const std::string& rest, std::uint64_t module) {
  return happened(explained(modelText(items, axiom, rest), 0, module));
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Explanation, ContextFree) {
  EXPECT_EQ(explained(modelText("", "A(1)B", "A(l) --> F(l)A(l*2)\nA(l,m) --> F\nA(x) : x > 0 --> B\n"), 1, 1),
            "Step 2 reads the string of step 1, 3 modules, with the replies of the environment.\n"
            "Module 1: A(2)\n"
            "Around it: F(1) >>A(2)<< B\n"
            "\n"
            "What happened: model.l:4:1 fired.\n"
            "  A(l) --> F(l)A(l*2)\n"
            "It made: F(2)A(4)\n"
            "\n"
            "Productions that begin with 'A', in the order of the file:\n"
            "  model.l:4:1: A(l) --> F(l)A(l*2)\n"
            "    applied with l = 2\n"
            "  model.l:5:1: A(l,m) --> F\n"
            "    failed: it wants 2 parameters, the module has 1\n"
            "  model.l:6:1: A(x) : x > 0 --> B\n"
            "    not tried: an earlier production applied\n");
}

TEST(Explanation, AFailingConditionShowsItsValueAndWhatItReads) {
  EXPECT_EQ(events("Start: {n = 3;}\n", "A(1)", "A(l) : l > n && Q < Z --> F\nA(l) : l - n --> B\n", 0),
            "What happened: model.l:6:1 fired.\n"
            "  A(l) : l - n --> B\n"
            "It made: B\n"
            "\n"
            "Productions that begin with 'A', in the order of the file:\n"
            "  model.l:5:1: A(l) : l > n && Q < Z --> F\n"
            "    failed: the condition 'l > n && Q < Z' is 0 with l = 1, n = 3, Q = 1, Z = 100\n"
            "  model.l:6:1: A(l) : l - n --> B\n"
            "    applied: the condition 'l - n' is -2 with l = 1, n = 3\n");
}

TEST(Explanation, ContextsShowWhatTheySawOverBranches) {
  // + is ignored, the branch is skipped to the left and to the right, A's own branch has C first
  EXPECT_EQ(events("ignore: +\n", "B(2)[C]+A(1)[C]B(0.5)",
                   "C < A(l) --> X\nA(l) > C --> Y\nA(l) > B(x)C --> Y\nB(y) < A(l) > [C]B(x) : x < 1 --> F(l+y)\n", 5),
            "What happened: model.l:8:1 fired.\n"
            "  B(y) < A(l) > [C]B(x) : x < 1 --> F(l+y)\n"
            "It made: F(3)\n"
            "\n"
            "Productions that begin with 'A', in the order of the file:\n"
            "  model.l:5:1: C < A(l) --> X\n"
            "    left context: wants C, saw B(2) (module 0)\n"
            "    failed: the left context does not match\n"
            "  model.l:6:1: A(l) > C --> Y\n"
            "    right context: wants C, saw B(0.5) (module 9)\n"
            "    failed: the right context does not match\n"
            "  model.l:7:1: A(l) > B(x)C --> Y\n"
            "    right context: wants B(x), saw B(0.5) (module 9)\n"
            "    right context: wants C, reached the end of the string\n"
            "    failed: the right context does not match\n"
            "  model.l:8:1: B(y) < A(l) > [C]B(x) : x < 1 --> F(l+y)\n"
            "    right context: wants [, saw [ (module 6)\n"
            "    right context: wants C, saw C (module 7)\n"
            "    right context: wants ], saw ] (module 8)\n"
            "    right context: wants B(x), saw B(0.5) (module 9)\n"
            "    left context: wants B(y), saw B(2) (module 0)\n"
            "    applied: the condition 'x < 1' is 1 with l = 1, y = 2, x = 0.5\n");
}

TEST(Explanation, AContextModuleWithAnotherNumberOfParametersIsSaid) {
  const std::string text = events("", "B(1)A", "B < A --> X\nA < A --> X\n", 1);
  EXPECT_TRUE(contains(text, "left context: wants B, saw B(1) (module 0): another number of parameters\n")) << text;
  const std::string first = events("", "AB", "B < A --> X\n", 0);
  EXPECT_TRUE(contains(first, "left context: wants B, reached the beginning of the string\n")) << first;
}

TEST(Explanation, StochasticChoiceShowsWeightsAndDraw) {
  // in the compatible mode the draw of position 0 is the first of the selection stream, which seed 7 begins
  const std::string model =
      modelText("seed: 7\n", "AB", "A --> AA : 2\nA --> AB : 3*Q\nA --> C\nB : 0 --> C\nB --> D\n");
  DerivedModel derived(model, {}, core::Compatibility::Cpfg);
  core::SequentialRandom stream = derived.state().random.selection;
  const double draw = stream.uniform();
  std::string drawText;
  core::appendNumber(drawText, draw, core::NumberStyle::Shortest);
  const std::string text = explained(model, 0, 0, core::Compatibility::Cpfg);
  EXPECT_TRUE(contains(text, "    weight 2\n")) << text;
  EXPECT_TRUE(contains(text, "    weight 3*Q = 3\n")) << text;
  EXPECT_TRUE(contains(text, "    weight 1 (none is given)\n")) << text;
  EXPECT_TRUE(contains(text, "choice: the draw " + drawText + " times the sum of weights 6 is ")) << text;
  const char* chosen = draw * 6 <= 2 ? "model.l:5:1" : draw * 6 <= 5 ? "model.l:6:1" : "model.l:7:1";
  EXPECT_TRUE(contains(text, std::string("which selects ") + chosen + "\n")) << text;
  EXPECT_TRUE(contains(text, std::string("What happened: ") + chosen + " fired")) << text;
  EXPECT_TRUE(contains(explained(model, 0, 1), "  choice: only one production applies, so nothing is drawn\n"));
}

TEST(Explanation, AModuleWithoutProductionIsCopied) {
  EXPECT_EQ(events("", "A+(30)", "A --> A\n", 1),
            "What happened: no production applies; the module was copied.\n"
            "\n"
            "Productions: none begins with '+'\n");
  const std::string drawn = events("", "AK", "A --> A\nhomomorphism\nK --> F\n", 1);
  EXPECT_TRUE(contains(drawn, "The homomorphism has productions for it; they apply when the string is drawn")) << drawn;
}

TEST(Explanation, AModuleInsideAPredecessorOfSeveralModules) {
  EXPECT_EQ(events("", "AB(2)AC", "AB(x) --> F(x)\nA --> A\n", 1),
            "What happened: model.l:4:1 fired.\n"
            "  AB(x) --> F(x)\n"
            "Its predecessor is 2 modules, 0 to 1; this one is number 2 of them.\n"
            "It made: F(2)\n"
            "\n"
            "Productions that begin with 'A', in the order of the file:\n"
            "  model.l:4:1: AB(x) --> F(x)\n"
            "    applied with x = 2\n"
            "  model.l:5:1: A --> A\n"
            "    not tried: an earlier production applied\n");
  const std::string failed = events("", "AB(2)AC", "AB(x) --> F(x)\nA --> A\n", 2);
  EXPECT_TRUE(contains(failed, "failed: module 2 of its predecessor is B(x), the string has C (module 3)\n")) << failed;
}

TEST(Explanation, DecompositionIsShownLevelByLevel) {
  EXPECT_EQ(
      events("", "A", "A --> D(3)\ndecomposition no warnings\nmaximum depth: 2\nD(k) : k > 0 --> GD(k-1)\n", 0),
      "What happened: model.l:4:1 fired.\n"
      "  A --> D(3)\n"
      "It made: GGD(1)\n"
      "\n"
      "Productions that begin with 'A', in the order of the file:\n"
      "  model.l:4:1: A --> D(3)\n"
      "    applied\n"
      "    made, before its decomposition: D(3)\n"
      "\n"
      "Decomposition of D(3): productions that begin with 'D', in the order of the file:\n"
      "  model.l:7:1: D(k) : k > 0 --> GD(k-1)\n"
      "    applied: the condition 'k > 0' is 1 with k = 3\n"
      "    made: GD(2)\n"
      "\n"
      "Decomposition of D(2), made by 1 decomposition: productions that begin with 'D', in the order of the file:\n"
      "  model.l:7:1: D(k) : k > 0 --> GD(k-1)\n"
      "    applied: the condition 'k > 0' is 1 with k = 2\n"
      "    made: GD(1)\n"
      "\n"
      "Decomposition of D(1), made by 2 decompositions: not tried, the maximum depth is 2\n");
  // a module without a production of its own is decomposed too
  const std::string alone = events("", "AD(1)", "A --> A\ndecomposition\nD(k) : k > 0 --> GD(k-1)\n", 1);
  EXPECT_TRUE(contains(alone, "What happened: model.l:6:1 fired (decomposition).\n")) << alone;
  EXPECT_TRUE(contains(alone, "Productions: none begins with 'D'\n")) << alone;
}

TEST(Explanation, CutsAreNamed) {
  EXPECT_EQ(
      events("", "A[%BC]D", "A --> A\n", 4),
      "What happened: it was cut away. % (module 2), a cut symbol without a production, removed the modules right "
      "of it in "
      "its branch.\n");
  EXPECT_TRUE(
      contains(events("", "A[%BC]D", "A --> A\n", 2), "the cut symbol removed itself and the modules right of it"));
  // also where the string is produced from right to left, and what is cut was rewritten before
  const std::string backwards = events("", "A[%AC]D", "A >> D --> A\nA --> B\n", 3);
  EXPECT_TRUE(contains(backwards, "it was cut away. % (module 2)")) << backwards;
}

TEST(Explanation, SideEffectsBeforeTheModuleHaveHappened) {
  // every A counts; the third sees 2 counted before it
  const std::string text = events("Start: {n = 0;}\n", "AAA", "A : {n = n + 1;} n > 2 --> B\n", 2);
  EXPECT_TRUE(contains(text, "applied: the condition 'n > 2' is 1 with n = 3\n")) << text;
}

TEST(Explanation, AModuleThatDoesNotExistIsAnError) {
  EXPECT_EQ(explained(modelText("", "AB", "A --> A\n"), 0, 2),
            "error: there is no module 2 in the string of step 0: it has 2 modules, numbered 0 to 1");
  EXPECT_EQ(explained(modelText("", "A", "A --> *\n"), 1, 0),
            "error: there is no module 0 in the string of step 1: it is empty");
}

TEST(Explanation, AStepThatFailsIsExplainedUpToTheFailure) {
  const std::string model = modelText("", "A(1)B(1)C", "B(x) --> B(log(x-1)*0)\n");
  EXPECT_TRUE(contains(explained(model, 0, 0), "\nThe step failed: step 1, plant 0, module 1 "))
      << explained(model, 0, 0);
  EXPECT_TRUE(contains(explained(model, 0, 1), "What happened: the step failed while this module was rewritten.\n"));
  EXPECT_TRUE(contains(explained(model, 0, 2), "error: step 1, plant 0, module 1 "));
}

TEST(Explanation, MacrosAndIncludesKeepTheirPlace) {
  const std::string text =
      explained("#define GROW F(l)A(l)\nLsystem: 1\nAxiom: A(1)\nA(l) --> GROW\nendlsystem\n", 0, 0);
  EXPECT_TRUE(contains(text, "What happened: model.l:4:1 fired.\n")) << text;
}

TEST(Explanation, ARecordedStepMakesTheSameStringAsAnUnrecordedOne) {
  const std::string model =
      modelText("seed: 3\n", "A(1)BA(2)[B%AB]C",
                "A(l) : l < 8 --> A(l+ran(1))B : 2\nA(l) --> B[A(l/2)]\nB < B --> C\nBC --> A(1)%\nC > B --> B\n");
  for (const core::Compatibility mode : {core::Compatibility::Espalier, core::Compatibility::Cpfg}) {
    DerivedModel plain(model, {}, mode);
    DerivedModel recorded(model, {}, mode);
    for (int i = 0; i < 6; ++i) {
      plain.steps(1);
      ModuleRecord record;
      record.module = static_cast<std::uint64_t>(i);
      recorded.derivation().deriveRecorded(recorded.state(), record);
      EXPECT_EQ(plain.text(), recorded.text());
    }
  }
}

}  // namespace
}  // namespace espalier::derivation::explanation_test
