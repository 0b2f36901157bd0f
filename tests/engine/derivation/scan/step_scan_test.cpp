// The scan against an independent specification: the plain derivation of tests/support, on models made at random.
#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "engine/derivation/rewrite_record.h"
#include "engine/derivation/state/string_text.h"
#include "tests/engine/derivation/scan/model_maker.h"
#include "tests/support/derived_model.h"
#include "tests/support/plain_derivation.h"

namespace espalier::step_scan_test {
namespace {

using test::DerivedModel;
using test::ModelMaker;
using test::modelText;
using test::PlainDerivation;
using test::PlainModule;
using test::PlainString;

PlainString plainOf(const language::Program& program, const derivation::ModuleString& string) {
  PlainString plain;
  std::size_t offset = 0;
  for (const core::ModuleTypeId type : string.types()) {
    const std::span<const double> parameters = string.parameters().subspan(offset, program.arity[type]);
    plain.push_back(PlainModule{type, {parameters.begin(), parameters.end()}});
    offset += parameters.size();
  }
  return plain;
}

struct Comparison {
  std::size_t stepCount = 0;
  std::size_t changedCount = 0;
  std::size_t keptModules = 0;  // that the changes told to be the same
};

/// How many modules a string is told to have of an older one; that they are the same, in order.
std::size_t keptModules(const derivation::StepChanges& changes, const PlainString& marked, const PlainString& now) {
  std::size_t count = 0;
  std::uint64_t from = 0;
  std::uint64_t to = 0;
  for (const derivation::KeptModules& kept : changes.kept()) {
    EXPECT_TRUE(kept.from >= from && kept.to >= to && kept.from + kept.modules <= marked.size() &&
                kept.to + kept.modules <= now.size());
    from = kept.from + kept.modules;
    to = kept.to + kept.modules;
    const auto place = [](const PlainString& list, std::uint64_t at) {
      return list.begin() + static_cast<std::ptrdiff_t>(at);
    };
    EXPECT_TRUE(std::equal(place(marked, kept.from), place(marked, from), place(now, kept.to)));
    count += kept.modules;
  }
  return count;
}

/// Derives the models made from the seeds [first, first + count) and compares every string.
Comparison compareModels(unsigned first, unsigned count, std::size_t maximumModules, unsigned threads = 1) {
  Comparison result;
  for (unsigned seed = first; seed < first + count; ++seed) {
    const std::string text = ModelMaker(seed).model();
    SCOPED_TRACE("model " + std::to_string(seed) + ":\n" + text);
    derivation::DerivationOptions options;
    options.seed = seed;
    options.hasSeed = true;
    options.threads = threads;
    options.threadedModules = 1;
    DerivedModel model(text, options);
    PlainDerivation plain(model.program(), seed);
    PlainString expected = plain.axiom();
    EXPECT_TRUE(plainOf(model.program(), model.state().string) == expected);
    derivation::StepChanges changes = derivation::StepChanges::nothing(expected.size());
    PlainString marked = expected;
    for (std::uint64_t step = 1; step <= 8 && expected.size() < maximumModules; ++step) {
      // the changes of every step, of every second or every third in a row
      if (step % (1 + seed % 3) == 0) {
        changes = derivation::StepChanges::nothing(expected.size());
        marked = expected;
      }
      const PlainString before = expected;
      expected = plain.derive(before, step);
      derivation::StepChanges ofStep;
      model.derivation().derive(model.state(), &ofStep);
      changes = changes.then(ofStep);
      ++result.stepCount;
      result.changedCount += before == expected ? 0U : 1U;
      if (plainOf(model.program(), model.state().string) != expected) {
        ADD_FAILURE() << "step " << step << " from " << before.size() << " modules made "
                      << model.text().substr(0, 400);
        return result;
      }
      // values that blocks leave belong to the state
      const derivation::InstanceState& instance = model.state().instances.front();
      if (model.state().statics != plain.statics() || instance.variables != plain.variables() ||
          instance.elements != plain.elements()) {
        ADD_FAILURE() << "step " << step << " leaves other variables";
        return result;
      }
      result.keptModules += keptModules(changes, marked, expected);
    }
  }
  return result;
}

TEST(Scan, AgreesWithThePlainDerivationOnRandomModels) {
  const Comparison result = compareModels(0, 2000, 3000);
  // the models must be worth comparing
  EXPECT_GT(result.stepCount, 10000U);
  EXPECT_GT(result.changedCount, 4000U);
  EXPECT_GT(result.keptModules, 10000U);
}

TEST(Scan, AgreesWithThePlainDerivationOnSeveralThreads) {
  // the models that reach several chunks are few, so the strings may become longer here
  EXPECT_GT(compareModels(2000, 150, 20000, 2).changedCount, 300U);
  EXPECT_GT(compareModels(2150, 150, 20000, 4).changedCount, 300U);
}

/// Both ways of one step where the plain derivation knows too little (draws and floats of the compatible mode, rings):
/// the scans, and a recorded step, which goes the general way.
std::size_t compareWithRecordedSteps(unsigned first, unsigned count,
                                     core::Compatibility mode = core::Compatibility::Cpfg,
                                     const std::string& settings = "") {
  std::size_t changedCount = 0;
  for (unsigned seed = first; seed < first + count; ++seed) {
    const std::string text = ModelMaker(seed).model(settings);
    SCOPED_TRACE("model " + std::to_string(seed) + ":\n" + text);
    derivation::DerivationOptions options;
    options.threads = 1 + seed % 3;
    options.threadedModules = 1;
    DerivedModel fast(text, options, mode);
    DerivedModel general(text, options, mode);
    for (int step = 0; step < 8 && fast.state().string.size() < 3000; ++step) {
      const std::string before = fast.text();
      fast.derivation().derive(fast.state());
      derivation::ModuleRecord record;
      general.derivation().deriveRecorded(general.state(), record);
      changedCount += fast.text() == before ? 0U : 1U;
      EXPECT_EQ(fast.text(), general.text());
      EXPECT_EQ(fast.warnings(), general.warnings());
      const auto bitsOf = [](const std::vector<double>& values) {
        return std::string_view(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double));
      };
      if (bitsOf(fast.state().statics) != bitsOf(general.state().statics) || testing::Test::HasFailure()) {
        ADD_FAILURE() << "step " << step;
        return 0;
      }
    }
  }
  return changedCount;
}

TEST(Scan, AgreesWithTheGeneralWayInTheCompatibleMode) {
  EXPECT_GT(compareWithRecordedSteps(0, 400), 800U);
}

TEST(Scan, AgreesWithTheGeneralWayInRings) {
  EXPECT_GT(compareWithRecordedSteps(0, 300, core::Compatibility::Espalier, "Ring Lsystem\n"), 600U);
}

TEST(Scan, AConditionBelowZeroHolds) {
  // short strings are scanned one at a time
  DerivedModel model(modelText("", "A(1)A(2)A(3)", "A(x) : x-2 --> B(x)\n"));
  model.steps(1);
  EXPECT_EQ(model.text(), "B(1)A(2)B(3)");
}

TEST(Scan, ZeroWithAnotherSignIsAChange) {
  DerivedModel model(modelText("", "B(1)A(0)B(2)", "A(x) --> A(-x)\n"));
  derivation::ProductionCounts counts;
  derivation::StepChanges changes;
  model.derivation().derive(model.state(), &changes, &counts);
  std::uint64_t kept = 0;
  for (const derivation::KeptModules& run : changes.kept()) {
    kept += run.modules;
  }
  EXPECT_EQ(kept, 2U);
}

TEST(Scan, AStepThatCountsProductionsMakesTheSameString) {
  std::uint64_t applied = 0;
  std::size_t kept = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    const std::string text = ModelMaker(seed).model();
    SCOPED_TRACE("model " + std::to_string(seed) + ":\n" + text);
    derivation::DerivationOptions options;
    options.threads = 1 + seed % 3;
    options.threadedModules = 1;
    DerivedModel plain(text, options);
    DerivedModel counting(text, options);
    for (int step = 0; step < 8 && plain.state().string.size() < 3000; ++step) {
      const PlainString before = plainOf(plain.program(), plain.state().string);
      plain.derivation().derive(plain.state());
      derivation::ProductionCounts counts;
      derivation::StepChanges changes;
      counting.derivation().derive(counting.state(), &changes, &counts);
      ASSERT_EQ(counting.text(), plain.text());
      ASSERT_EQ(counting.state().statics, plain.state().statics);
      // a string becomes longer by a production; by a cut alone it becomes shorter
      const PlainString after = plainOf(plain.program(), plain.state().string);
      std::uint64_t ofStep = 0;
      for (const auto& [production, count] : counts) {
        ofStep += count;
      }
      ASSERT_TRUE(ofStep > 0 || after.size() <= before.size());
      applied += ofStep;
      kept += keptModules(changes, before, after);
    }
  }
  EXPECT_GT(applied, 10000U);
  EXPECT_GT(kept, 10000U);
}

