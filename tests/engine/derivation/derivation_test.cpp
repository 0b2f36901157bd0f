#include "engine/derivation/derivation.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <map>

#include "engine/derivation/state/string_text.h"
#include "tests/support/derived_model.h"

namespace espalier::derivation_test {
namespace {

using core::Compatibility;
using core::SimulationErrorCode;
using test::derive;
using test::DerivedModel;
using test::modelText;

TEST(Derivation, RewritesAllModulesAtOnce) {
  EXPECT_EQ(derive(modelText("", "A", "A --> AB\nB --> A\n"), 5), "ABAABABAABAAB");
}

TEST(Derivation, CopiesModulesWithoutProductionWithTheirParameters) {
  EXPECT_EQ(derive(modelText("", "A(1)x(2,3,4,5,6,7)[y]", "A(n) --> A(n+1)\n"), 2), "A(3)x(2,3,4,5,6,7)[y]");
}

TEST(Derivation, FirstMatchInFileOrderWins) {
  EXPECT_EQ(derive(modelText("", "A(1)A(5)", "A(x) : x>3 --> b\nA(x) --> c\nA(x) --> d\n"), 1), "cb");
}

TEST(Derivation, ErasedStringStaysEmpty) {
  EXPECT_EQ(derive(modelText("", "AA", "A --> *\n"), 3), "");
}

TEST(Derivation, ConsumesTheWholeStrictPredecessor) {
  EXPECT_EQ(derive(modelText("", "AAB", "AB --> x\nA --> y\nB --> z\n"), 1), "yx");
}

TEST(Derivation, RunsPreBlocksOfCandidatesWhoseContextMatchesUntilOneApplies) {
  const std::string rest =
      "A : {n=n+1;} 0 --> x\nB < A : {n=n+10;} 0 --> x\nA : {n=n+100;} * {n=n+1000;} --> A(n)\nA : {n=n+10000;} * --> "
      "x\n";
  EXPECT_EQ(derive(modelText("Start: {n=0;}\n", "A", rest), 1), "A(1101)");
}

TEST(Derivation, RunsTheBlocksOfAStepInOrder) {
  DerivedModel model(
      "Lsystem: 1\nderivation length: 2\nStart: {printf(\"start \");}\nStartEach: {printf(\"before%g \",Q);}\n"
      "EndEach: {printf(\"after \");}\nEnd: {printf(\"end\");}\nAxiom: A\n"
      "A : {printf(\"A \");} * --> AA\nendlsystem\n");
  model.steps(2);
  EXPECT_EQ(model.printed(), "start before1 A after before2 A A after end");
  EXPECT_TRUE(model.state().isStopped);
}

TEST(Derivation, OptionReplacesTheDerivationLength) {
  derivation::DerivationOptions options;
  options.derivationLength = 1;
  DerivedModel model(modelText("End: {printf(\"end %g\",Z);}\n", "A", "A --> A\n"), options);
  model.steps(1);
  EXPECT_EQ(model.printed(), "end 1");
}

TEST(Derivation, KeepsProductionLocalVariables) {
  EXPECT_EQ(derive(modelText("", "AA", "A : {n=n+1;} * --> Ax(n)\n"), 2), "Ax(3)x(1)Ax(4)x(2)");
}

TEST(Derivation, CutRemovesTheRestOfTheBranch) {
  EXPECT_EQ(derive(modelText("", "A[B%C[D]E]F", "Z --> Z\n"), 1), "A[B]F");
  EXPECT_EQ(derive(modelText("", "A%C[D]E]F", "Z --> Z\n"), 1), "A]F");
  EXPECT_EQ(derive(modelText("", "AJB", "J --> j%\n"), 1), "Aj%B");
  EXPECT_EQ(derive(modelText("", "A%B", "% --> x\n"), 1), "AxB");
}

TEST(Derivation, CutWithParameterMovesThePartToTheEnd) {
  EXPECT_EQ(derive(modelText("", "A[B%(5)C(1)D]E%(6,0)F", "Z --> Z\n"), 1), "A[B]E%(6,0)F%(5,1)C(1)D");
  // no %(p,n) need stand in the text
  EXPECT_EQ(derive(modelText("", "A[B%(5)C]%(2)DE", "Z --> Z\n"), 1), "A[B]%(5,0)C%(2,1)DE");
}

TEST(Derivation, DecomposesSuccessorsAndUnmatchedModulesDepthFirst) {
  const std::string rest =
      "M --> PM\ndecomposition\nmaximum depth: 3\nP --> QR\nQ --> q\nR --> r\nT(n) : n>0 --> T(n-1)t\n";
  EXPECT_EQ(derive(modelText("", "T(5)M", rest), 1), "T(2)tttqrM");
}

TEST(Derivation, DecompositionLooksAtTheOldString) {
  EXPECT_EQ(derive(modelText("", "aMb", "M --> PMP\na --> d\ndecomposition\na < P > b --> Q\nM < P --> V\n"), 1),
            "dQMQb");
}

TEST(Derivation, WarnsOnceWhenTheDepthStopsADecomposition) {
  DerivedModel model(modelText("", "A", "Z --> Z\ndecomposition\nmaximum depth: 2\nA --> AA\n"));
  EXPECT_EQ(model.steps(2), "AAAAAAAAAAAAAAAA");
  ASSERT_EQ(model.warnings().size(), 1U);
  EXPECT_NE(model.warnings()[0].find("model.l:7:1"), std::string::npos) << model.warnings()[0];
  EXPECT_NE(model.warnings()[0].find("the maximum depth of 2 was reached while 'A --> AA' still applies"),
            std::string::npos)
      << model.warnings()[0];
  DerivedModel silent(modelText("", "A", "Z --> Z\ndecomposition no warnings\nmaximum depth: 2\nA --> AA\n"));
  silent.steps(1);
  EXPECT_TRUE(silent.warnings().empty());
}

TEST(Derivation, StochasticChoiceFollowsTheWeights) {
  std::string axiom(20000, 'A');
  DerivedModel model(modelText("Seed: 5\n", axiom, "A --> a : 1\nA --> b : 2\nA --> c : 5\nA --> d : 0\n"));
  const std::string text = model.steps(1);
  std::map<char, double> counts;
  for (const char c : text) {
    counts[c] += 1.0;
  }
  EXPECT_EQ(counts.count('d'), 0U);
  // five standard deviations of a binomial count
  const auto near = [&](char c, double p) {
    EXPECT_NEAR(counts[c], 20000 * p, 5.0 * std::sqrt(20000 * p * (1 - p))) << c;
  };
  near('a', 1.0 / 8);
  near('b', 2.0 / 8);
  near('c', 5.0 / 8);
}

TEST(Derivation, SeedAndPlantNameTheRun) {
  const std::string text = modelText("Seed: 5\n", "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA", "A --> a\nA --> b\n");
  const auto run = [&](std::uint64_t seed, bool hasSeed, std::uint32_t plant) {
    derivation::DerivationOptions options;
    options.seed = seed;
    options.hasSeed = hasSeed;
    options.plant = plant;
    return DerivedModel(text, options).steps(1);
  };
  EXPECT_EQ(run(0, false, 0), run(5, true, 0));
  EXPECT_EQ(run(99, false, 0), run(5, true, 0));
  EXPECT_NE(run(6, true, 0), run(5, true, 0));
  EXPECT_NE(run(5, true, 1), run(5, true, 0));
}

TEST(Derivation, ReferenceSelectionStreamUsesTheLow16BitsOfTheSeed) {
  const auto run = [](const std::string& seed, Compatibility compatibility) {
    return derive(modelText("Seed: " + seed + "\n", "JJJJJJJJ", "J --> Ja : 1\nJ --> Jb : 2\nJ --> Jc : 5\n"), 4,
                  compatibility);
  };
  // recorded from the reference program
  EXPECT_EQ(run("17", Compatibility::Cpfg), "JacccJbcccJabcbJcccaJcaaaJccacJabbcJcccc");
  EXPECT_EQ(run("65553", Compatibility::Cpfg), run("17", Compatibility::Cpfg));
  EXPECT_EQ(run("17", Compatibility::CpfgBatch), run("18", Compatibility::CpfgBatch));
}

TEST(Derivation, CompatibleModesStoreFloats) {
  const std::string text = modelText("", "A(0.1)", "A(x) --> A(x+0.2)\n");
  DerivedModel compatible(text, {}, Compatibility::Cpfg);
  compatible.steps(1);
  EXPECT_EQ(compatible.state().string.parameters()[0], static_cast<double>(static_cast<float>(0.1F + 0.2)));
  DerivedModel own(text);
  own.steps(1);
  EXPECT_EQ(own.state().string.parameters()[0], 0.1 + 0.2);
}

TEST(Derivation, NonFiniteParametersFailInEspaliersOwnModeOnly) {
  const std::string text = modelText("", "C(4)B(4)", "B(l) --> B(l^1000^2)\nC(x) --> C(x+1)\n");
  DerivedModel model(text);
  const core::SimulationError error = model.failingStep();
  EXPECT_EQ(error.code, SimulationErrorCode::NonFinite);
  EXPECT_EQ(error.step, 1U);
  EXPECT_EQ(error.module, std::optional<std::uint64_t>(1));
  EXPECT_EQ(error.location.line, 4U);
  EXPECT_EQ(error.location.column, 12U);
  EXPECT_EQ(error.message,
            "step 1, plant 0, module 1 ('B', model.l:4:12): parameter 1 became infinite in 'l^1000^2'. The simulation "
            "stays at step 0.");
  // nothing has changed
  EXPECT_EQ(model.text(), "C(4)B(4)");
  EXPECT_EQ(model.state().step, 0U);
  EXPECT_EQ(derive(text, 1, Compatibility::Cpfg), "C(5)B(inf)");
}

TEST(Derivation, NonFiniteMessagesNameTheModuleThatWasMade) {
  DerivedModel model(modelText("", "A(-1)", "A(x) --> B(1,sqrt(x))\n"));
  EXPECT_EQ(model.failingStep().message,
            "step 1, plant 0, module 0 ('A', model.l:4:14): parameter 2 of 'B' became NaN in 'sqrt(x)'. The simulation "
            "stays at step 0.");
}

TEST(Derivation, FailedStepLeavesVariablesAndStreamsAsTheyWere) {
  DerivedModel model(modelText("Start: {n=0;}\n", "A(2)", "A(x) : {n=n+1; m=m+1; y=ran(1);} * --> A(10^(x^9))\n"), {},
                     Compatibility::Espalier);
  derivation::PlantState before = model.state();
  EXPECT_EQ(model.failingStep().code, SimulationErrorCode::NonFinite);
  EXPECT_EQ(model.state().statics, before.statics);
  EXPECT_EQ(model.state().instances[0].variables, before.instances[0].variables);
  EXPECT_EQ(model.state().step, before.step);
  // failing is repeatable
  EXPECT_EQ(model.failingStep().code, SimulationErrorCode::NonFinite);
}

TEST(Derivation, StopsAtTheModuleLimit) {
  derivation::DerivationOptions options;
  options.limits.maximumModules = 1000;
  DerivedModel model(modelText("", "A", "A --> AA\n"), options);
  model.steps(9);
  const core::SimulationError error = model.failingStep();
  EXPECT_EQ(error.code, SimulationErrorCode::LimitExceeded);
  EXPECT_EQ(error.message,
            "step 10, plant 0: the string has more than 1000 modules (limit modules). The simulation stays at step "
            "9.");
  EXPECT_EQ(model.state().string.size(), 512U);
}

TEST(Derivation, StopsADecompositionBombWithinTheLimit) {
  derivation::DerivationOptions options;
  options.limits.maximumModules = 100'000;
  DerivedModel model(modelText("", "A", "Z --> Z\ndecomposition\nmaximum depth: 1000\nA --> AA\n"), options);
  EXPECT_EQ(model.failingStep().code, SimulationErrorCode::LimitExceeded);
  DerivedModel deep(modelText("", "A", "Z --> Z\ndecomposition\nmaximum depth: 20000\nA --> A\n"), {});
  const core::SimulationError error = deep.failingStep();
  EXPECT_EQ(error.code, SimulationErrorCode::LimitExceeded);
  EXPECT_NE(error.message.find("the nested rewriting is deeper than 10000 (limit recursion)"), std::string::npos)
      << error.message;
}

TEST(Derivation, DecompositionReachesTheRecursionLimitAndNoFurther) {
  derivation::DerivationOptions options;
  options.limits.maximumRecursion = 5;
  const auto axiom = [](int levels, int count) {
    std::string text;
    for (int i = 0; i < count; ++i) {
      text += "A(" + std::to_string(levels) + ")";
    }
    return text;
  };
  const std::string rest = "Z --> Z\ndecomposition\nmaximum depth: 100\nA(n) : n > 0 --> A(n-1)\n";
  // a short string and one that is derived in chunks
  for (const int count : {1, 3000}) {
    DerivedModel reaching(modelText("", axiom(5, count), rest), options);
    reaching.steps(1);
    EXPECT_EQ(reaching.state().string.parameters()[0], 0.0);
    DerivedModel beyond(modelText("", axiom(6, count), rest), options);
    EXPECT_NE(beyond.failingStep().message.find("deeper than 5 (limit recursion)"), std::string::npos) << count;
  }
}

TEST(Derivation, StopsAtTheByteLimit) {
  derivation::DerivationOptions options;
  options.limits.maximumStringBytes = 1000;
  DerivedModel model(modelText("", "A(1)", "A(x) --> A(x)A(x)\n"), options);
  model.steps(6);
  EXPECT_NE(model.failingStep().message.find("the string needs more than 1000 bytes (limit stringBytes)"),
            std::string::npos);
}

TEST(Derivation, RefusesModulesWithTooManyParameters) {
  derivation::DerivationOptions options;
  options.limits.maximumArity = 2;
  try {
    DerivedModel model(modelText("", "A(1,2,3)", "B --> B\n"), options);
    FAIL();
  } catch (const core::SimulationFailure& failure) {
    EXPECT_EQ(failure.error().message, "step 0, plant 0: the module 'A' has 3 parameters, more than 2 (limit arity).");
  }
}

TEST(Derivation, StopsWhenCancelled) {
  std::atomic<bool> cancelled{false};
  derivation::DerivationOptions options;
  options.cancelled = &cancelled;
  DerivedModel model(modelText("", "A", "A --> AA\n"), options);
  model.steps(3);
  cancelled = true;
  EXPECT_EQ(model.failingStep().code, SimulationErrorCode::Cancelled);
  EXPECT_EQ(model.state().step, 3U);
  cancelled = false;
  EXPECT_EQ(model.steps(1).size(), 16U);
}

TEST(Derivation, CancelsEndlessLoops) {
  std::atomic<bool> cancelled{true};
  derivation::DerivationOptions options;
  options.cancelled = &cancelled;
  options.limits.maximumLoopIterations = 1'000'000'000'000;
  DerivedModel model(modelText("StartEach: {while (1) {x=x+1;} }\n", "A", "A --> A\n"), options);
  EXPECT_EQ(model.failingStep().code, SimulationErrorCode::Cancelled);
}

TEST(Derivation, ContinuesFromACopyOfTheState) {
  const std::string text =
      modelText("Seed: 3\nStart: {n=1;}\n", "A(1)B",
                "A(x) : {n=n+ran(1);} * --> A(x+n)B : 2\nA(x) --> A(ran(x))\nB --> BA(nran(1,2))\n");
  for (const Compatibility compatibility : {Compatibility::Espalier, Compatibility::Cpfg}) {
    DerivedModel whole(text, {}, compatibility);
    const std::string expected = whole.steps(6);
    DerivedModel first(text, {}, compatibility);
    first.steps(3);
    derivation::PlantState copy = first.state();
    derivation::Derivation second(whole.program(), {});
    for (int i = 0; i < 3; ++i) {
      second.derive(copy);
    }
    EXPECT_EQ(derivation::toText(whole.program(), copy.string, derivation::numberStyle(compatibility)), expected);
  }
}

TEST(Derivation, RewindStartsOver) {
  DerivedModel model(
      modelText("Seed: 3\nStart: {n=1;}\n", "A(n)", "A(x) : {n=n+1;} * --> A(n)A(ran(1))\nA(x) --> B\n"));
  const std::string first = model.steps(4);
  model.derivation().rewind(model.state());
  EXPECT_EQ(model.text(), "A(1)");
  EXPECT_EQ(model.steps(4), first);
}

TEST(Derivation, DrawsDependOnTheModuleAlone) {
  // the same module at the same index and step draws the same number whatever stands behind it
  const std::string rest = "A --> B(ran(1),ran(1))\n";
  const std::string one = derive(modelText("", "xA", rest), 1);
  const std::string two = derive(modelText("", "xAA", rest), 1);
  EXPECT_EQ(two.substr(0, one.size()), one);
  EXPECT_NE(two.substr(one.size()), one.substr(1));
}

std::string image(DerivedModel& model, std::uint64_t module, std::uint64_t offset) {
  derivation::ModuleString string;
  model.derivation().beginInterpretation(model.state());
  static_cast<void>(model.derivation().expand(model.state(), 0, module, offset, string));
  model.derivation().endInterpretation(model.state());
  return derivation::toText(model.program(), string, core::NumberStyle::Shortest);
}

TEST(Derivation, ExpandsHomomorphismsToTheMaximumDepth) {
  DerivedModel model(
      modelText("", "xA(4)", "x --> x\nhomomorphism no warnings\nmaximum depth: 3\nA(n) : n>0 --> F(n)A(n-1)%G\n"));
  EXPECT_TRUE(model.derivation().hasHomomorphism());
  EXPECT_EQ(image(model, 0, 0), "");
  EXPECT_EQ(image(model, 1, 0), "F(4)F(3)F(2)A(1)GGG");
}

TEST(Derivation, AHomomorphismBombNamesItsProductionAndDepth) {
  derivation::DerivationOptions options;
  options.limits.maximumModules = 1000;
  const std::string text = modelText("", "xA(2)", "x --> x\nhomomorphism\nmaximum depth: 30\nA(n) --> A(n)A(n+1)\n");
  const auto messageOf = [&text](const derivation::DerivationOptions& limited) -> std::string {
    DerivedModel model(text, limited);
    try {
      return image(model, 1, 0);
    } catch (const core::SimulationFailure& failure) {
      return failure.error().message;
    }
  };
  EXPECT_EQ(
      messageOf(options),
      "step 1, plant 0, module 1 ('A', model.l:7:1): the output of the homomorphism for this module, at depth 30, "
      "has more than 1000 modules (limit modules). The simulation stays at step 0.");
  options.limits.maximumModules = 100'000;
  options.limits.maximumStringBytes = 5000;
  EXPECT_EQ(
      messageOf(options),
      "step 1, plant 0, module 1 ('A', model.l:7:1): the output of the homomorphism for this module, at depth 30, "
      "needs more than 5000 bytes (limit stringBytes). The simulation stays at step 0.");
  options.limits = {};
  options.limits.maximumHomomorphismModules = 500;
  EXPECT_EQ(
      messageOf(options),
      "step 1, plant 0, module 1 ('A', model.l:7:1): the output of the homomorphism for this module, at depth 30, "
      "has more than 500 modules (limit homomorphismModules): a smaller 'maximum depth' ends it earlier. The "
      "simulation stays at step 0.");
}

TEST(Derivation, HomomorphismSeesTheRealStringAndConsumesItsPredecessor) {
  DerivedModel model(
      modelText("", "ABBA", "x --> x\nhomomorphism\nmaximum depth: 2\nAB --> XB\nB < B --> F\nX > B --> Y\n"));
  derivation::ModuleString string;
  model.derivation().beginInterpretation(model.state());
  EXPECT_EQ(model.derivation().expand(model.state(), 0, 0, 0, string), 2U);
  EXPECT_EQ(model.derivation().expand(model.state(), 0, 2, 0, string), 1U);
  EXPECT_EQ(model.derivation().expand(model.state(), 0, 3, 0, string), 0U);
  model.derivation().endInterpretation(model.state());
  EXPECT_EQ(derivation::toText(model.program(), string, core::NumberStyle::Shortest), "YBF");
}

TEST(Derivation, HomomorphismSeedGivesItAStreamOfItsOwn) {
  for (const Compatibility compatibility : {Compatibility::Espalier, Compatibility::Cpfg}) {
    DerivedModel model(modelText("Start: {srand(9);}\n", "A", "B --> B\nhomomorphism\nseed: 4\nA --> F(ran(1))\n"), {},
                       compatibility);
    const derivation::RandomState before = model.state().random;
    const std::string first = image(model, 0, 0);
    model.steps(2);
    EXPECT_EQ(image(model, 0, 0), first);
    EXPECT_EQ(model.state().random.main.state(), before.main.state());
    EXPECT_EQ(model.state().random.mainSeed, before.mainSeed);
  }
}

}  // namespace
}  // namespace espalier::derivation_test
