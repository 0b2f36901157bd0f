#include "server/stream/chain_difference.h"

#include <gtest/gtest.h>

#include <random>

#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "engine/simulation/view_drawing.h"
#include "tests/server/frame_viewer.h"

namespace espalier::server::chain_difference_test {
namespace {

std::unique_ptr<simulation::Simulation> simulationOf(const std::string& source,
                                                     std::vector<turtle::PlantPlacement> places = {{}}) {
  language::CompileInput input;
  core::MemoryFileProvider files;
  files.add("model.l", source);
  input.modelFile = "model.l";
  auto compiled = language::compile(input, files);
  EXPECT_NE(compiled.program, nullptr) << source;
  auto simulation = std::make_unique<simulation::Simulation>(compiled.program, std::move(places), nullptr,
                                                             simulation::SimulationOptions{});
  EXPECT_FALSE(simulation->rewind());
  return simulation;
}

std::shared_ptr<const std::vector<std::string>> symbolsOf(const simulation::Simulation& simulation) {
  return std::make_shared<const std::vector<std::string>>(simulation.symbolNames());
}

TurtleFrame wholeOf(const simulation::Simulation& simulation) {
  return makeTurtleFrame(simulation.turtleRecords().value(), symbolsOf(simulation), {});
}

/// The records as they are now; `drawing` has drawn the chains before.
std::shared_ptr<const turtle::RecordChain> chainOf(simulation::Simulation& simulation,
                                                   simulation::ViewDrawing& drawing) {
  simulation.followChanges(true);
  drawing.show(simulation.takeView());
  return drawing.recordChain().value();
}

/// A model of several tips that grow, turn, branch and rest as chance has it.
std::string randomModel(std::mt19937& dice) {
  const auto draw = [&dice](std::size_t bound) { return static_cast<std::size_t>(dice()) % bound; };
  const std::vector<std::string> parts{"F",       "F(0.5)", "f(0.25)", "+(20)",  "-(33)", "&(15)",
                                       "/(90)",   "!(0.5)", ";(3)",    "?E(x)",  "[+F]",  "[&F[-F]F]",
                                       "@O(0.2)", "~l(2)",  "@M(x,1)", "{F.F.}", "@v",    "]["};
  std::string text;
  for (std::size_t count = 1 + draw(6); count > 0; --count) {
    text += parts[draw(parts.size() - 1)];
  }
  std::string rest;
  for (std::size_t count = draw(4); count > 0; --count) {
    rest += parts[draw(parts.size() - 1)];
  }
  const bool hasHomomorphism = draw(2) == 0;
  return "Lsystem: 1\nderivation length: 1000\nseed: " + std::to_string(1 + draw(1000)) +
         "\nAxiom: A(0)[+A(1)][-(70)B(0)]A(2)\n"
         "A(x) : ran(1) < 0.4 --> A(x)\nA(x) --> " +
         text + "A(x+1)" + rest + "\nB(x) --> F[+A(x)]B(x+1)\n?E(x) : ran(1) < 0.01 --> ?E(x+1)\n" +
         (draw(3) == 0 ? "F(x) : ran(1) < 0.02 --> F(x*2)\n" : "") +
         (draw(3) == 0 ? "[ --> [\nF : ran(1) < 0.01 --> *\n" : "") +
         (hasHomomorphism ? "homomorphism\nA(x) --> @O(0.1)\nB(x) : x > 1 --> [F(x)+F]\n" : "") + "endlsystem\n";
}

TEST(ChainDifference, AnyGrowthIsToldAsTheWholeWouldBe) {
  std::mt19937 dice(11);
  std::size_t kept = 0;
  for (int round = 0; round < 40; ++round) {
    const std::string source = randomModel(dice);
    const auto simulation = simulationOf(source, {{}, {.position = {5.0, 0.0, 0.0}, .frame = {}}});
    const auto symbols = symbolsOf(*simulation);
    simulation::ViewDrawing drawing;
    std::shared_ptr<const turtle::RecordChain> base;
    std::shared_ptr<const turtle::RecordChain> old;
    TurtleFrame viewed;
    TurtleFrame seldom;
    for (int step = 0; step < 40 && simulation->statistics().modules < 4'000; ++step) {
      const TurtleFrame whole = wholeOf(*simulation);
      const auto chain = chainOf(*simulation, drawing);
      ASSERT_NE(chain, nullptr) << source;
      expectSameRows(makeTurtleFrame(*chain, symbols), whole);
      ASSERT_FALSE(testing::Test::HasFailure()) << "step " << step << " of\n" << source;
      // a viewer of every step, and one of every third
      if (base != nullptr) {
        const TurtleChange change = differenceOf(*base, *chain, symbols);
        viewed = viewedAfter(viewed, change);
        expectSameRows(viewed, whole);
        kept += whole.rows() - change.fresh->rows();
      } else {
        viewed = whole;
        seldom = whole;
        old = chain;
      }
      if (step % 3 == 2) {
        seldom = viewedAfter(seldom, differenceOf(*old, *chain, symbols));
        expectSameRows(seldom, whole);
        old = chain;
      }
      ASSERT_FALSE(testing::Test::HasFailure()) << "step " << step << " of\n" << source;
      base = chain;
      ASSERT_FALSE(simulation->step()) << source;
    }
  }
  EXPECT_GT(kept, 10'000U);
}

/// Far more than one stretch.
constexpr const char* kTree =
    "Lsystem: 1\nderivation length: 100\nAxiom: [A]S(9)[A]T\nA --> F(2)A\n"
    "S(n) : n > 0 --> S(n-1)[+(7)S(n-1)]\nS(n) : n == 0 --> F(1)\nT --> T\nendlsystem\n";

TEST(ChainDifference, WhatHasNotChangedIsSharedWithTheBase) {
  const auto simulation = simulationOf(kTree);
  for (int step = 0; step < 12; ++step) {
    ASSERT_FALSE(simulation->step());
  }
  simulation::ViewDrawing drawing;
  const auto base = chainOf(*simulation, drawing);
  ASSERT_FALSE(simulation->step());
  const auto chain = chainOf(*simulation, drawing);
  const auto before = base->places(0, base->links.size());
  ASSERT_GT(before.size(), 10U);
  std::size_t shared = 0;
  for (const auto& place : chain->places(0, chain->links.size())) {
    for (const auto& other : before) {
      shared += place.stretch == other.stretch ? 1U : 0U;
    }
  }
  // a tip at the front has grown, and one near the end
  EXPECT_GE(shared + 4, before.size());
  const TurtleChange change = differenceOf(*base, *chain, symbolsOf(*simulation));
  EXPECT_EQ(change.fresh->rows(), 2U);
  expectSameRows(viewedAfter(wholeOf(*simulation), differenceOf(*chain, *chain, symbolsOf(*simulation))),
                 wholeOf(*simulation));
}

TEST(ChainDifference, AStringWithoutBracketsIsSharedBehindAnInsertion) {
  // `f(0)` at the front changes the modules' numbers and nothing else
  const auto simulation = simulationOf(
      "Lsystem: 1\nderivation length: 100\nAxiom: A S(10)\nA --> A+(0)\n"
      "S(n) : n > 0 --> S(n-1)+(7)S(n-1)\nS(n) : n == 0 --> F(1)\nendlsystem\n");
  for (int step = 0; step < 12; ++step) {
    ASSERT_FALSE(simulation->step());
  }
  simulation::ViewDrawing drawing;
  const auto base = chainOf(*simulation, drawing);
  ASSERT_FALSE(simulation->step());
  const auto chain = chainOf(*simulation, drawing);
  const TurtleChange change = differenceOf(*base, *chain, symbolsOf(*simulation));
  EXPECT_EQ(change.fresh->rows(), 0U);
  EXPECT_EQ(change.rows, 1024U);
  EXPECT_LE(change.kept.size(), 2U);
}

TEST(ChainDifference, AChangeOfTheTurtleReachesEverythingBehindIt) {
  const auto simulation = simulationOf(
      "Lsystem: 1\nderivation length: 100\nAxiom: F(1)[C]G S(8)\nF(x) --> F(x+1)\n"
      "S(n) : n > 0 --> S(n-1)+(7)S(n-1)\nS(n) : n == 0 --> G\nendlsystem\n");
  for (int step = 0; step < 10; ++step) {
    ASSERT_FALSE(simulation->step());
  }
  simulation::ViewDrawing drawing;
  const auto base = chainOf(*simulation, drawing);
  ASSERT_FALSE(simulation->step());
  const auto chain = chainOf(*simulation, drawing);
  const TurtleChange change = differenceOf(*base, *chain, symbolsOf(*simulation));
  // some place may be the same by chance
  EXPECT_GE(change.fresh->rows() + 3, change.rows);
  expectSameRows(makeTurtleFrame(*chain, symbolsOf(*simulation)), wholeOf(*simulation));
}

/// Answers all queries with a number that changes every third step.
class SlowTide final : public turtle::EnvironmentProcess {
 public:
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = "tide";
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    ++steps_;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      replies.set(queries, i, 0, static_cast<double>(steps_ / 3));
    }
    return std::nullopt;
  }