TEST(Scan, ProductionsAreCountedWithDecompositionAndWithoutHomomorphism) {
  const std::string text =
      modelText("", "AAB", "A --> BC\nB : 1 > 2 --> A\nD --> A\ndecomposition\nC --> FF\nhomomorphism\nF --> GG\n");
  DerivedModel model(text);
  derivation::ProductionCounts counts;
  model.derivation().derive(model.state(), nullptr, &counts);
  EXPECT_EQ(model.text(), "BFFBFFB");
  const language::LSystem& system = model.program().systems.front();
  EXPECT_EQ(counts, (derivation::ProductionCounts{{&system.productions.productions[0], 2},
                                                  {&system.decomposition.productions[0], 2}}));
  // without counts nothing is added
  model.derivation().derive(model.state());
  EXPECT_EQ(counts.size(), 2U);
}

TEST(Scan, DecompositionInBatchesWarnsOnceWhereTheDepthEnds) {
  const std::string text =
      modelText("", "T(7)",
                "T(n) : n>0 --> T(n-1)T(n-1)\nT(n) --> A(0)\nA(x) --> A(x+1)B\ndecomposition\nmaximum depth: 2\n"
                "A(x) : x<100 --> A(x+0.5)C\nC : Q>9 --> CC\n");
  DerivedModel fast(text);
  DerivedModel general(text);
  EXPECT_EQ(fast.derivation().options().threads, 1U);
  for (int step = 0; step < 11; ++step) {
    fast.derivation().derive(fast.state());
    derivation::ModuleRecord record;
    general.derivation().deriveRecorded(general.state(), record);
    EXPECT_EQ(fast.text(), general.text());
  }
  EXPECT_EQ(fast.warnings().size(), 1U);
  EXPECT_EQ(fast.warnings(), general.warnings());
}

