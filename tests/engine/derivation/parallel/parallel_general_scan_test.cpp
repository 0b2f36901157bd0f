#include <gtest/gtest.h>

#include <string>

#include "tests/support/derived_model.h"

namespace espalier::parallel_general_scan_test {
namespace {

using test::DerivedModel;

derivation::DerivationOptions onThreads(unsigned threads) {
  derivation::DerivationOptions options;
  options.seed = 7;
  options.hasSeed = true;
  options.threads = threads;
  options.threadedModules = 1;
  return options;
}

/// `count` modules made by `pattern`, whose # is the number of the repetition modulo 10.
std::string repeated(const std::string& pattern, int count) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    for (const char letter : pattern) {
      text += letter == '#' ? std::to_string(i % 10) : std::string(1, letter);
    }
  }
  return text;
}

/// The models: one thread, two and four must make the same of them, with the same warnings.
void expectEqualOnThreads(const std::string& text, std::uint64_t stepCount) {
  for (const unsigned threads : {2U, 4U}) {
    DerivedModel many(text, onThreads(threads));
    DerivedModel expected(text, onThreads(1));
    const std::string axiom = expected.text();
    for (std::uint64_t step = 1; step <= stepCount; ++step) {
      expected.steps(1);
      many.steps(1);
      ASSERT_TRUE(expected.text() == many.text()) << threads << " threads, step " << step;
    }
    EXPECT_NE(expected.text(), axiom);
    EXPECT_EQ(expected.warnings(), many.warnings());
  }
}

TEST(ParallelGeneralScan, DecompositionIsTheSame) {
  expectEqualOnThreads(
      test::modelText(
          "", repeated("M(#)[N(#)]", 900),
          "M(x) --> M(x+4)\nN(x) < P(y) --> P(y+x)\nP(x) : x>3 --> *\nM(x) > N(y) : y==3 --> M(x)N(y)\n"
          "decomposition\nmaximum depth: 5\nM(x) : x>=10 --> M(x-4)P(1)\nP(x) : x<3 --> P(x+nran(1,0.1))\n"),
      5);
}

TEST(ParallelGeneralScan, DrawsOfEveryKindAreTheSame) {
  expectEqualOnThreads(
      test::modelText("Seed: 5\n", repeated("A(#)B(#,1)C", 1500),
                      "A(x) : ran(1)<0.5 --> A(nran(x,1)) : ran(2)\nA(x) --> A(x+bran(2,3)) : 1\n"
                      "B(x,y) : x>ran(9) --> B(biran(9,0.5),y)C : 2\nB(x,y) --> B(x+1,y>1 ? ran(1) : y+1) : 1\n"),
      5);
}

TEST(ParallelGeneralScan, PredecessorsOfSeveralModulesReachOverChunks) {
  // no place is safe: every module may be inside a predecessor
  expectEqualOnThreads(test::modelText("", "AB" + repeated("A", 1000) + repeated("BAAB", 700),
                                       "A B A --> BBA\nB A --> AB\nA A --> AC\n"),
                       6);
  expectEqualOnThreads(test::modelText("", repeated("FFF(#)GH", 1000), "F F(x) --> F(x+1)F\nG H --> HG\nH G --> GH\n"),
                       6);
}

TEST(ParallelGeneralScan, WhatIsCutMayReachOverManyChunks) {
  expectEqualOnThreads(test::modelText("", repeated("[F(#)C(#)" + repeated("F", 170) + "]", 60),
                                       "C(x) : x>6 --> %\nC(x) --> C(x+1)\nF --> F\nF F(x) --> F(x)F\n"),
                       8);
  // the first cut drops 9,000 modules
  expectEqualOnThreads(test::modelText("", "[C(1)[" + repeated("F(#)[G]", 2500) + "]F]" + repeated("F(#)H", 900),
                                       "C(x) : x==3 --> %\nC(x) --> C(x+1)\nF(x) --> F(nran(x,2))\n"),
                       5);
}