 private:
  int steps_ = 0;
};

TEST(ChainDifference, AnswersAndLongStringsAreToldAsTheWholeWouldBe) {
  // 100,000 modules, most of which no step changes, in branches that threads share; answers change now and then
  const std::string source =
      "Lsystem: 1\nderivation length: 100\nAxiom: [A]S(12)?E(0)[+S(12)[B(0)]][-S(12)?E(0)]S(13)\nA --> F(2)A\n"
      "S(n) : n > 0 --> S(n-1)[+(7)S(n-1)]\nS(n) : n == 0 --> F(1)\n"
      "B(x) : x == 15 --> *\nB(x) --> [+F]B(x+1)\nendlsystem\n";
  for (const unsigned threads : {1U, 2U}) {
    language::CompileInput input;
    core::MemoryFileProvider files;
    files.add("model.l", source);
    input.modelFile = "model.l";
    const auto compiled = language::compile(input, files);
    ASSERT_NE(compiled.program, nullptr);
    simulation::SimulationOptions options;
    options.threads = threads;
    simulation::Simulation simulation(compiled.program, {{}}, std::make_unique<SlowTide>(), options);
    ASSERT_FALSE(simulation.rewind());
    const auto symbols = symbolsOf(simulation);
    simulation::ViewDrawing drawing;
    std::shared_ptr<const turtle::RecordChain> base;
    TurtleFrame viewed;
    std::size_t kept = 0;
    for (int step = 0; step < 30; ++step) {
      ASSERT_FALSE(simulation.step());
      // sometimes after several steps
      if (step < 14 || step % 7 == 3 || step % 7 == 5) {
        continue;
      }
      const TurtleFrame whole = wholeOf(simulation);
      const auto chain = chainOf(simulation, drawing);
      expectSameRows(makeTurtleFrame(*chain, symbols), whole);
      if (base != nullptr) {
        const TurtleChange change = differenceOf(*base, *chain, symbols);
        viewed = viewedAfter(viewed, change);
        expectSameRows(viewed, whole);
        kept += whole.rows() - change.fresh->rows();
      } else {
        viewed = whole;
      }
      ASSERT_FALSE(testing::Test::HasFailure()) << "step " << step << " with " << threads << " threads";
      base = chain;
    }
    EXPECT_GT(kept, 100'000U);
  }
}

TEST(ChainDifference, WhatDependsOnMoreThanTheModuleIsNotRepeatable) {
  const auto isRepeatable = [](const std::string& rest) {
    const auto simulation = simulationOf("Lsystem: 1\n" + rest + "endlsystem\n");
    simulation::ViewDrawing drawing;
    return chainOf(*simulation, drawing) != nullptr;
  };
  const std::string axiom = "derivation length: 1\nAxiom: A(1)B\nA(x) --> A(x)B\nhomomorphism\n";
  EXPECT_TRUE(isRepeatable(axiom + "A(x) : x > 0 --> F(x*2)\n"));
  EXPECT_FALSE(isRepeatable(axiom + "A(x) --> F(Q)\n"));
  EXPECT_FALSE(isRepeatable(axiom + "A(x) : Q > 2 --> F\n"));
  EXPECT_FALSE(isRepeatable(axiom + "A(x) --> F(ran(1))\n"));
  EXPECT_FALSE(isRepeatable(axiom + "A(x) > B --> F\n"));
  EXPECT_FALSE(isRepeatable(axiom + "A(x) B --> F\n"));
  EXPECT_FALSE(isRepeatable(axiom + "B --> F : 0.5\nB --> G : 0.5\n"));
  EXPECT_FALSE(isRepeatable("Start: { y = 1; }\n" + axiom + "B --> F(y)\n"));
}

TEST(ChainDifference, AFailureIsThatOfTheWhole) {
  const std::string large = "F(1" + std::string(308, '0') + ")";
  const auto simulation =
      simulationOf("Lsystem: 1\nderivation length: 9\nAxiom: " + large + "A\nA --> " + large + "\nendlsystem\n");
  simulation::ViewDrawing drawing;
  ASSERT_NE(chainOf(*simulation, drawing), nullptr);
  ASSERT_FALSE(simulation->step());
  drawing.show(simulation->takeView());
  const auto chain = drawing.recordChain();
  const auto records = simulation->turtleRecords();
  ASSERT_FALSE(records.has_value());
  ASSERT_FALSE(chain.has_value());
  EXPECT_EQ(chain.error().message, records.error().message);
}

}  // namespace
}  // namespace espalier::server::chain_difference_test