TEST(Scan, BlocksThatDrawAndPrintRunInTheOrderOfTheString) {
  const std::string text = modelText("Seed: 3\nStart: {n=0;}\ndefine: {array a[4];}\n", "A(1)B(2)A(3)CB(4)A(5)",
                                     "A(x) : {y=ran(1);} y<0.8 {srand(x+Q); n=n+ran(1); printf(\"%g \",n);} --> A(n)C\n"
                                     "A(x) : x>0 {x=x/2; a[n]=a[n-1]+x;} --> A(x) : a[1]+1\n"
                                     "B(x) : 1 {n=n*x; if (n>9) {n=1; stop(n-1);}} --> B(ran(x))B(a[x])\n"
                                     "C : {printf(\"%g,\",ran(1)/n);} n>2 --> C\nC : n<1 --> *\n");
  for (const core::Compatibility mode : {core::Compatibility::Espalier, core::Compatibility::Cpfg}) {
    DerivedModel fast(text, {}, mode);
    DerivedModel general(text, {}, mode);
    for (int step = 0; step < 8; ++step) {
      fast.steps(1);
      derivation::ModuleRecord record;
      general.derivation().deriveRecorded(general.state(), record);
      ASSERT_EQ(fast.text(), general.text());
    }
    EXPECT_GT(fast.printed().size(), 100U);
    EXPECT_EQ(fast.printed(), general.printed());
    EXPECT_EQ(fast.warnings(), general.warnings());
    EXPECT_EQ(fast.state().instances.front().elements, general.state().instances.front().elements);
    EXPECT_EQ(fast.state().isStopped, general.state().isStopped);
  }
}

TEST(Scan, NoBlockRunsBehindAModuleThatExceedsALimit) {
  std::string axiom(100, 'A');
  derivation::DerivationOptions options;
  options.limits.maximumModules = 150;
  DerivedModel model(modelText("", axiom, "A : 1 {printf(\"x\");} --> AAA\n"), options);
  EXPECT_EQ(model.failingStep().code, core::SimulationErrorCode::LimitExceeded);
  EXPECT_EQ(model.printed(), std::string(51, 'x'));
}