TEST(ParallelGeneralScan, PartsThatAreKeptStandInTheirOrder) {
  expectEqualOnThreads(test::modelText("", repeated("[F(#)C(#)F(1)F(2)]", 800) + "%(0,0)",
                                       "C(x) : x>6 --> %(x)\nC(x) --> C(x+1)\nF(x) F --> F(x)F\n"),
                       6);
}

TEST(ParallelGeneralScan, VariablesAreRead) {
  expectEqualOnThreads(
      test::modelText("Define: {array weights[3] = {1,2,3};}\nStart: {grown=1;}\nStartEach: {grown=grown*1.5;}\n",
                      repeated("A(#)", 3000), "A(x) : x<grown --> A(x+weights[x%3])\n"),
      5);
}

TEST(ParallelGeneralScan, EveryPlaceWarnsOnce) {
  // one place divides by 0 in the first chunk, the other in the last: both are reported, each once
  const std::string text = test::modelText("", "B(0)" + repeated("A(1)GH", 1500) + "A(0)B(0)A(0)",
                                           "A(x) --> A(2/x)\nB(x) --> B(3/x)\nG H --> HG\n");
  for (const unsigned threads : {1U, 2U, 4U}) {
    DerivedModel model(text, onThreads(threads));
    model.steps(2);
    ASSERT_EQ(model.warnings().size(), 2U) << threads;
    EXPECT_NE(model.warnings()[0].find("3/x"), std::string::npos) << model.warnings()[0];
    EXPECT_NE(model.warnings()[1].find("2/x"), std::string::npos) << model.warnings()[1];
  }
}

TEST(ParallelGeneralScan, TheFirstModuleThatFailsIsNamed) {
  const std::string text =
      test::modelText("", repeated("A(1)GH", 900) + "A(0)" + repeated("A(1)GH", 900) + "B(1000)A(0)",
                      "B(x) --> B(exp(x))\nA(x) --> A(log(x))\nG H --> HG\n");
  for (const unsigned threads : {1U, 2U, 4U}) {
    DerivedModel model(text, onThreads(threads));
    const std::string before = model.text();
    EXPECT_EQ(model.failingStep().module, 2700U);
    EXPECT_EQ(model.text(), before);
  }
}

TEST(ParallelGeneralScan, LimitsHoldForTheWholeString) {
  for (const unsigned threads : {1U, 2U, 4U}) {
    derivation::DerivationOptions options = onThreads(threads);
    options.limits.maximumModules = 10000;
    DerivedModel model(
        test::modelText("", repeated("A(#)GH", 1500), "A(x) --> A(ran(1))A(nran(0,1))\nG H --> HGA(1)\n"), options);
    model.steps(1);
    const std::uint64_t size = model.state().string.size();
    const core::SimulationError error = model.failingStep();
    EXPECT_EQ(error.code, core::SimulationErrorCode::LimitExceeded);
    EXPECT_NE(error.message.find("the string has more than 10000 modules (limit modules)"), std::string::npos);
    EXPECT_EQ(model.state().string.size(), size);
  }
}

TEST(ParallelGeneralScan, BlocksAndNewContextsGoModuleByModule) {
  // effects of one module are seen by the next: the order must be that of the string
  expectEqualOnThreads(test::modelText("Start: {counted=0;}\n", repeated("A(#)", 2000),
                                       "A(x) : {counted=counted+1;} 1 --> A(counted)\n"),
                       3);
  expectEqualOnThreads(test::modelText("", repeated("A(#)", 2000), "A(x) << A(y) --> A(x+y)\nA(y) --> A(1)\n"), 3);
  expectEqualOnThreads(test::modelText("", repeated("A(#)", 2000), "A(x) : x<ran(10) --> A(srand(x)+ran(1))\n"), 3);
}

}  // namespace
}  // namespace espalier::parallel_general_scan_test