TEST(LongScan, AgreesWithTheGeneralWayInTheCompatibleModes) {
  EXPECT_GT(compareWithRecordedSteps(400, 10000), 20000U);
  EXPECT_GT(compareWithRecordedSteps(10400, 3000, core::Compatibility::CpfgBatch), 6000U);
}

TEST(LongScan, AgreesWithThePlainDerivationOnManyRandomModels) {
  EXPECT_GT(compareModels(2300, 60000, 20000).changedCount, 40000U);
  EXPECT_GT(compareModels(62300, 20000, 20000, 2).changedCount, 10000U);
  EXPECT_GT(compareModels(82300, 20000, 20000, 4).changedCount, 10000U);
}

/// The strings of both derivations after each of some steps.
void expectPlainSteps(const std::string& text, unsigned threads, std::uint64_t stepCount) {
  derivation::DerivationOptions options;
  options.threads = threads;
  options.threadedModules = 64;
  DerivedModel model(text, options);
  PlainDerivation plain(model.program(), options.seed);
  test::PlainString string = plain.axiom();
  for (std::uint64_t step = 1; step <= stepCount; ++step) {
    string = plain.derive(string, step);
    model.steps(1);
    std::vector<core::ModuleTypeId> types;
    std::vector<double> parameters;
    for (const test::PlainModule& module : string) {
      types.push_back(module.type);
      parameters.insert(parameters.end(), module.parameters.begin(), module.parameters.end());
    }
    const auto madeTypes = model.state().string.types();
    const auto madeParameters = model.state().string.parameters();
    ASSERT_EQ(types, std::vector<core::ModuleTypeId>(madeTypes.begin(), madeTypes.end())) << "step " << step;
    ASSERT_EQ(parameters, std::vector<double>(madeParameters.begin(), madeParameters.end())) << "step " << step;
  }
}

TEST(Scan, ProductionsWithTheSameContextsFindTheSameNeighbours) {
  // the conditions of the first and the third refuse; between them stands another context
  std::string axiom;
  for (int i = 0; i < 1200; ++i) {
    const std::string number = std::to_string(i % 9);
    axiom += "I(" + number + ",1)J(" + std::to_string(i % 5) + ")[+K(" + number + ")A(1)]" + (i % 4 == 0 ? "A(2)" : "");
  }
  const std::string productions =
      "I(a,b) < J(c) > [K(d)=] : a<3 && c>1 --> J(c+d)\n"
      "I(a,b) < J(c) > [K(d)A(e)] : a<6 && c<3 --> J(a+e)\n"
      "I(a,b) < J(c) > [K(d)=] : a>7 --> J(0)\n"
      "I(a,b) < J(x) > [K(y)=] : x>3 {z=y*0.5;} --> J(z)\n"
      "J(c) K(a) < A(b) > A(d) : c>2 --> A(a)\nJ(c) K(a) < A(b) > A(d) --> A(b+0.5)\n"
      "I(a,b) J(c) < A(d) --> A(c)\n";
  for (const unsigned threads : {1U, 2U}) {
    expectPlainSteps(test::modelText("ignore: +\n", axiom, productions), threads, 6);
  }
}

TEST(Scan, RulesThatBeginAtTheSameNeighbourGoOnFromThere) {
  // nearest neighbours at both ends of the string, behind branches, behind lone brackets and across chunks
  std::string axiom = "I(1)]J(2)I(3)";
  for (int i = 0; i < 900; ++i) {
    const std::string number = std::to_string(i % 7);
    axiom += "I(" + number + ")" + (i % 3 == 0 ? "J(" + number + ")" : "") + "[+I(2)" +
             (i % 5 == 0 ? "[I(" + number + ")]J(1)" : "") + "]J(4)";
  }
  axiom += "[I(5)J(1)I(2)";
  const std::string productions =
      "J(a) I(b) < I(c) > J(d) : a<c --> I(c+d)\n"
      "I(a) I(b) < I(c) > J(d) I(e) : b<e+2 --> I(a+0.5*d)\n"
      "J(a) < I(c) > I(d) J(e) : a+e>2 --> J(c)\n"
      "I(a) < I(c) > J(d) : a==d --> I(0)I(a)\n"
      "I(a) J(b) < J(c) > I(d) I(e) : c<9 --> J(a+1)\n"
      "J(c) > I(d) J(e) [I(f)=] : f<9 --> J(d+f)\n"
      "I(a) < J(c) > ] : a>1 --> I(c-1)\n";
  for (const unsigned threads : {1U, 2U}) {
    expectPlainSteps(test::modelText("ignore: +\n", axiom, productions), threads, 6);
  }
}

TEST(Scan, ACutTakesTheRestOfItsBranchAcrossChunks) {
  // parts of one module, of some branches, and longer than a chunk; others begin in a part and have no effect
  std::string axiom;
  for (int i = 0; i < 400; ++i) {
    axiom += "A(" + std::to_string(i % 5) + ")[+B(2)" + (i % 3 == 0 ? "%" : "") + "C(0)[A(1)%A(2)]B(1)]";
  }
  std::string longPart = "[B(1)%";
  for (int i = 0; i < 3000; ++i) {
    longPart += i % 50 == 0 ? "[C(0)%]" : "B(1)";
  }
  const std::string productions =
      "A(x) : {u=x*2;} x<40 {v=u+1;} --> A(v)S(0)\nB(x) : x<5 --> B(x+1)\nC(x) : 1/(x-2)<9 --> C(x+0.5)\n"
      "S(n) : n<2 --> S(n+1)\nS(n) : n==2 --> [F(1)%B(0)A(7)]\n";
  for (const std::string& text : {axiom, axiom + longPart + "]" + axiom, axiom + "%" + axiom, longPart}) {
    expectPlainSteps(test::modelText("", text, productions), 1, 7);
    expectPlainSteps(test::modelText("", text, productions), 2, 7);
    expectPlainSteps(
        test::modelText("", text, productions + "decomposition\nmaximum depth: 3\nF(x) : x>0 --> F(x-1)F(0)\n"), 1, 7);
  }
}

TEST(Scan, AChoiceBesideACutPartLongerThanAChunkDrawsInsideTheChunk) {
  // nearly a chunk of modules that draw, then a part that makes the chunk some times as long
  std::string axiom;
  for (int i = 0; i < 1900; ++i) {
    axiom += "A(" + std::to_string(i % 5) + ")";
  }
  axiom += "[B%" + std::string(10000, 'B') + "]" + axiom;
  const std::string fixedWeights = "A(x) --> A(x+1) : 1\nA(x) --> B : 2\n";
  const std::string ownWeights = "A(x) --> A(x+1) : x+1\nA(x) --> B : 2\n";
  for (const std::string& productions : {fixedWeights, ownWeights}) {
    for (const unsigned threads : {1U, 2U}) {
      expectPlainSteps(test::modelText("", axiom, productions), threads, 3);
    }
  }
}

TEST(Scan, WhatIsCutNeitherWarnsNorRunsBlocks) {
  // behind each `%` stands a division by 0 and an assignment
  std::string axiom;
  for (int i = 0; i < 500; ++i) {
    axiom += "A(1)[%A(0)]A(2)";
  }
  DerivedModel model(modelText("", axiom + "[A(4)%A(5)]", "A(x) : {u=x;} 1/x>0 --> A(u+0.5)\n"));
  model.steps(1);
  EXPECT_TRUE(model.warnings().empty());
  EXPECT_EQ(model.text().substr(0, 26), "A(1.5)[]A(2.5)A(1.5)[]A(2.");
  EXPECT_EQ(model.state().statics.at(0), 4.0);
}

TEST(Scan, BlocksDoNotRunWhereAnEarlierPredecessorWins) {
  // A takes the B(2) behind it, whose block would divide by 0; the blocks of A and B(1) run, also where nothing applies
  std::string axiom;
  for (int i = 0; i < 1500; ++i) {
    axiom += i % 3 == 0 ? "B(1)C" : "AB(2)";
  }
  DerivedModel model(modelText("", axiom,
                               "A B(x) : {u=x+1;} x>1 {v=u;} --> B(x)A\n"
                               "B(x) : {w=1/(x-2);} w>0 --> B(x+1)\n"));
  model.steps(1);
  EXPECT_TRUE(model.warnings().empty());
  EXPECT_EQ(model.text().substr(0, 20), "B(1)CB(2)AB(2)AB(1)C");
  EXPECT_EQ(model.state().statics, (std::vector<double>{3.0, 3.0, -1.0}));
}

TEST(Scan, OfBlocksInADecompositionTheLastDepthFirstStays) {
  // the first B is decomposed to depth 4, the last to depth 1: `u` is of the last, `v` of the C that the first has made
  std::string axiom = "A(4)";
  for (int i = 0; i < 600; ++i) {
    axiom += "F";
  }
  DerivedModel model(modelText("", axiom + "A(1)A(0)",
                               "A(n) : n<9 --> B(n)F\ndecomposition\nmaximum depth: 9\n"
                               "B(n) : {w=n*2;} n>0 {u=n+0.5;} --> B(n-1)C(n)\nC(n) : n>1 {v=n;} --> D\n"));
  model.steps(1);
  EXPECT_EQ(model.text().substr(0, 12), "B(0)C(1)DDDF");
  EXPECT_EQ(model.state().statics, (std::vector<double>{0.0, 1.5, 4.0}));
}

TEST(Scan, LongWaysOverBranchesEndAtTheSameNeighbour) {
  // 1,500 branches at a node, some with branches of their own, between them ignored symbols or one that counts
  std::string fan = "J(1)";
  for (int i = 0; i < 1500; ++i) {
    fan += i % 7 == 3 ? "[+[B(0)]+(2)[C]B(0)]" : (i % 400 == 399 ? "J(2)[B(0)]" : "+(3)[B(0)]");
  }
  // 300 branches inside each other, and modules behind each of them
  std::string nest = "J(3)";
  for (int i = 0; i < 300; ++i) {
    nest += "[+(1)";
  }
  for (int i = 0; i < 300; ++i) {
    nest += "B(0)]C";
  }
  for (const unsigned threads : {1U, 2U, 4U}) {
    for (const std::string& axiom : {fan, nest, fan + nest, "]" + fan, "[[" + nest}) {
      // nearest neighbours, and searched ones
      expectPlainSteps(
          test::modelText("ignore: +\n", axiom, "J(a) < B(x) --> B(x+a)\nB(a) < C --> B(a)\nB(a) < B(x) --> C\n"),
          threads, 3);
      expectPlainSteps(test::modelText("ignore: +\n", axiom, "J(b)J(a) < B(x) --> B(x+a+b)\nJ(a)B(y) < C --> B(y)\n"),
                       threads, 3);
    }
  }
}

TEST(Scan, CheapProductionsAmongOthersMakeWhatThePlainDerivationMakes) {
  // batches first, then one at a time for longer than the string is, over several steps; values divide by what may be 0
  std::string axiom;
  for (int i = 0; i < 3000; ++i) {
    axiom += i % 5 == 4 ? "C(" + std::to_string(i % 7) + ",1)" : "A(" + std::to_string(i % 3) + ")";
  }
  const std::string productions = "A(x) : x<2 --> B\nB --> A(1)\nC(x,y) : y<90 --> C(0.5*x+1,y/(x+1))\n";
  expectPlainSteps(test::modelText("", axiom, productions), 1, 8);
  expectPlainSteps(test::modelText("", axiom, productions), 2, 8);
}

TEST(Scan, ModulesOfTheGeneralWayFarApartAndCloseTogether) {
  // two predecessors of two modules, 2 and then 400 modules apart
  std::string axiom;
  for (int i = 0; i < 3000; ++i) {
    axiom += i % (i < 1500 ? 2 : 400) == 0 ? "GH" : "A(" + std::to_string(i % 3) + ",2)";
  }
  expectPlainSteps(test::modelText("", axiom, "G H --> HG\nH G --> GH\nA(x,y) : y>0 --> A(0.5*x,y+1)\n"), 1, 6);
}

TEST(Scan, LinksOfBracketsAreKeptOnlyWhileTheStringIsBuiltAlike) {
  // the same length in every step: nothing, brackets, a parameter between them, two signals past the branch
  const std::string productions =
      "p --> [\nq --> ]\nA --> E\nE --> e(7)\nD(x) < B(y) --> B(x+y)\nB(x) > K(y) --> B(x+10*y)\n";
  DerivedModel model(test::modelText("", "D(3)pAqB(1)K(2)", productions));
  EXPECT_EQ(model.steps(1), "D(3)[E]B(21)K(2)");
  EXPECT_EQ(model.steps(1), "D(3)[e(7)]B(24)K(2)");
  EXPECT_EQ(model.steps(1), "D(3)[e(7)]B(27)K(2)");
  EXPECT_EQ(model.steps(1), "D(3)[e(7)]B(30)K(2)");
}

TEST(Scan, LinksOfBracketsAreNotTakenFromAnotherPlant) {
  // one Derivation for two strings of the same length in turn: in the other the branch stands one module further
  DerivedModel model(test::modelText("", "D(3)[A]AB(1)", "D(x) < A --> E\nA < B(y) --> B(y+1)\nA > B(y) --> F\n"));
  derivation::PlantState other = model.state();
  const auto types = model.state().string.types();
  const std::vector<core::ModuleTypeId> moved{types[0], types[2], types[1], types[2], types[3], types[5]};
  std::copy(moved.begin(), moved.end(), other.string.typeBuffer().data());
  EXPECT_EQ(model.steps(1), "D(3)[E]EB(2)");
  std::swap(model.state(), other);
  EXPECT_EQ(model.steps(1), "D(3)E[A]B(2)");
  std::swap(model.state(), other);
  EXPECT_EQ(model.steps(1), "D(3)[E]EB(2)");
}

TEST(Scan, LongSuccessorsAreWrittenWhole) {
  std::string successor;
  for (int i = 0; i < 40; ++i) {
    successor += "abcdefghij";
  }
  EXPECT_EQ(test::derive(test::modelText("", "xAx", "A --> " + successor + "\n"), 1), "x" + successor + "x");
}

TEST(Scan, CopiesManyParametersAndFewAlike) {
  // the last module's parameters end where the string's do
  EXPECT_EQ(test::derive(test::modelText("", "p(1)q(1,2,3,4,5,6,7,8,9)r(1,2,3,4)s(5)", "A --> A\n"), 2),
            "p(1)q(1,2,3,4,5,6,7,8,9)r(1,2,3,4)s(5)");
}

TEST(Scan, GrowsOverManyChunks) {
  DerivedModel model(test::modelText("", "A(1)", "A(x) --> A(x)B(x)A(x)[c]\n"));
  model.steps(14);
  // a(k+1) = 2 a(k) modules A; b and the brackets add 4 for every A rewritten
  EXPECT_EQ(model.state().string.size(), (1U << 14U) + 4U * ((1U << 14U) - 1U));
  EXPECT_EQ(model.state().string.parameterCount(), (1U << 14U) + (1U << 14U) - 1U);
}

/// `count` modules A(1), but with the parameter 0 at `place`.
std::string axiomWithZero(std::size_t count, std::size_t place) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    text += i == place ? "A(0)" : "A(1)";
  }
  return text;
}

/// One scan for each number of threads: all must do the same.
class ScanOnThreads : public testing::TestWithParam<unsigned> {
 protected:
  static derivation::DerivationOptions options() {
    derivation::DerivationOptions made;
    made.threads = GetParam();
    made.threadedModules = 1;
    return made;
  }
};

INSTANTIATE_TEST_SUITE_P(Threads, ScanOnThreads, testing::Values(1U, 2U, 4U));

TEST_P(ScanOnThreads, TheFirstModuleThatFailsIsNamed) {
  // log(0) and exp(1000) are not finite; the second is in a later chunk
  DerivedModel model(test::modelText("", axiomWithZero(3000, 2500) + axiomWithZero(3000, 3000) + "B(1000)A(0)",
                                     "B(x) --> B(exp(x))\nA(x) --> A(log(x))\n"),
                     options());
  const std::string before = model.text();
  const core::SimulationError error = model.failingStep();
  EXPECT_EQ(error.module, 2500U);
  EXPECT_NE(error.message.find("parameter 1 became infinite in 'log(x)'"), std::string::npos) << error.message;
  // a failed step leaves the string
  EXPECT_EQ(model.text(), before);
  EXPECT_EQ(model.state().step, 0U);
}

TEST_P(ScanOnThreads, AConditionThatFailsAfterOthersIsNotReachedFirst) {
  // the weights of the module in the second chunk are infinite, and a value in the third
  DerivedModel model(test::modelText("Seed: 1\n", axiomWithZero(6000, 2500) + "B(1000)",
                                     "A(x) --> A(x) : -log(x)\nA(x) --> A(x+1) : 1\nB(x) --> B(exp(x))\n"),
                     options());
  const core::SimulationError error = model.failingStep();
  EXPECT_EQ(error.code, core::SimulationErrorCode::NonFinite);
  EXPECT_EQ(error.module, 2500U);
}

TEST_P(ScanOnThreads, AStringThatGrowsTooLongFailsAndStays) {
  derivation::DerivationOptions limited = options();
  limited.limits.maximumModules = 100000;
  DerivedModel model(test::modelText("", "A(1)", "A(x) --> A(x)A(x)\n"), limited);
  model.steps(16);
  const core::SimulationError error = model.failingStep();
  EXPECT_EQ(error.code, core::SimulationErrorCode::LimitExceeded);
  EXPECT_NE(error.message.find("the string has more than 100000 modules (limit modules)"), std::string::npos)
      << error.message;
  EXPECT_EQ(model.state().string.size(), 65536U);
}

TEST_P(ScanOnThreads, ACancelledStepLeavesTheString) {
  std::atomic<bool> isCancelled = false;
  derivation::DerivationOptions cancellable = options();
  cancellable.cancelled = &isCancelled;
  DerivedModel model(test::modelText("", "A(1)", "A(x) --> A(x)A(x)\n"), cancellable);
  model.steps(14);
  isCancelled = true;
  EXPECT_EQ(model.failingStep().code, core::SimulationErrorCode::Cancelled);
  EXPECT_EQ(model.state().string.size(), 16384U);
  EXPECT_EQ(model.state().step, 14U);
}

TEST_P(ScanOnThreads, AGrowthThatNobodyForesawIsWrittenWhole) {
  // nothing grows until the counters run out, then everything by a factor of 100
  std::string successor;
  for (int i = 0; i < 50; ++i) {
    successor += "B(x)c";
  }
  DerivedModel model(
      test::modelText("", axiomWithZero(10000, 77), "A(x) : Q<4 --> A(x+1)\nA(x) --> " + successor + "\n"), options());
  model.steps(4);
  ASSERT_EQ(model.state().string.size(), 1000000U);
  ASSERT_EQ(model.state().string.parameterCount(), 500000U);
  for (std::size_t i = 0; i < 500000; ++i) {
    ASSERT_EQ(model.state().string.parameters()[i], i / 50 == 77 ? 3.0 : 4.0) << i;
  }
}

TEST_P(ScanOnThreads, FixedBlocksAndTheirParametersAreWrittenWhole) {
  DerivedModel model(test::modelText("", "Ap(1,2,3)q(5)", "A --> A[bA]\nb --> cdefghijklmnoprstuvw\nq(x) --> *\n"),
                     options());
  DerivedModel again(test::modelText("", "Ap(1,2,3)q(5)", "A --> A[bA]\nb --> cdefghijklmnoprstuvw\nq(x) --> *\n"));
  for (int step = 0; step < 12; ++step) {
    model.steps(1);
    again.steps(1);
    ASSERT_EQ(model.text(), again.text());
  }
}

TEST_P(ScanOnThreads, ADivisionByZeroWarnsOnceInALongString) {
  DerivedModel model(test::modelText("", axiomWithZero(3000, 2999), "A(x) --> A(2/x)\n"), options());
  model.steps(1);
  ASSERT_EQ(model.warnings().size(), 1U);
  EXPECT_NE(model.warnings()[0].find("division by 0"), std::string::npos);
  // 2/0 is 2 and 2/1 is 2: nothing divides by 0 any more
  EXPECT_EQ(model.text(), [] {
    std::string text;
    for (int i = 0; i < 3000; ++i) {
      text += "A(2)";
    }
    return text;
  }());
}

TEST(Scan, GeneralModulesBetweenBatchesSeeAndChangeVariables) {
  // every B counts the modules before it; the productions of A read Z, which B's block changes
  std::string axiom;
  std::string expected;
  for (int i = 0; i < 300; ++i) {
    const bool isGeneral = i % 100 == 99;
    axiom += isGeneral ? "B" : "A(0)";
    expected += isGeneral ? "B" : "A(" + std::to_string(100 + i / 100) + ")";
  }
  DerivedModel model(
      test::modelText("", axiom, "A(x) --> A(Z+x)\nB : {SetDerivationLength(GetDerivationLength(0)+1);} * --> B\n"));
  EXPECT_EQ(model.steps(1), expected);
}

}  // namespace
}  // namespace espalier::step_scan_test
