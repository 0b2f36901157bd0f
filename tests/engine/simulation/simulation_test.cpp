#include "engine/simulation/simulation.h"

#include <limits>
#include <set>

#include "engine/simulation/plants_view.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::simulation_test {
namespace {

constexpr const char* kHeightModel =
    "Lsystem: 1\n"
    "derivation length: 3\n"
    "Axiom: A?E(9)\n"
    "A > ?E(x) --> F(1)B(x)A\n"
    "endlsystem\n";

TEST(Simulation, AStepAnswersThenDerives) {
  TestRun run(compileText(kHeightModel));
  expectSuccess(run.simulation.rewind());
  EXPECT_EQ(run.log->openCount, 1);
  EXPECT_EQ(run.simulation.stringText(), "A?E(9)");
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.simulation.stringText(), "F(1)B(0)A?E(0)");
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.simulation.stringText(), "F(1)B(0)F(1)B(100)A?E(100)");
  EXPECT_EQ(run.simulation.completedSteps(), 2U);
  EXPECT_EQ(run.simulation.statistics().queries, 1U);
  EXPECT_EQ(run.simulation.statistics().answers, 1U);
  EXPECT_EQ(run.simulation.statistics().modules, 7U);
  EXPECT_EQ(run.simulation.statistics().parameters, 5U);
}

TEST(Simulation, AnswerBringsThePassForwardAndTheStepDoesNotRepeatIt) {
  TestRun run(compileText(kHeightModel));
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.answer());
  EXPECT_EQ(run.simulation.stringText(), "A?E(0)");
  EXPECT_TRUE(run.simulation.isAnswered());
  expectSuccess(run.simulation.answer());
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.simulation.stringText(), "F(1)B(0)A?E(0)");
  EXPECT_FALSE(run.simulation.isAnswered());
  EXPECT_EQ(run.log->stepCount, 1);
}

TEST(Simulation, IsFinishedAtTheDerivationLengthAndGoesOnWhenAsked) {
  TestRun run(compileText(kHeightModel));
  expectSuccess(run.simulation.rewind());
  while (!run.simulation.isFinished()) {
    expectSuccess(run.simulation.step());
  }
  EXPECT_EQ(run.simulation.completedSteps(), 3U);
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.simulation.completedSteps(), 4U);
}

TEST(Simulation, AModelThatStoppedItselfHasNoFurtherStep) {
  TestRun run(compileText("Lsystem: 1\nderivation length: 9\nAxiom: A(0)\nA(n) : {if (n==1) {stop(2);}} 1 --> A(n+1)\n"
                          "endlsystem\n"),
              1, {}, false);
  expectSuccess(run.simulation.rewind());
  while (!run.simulation.isFinished()) {
    expectSuccess(run.simulation.step());
  }
  EXPECT_EQ(run.simulation.completedSteps(), 2U);
  const auto error = run.simulation.step();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(
      error->message,
      "step 3: the model has stopped itself, there is no further step. Rewind the simulation to run it again. The "
      "simulation stays at step 2.");
}

TEST(Simulation, MustBeStartedBeforeTheFirstStep) {
  TestRun run(compileText(kHeightModel));
  const auto error = run.simulation.step();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message, "The simulation has not been started. Rewind it or restore a snapshot first.");
}

TEST(Simulation, AFailingEnvironmentLeavesTheLastCompletedStep) {
  TestRun run(compileText(kAskingModel));
  expectSuccess(run.simulation.rewind());
  for (int i = 0; i < 3; ++i) {
    expectSuccess(run.simulation.step());
  }
  const std::string before = run.simulation.stringText();
  const std::uint64_t hash = run.simulation.stateHash();
  run.log->nextError = turtle::EnvironmentError{"environment 'fake' does not answer. Start it again.", true};
  const auto error = run.simulation.step();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->code, core::SimulationErrorCode::EnvironmentFailed);
  EXPECT_TRUE(error->isRetryable);
  EXPECT_EQ(error->step, 4U);
  EXPECT_EQ(error->message, "environment 'fake' does not answer. Start it again. The simulation stays at step 3.");
  EXPECT_EQ(run.simulation.stringText(), before);
  EXPECT_EQ(run.simulation.stateHash(), hash);
  EXPECT_EQ(run.simulation.completedSteps(), 3U);
  // trying again gives what an undisturbed run gives
  expectSuccess(run.simulation.step());
  TestRun undisturbed(compileText(kAskingModel));
  expectSuccess(undisturbed.simulation.rewind());
  for (int i = 0; i < 4; ++i) {
    expectSuccess(undisturbed.simulation.step());
  }
  EXPECT_EQ(run.simulation.stringText(), undisturbed.simulation.stringText());
  EXPECT_EQ(run.simulation.stateHash(), undisturbed.simulation.stateHash());
}

// a step that fails after the replies have come: in the derivation, by a parameter that is not finite
constexpr const char* kFragileModel =
    "Lsystem: 1\n"
    "derivation length: 5\n"
    "Start: {c=0;}\n"
    "Axiom: A(1)?E(0)\n"
    "A(n) > ?E(x) : x>=100 --> A(exp(x*x))\n"
    "A(n) > ?E(x) --> F(n)A(n+c)\n"
    "homomorphism\n"
    "A(n) : {c=c+1;} * --> F(n)\n"
    "endlsystem\n";

TEST(Simulation, AFailingDerivationLeavesTheLastCompletedStepAndKeepsTheReplies) {
  TestRun run(compileText(kFragileModel));
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  const std::string before = run.simulation.stringText();
  const std::uint64_t steps = static_cast<std::uint64_t>(run.log->stepCount);
  const auto first = run.simulation.step();
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(first->code, core::SimulationErrorCode::NonFinite);
  EXPECT_TRUE(first->message.ends_with("The simulation stays at step 1.")) << first->message;
  EXPECT_EQ(run.simulation.stringText(), before);
  EXPECT_EQ(run.simulation.completedSteps(), 1U);
  // the environment answered once; trying again does not ask it again
  EXPECT_EQ(run.log->stepCount, static_cast<int>(steps) + 1);
  const auto second = run.simulation.step();
  ASSERT_TRUE(second.has_value());
  EXPECT_EQ(second->message, first->message);
  EXPECT_EQ(run.log->stepCount, static_cast<int>(steps) + 1);
  EXPECT_EQ(run.simulation.stringText(), before);
  // a rewind forgets them
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.simulation.stringText(), before);
}

TEST(Simulation, WhenOnePlantFailsAllStay) {
  // plant 0 gets 0, 200, ...; plant 1 gets 1, 201 and fails on it
  const std::string model =
      "Lsystem: 1\nderivation length: 5\nAxiom: A(1)?E(0)\n"
      "A(n) > ?E(x) : x==101 --> A(exp(x*x))\nA(n) > ?E(x) --> FA(n+1)\nendlsystem\n";
  TestRun run(compileText(model), 2);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  const std::string first = run.simulation.stringText(0);
  const std::string second = run.simulation.stringText(1);
  const std::uint64_t hash = [&] {
    TestRun other(compileText(model), 2);
    expectSuccess(other.simulation.rewind());
    expectSuccess(other.simulation.step());
    return other.simulation.stateHash();
  }();
  EXPECT_EQ(run.simulation.stateHash(), hash);
  const auto error = run.simulation.step();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->plant, 1U);
  EXPECT_EQ(run.simulation.stringText(0), first);
  EXPECT_EQ(run.simulation.stringText(1), second);
  EXPECT_EQ(run.simulation.completedSteps(), 1U);
}

TEST(Simulation, ANonFiniteReplyIsAnErrorThatNamesEnvironmentAndQuery) {
  TestRun run(compileText(kHeightModel));
  expectSuccess(run.simulation.rewind());
  run.log->answer = std::numeric_limits<double>::quiet_NaN();
  const auto error = run.simulation.step();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->code, core::SimulationErrorCode::NonFinite);
  EXPECT_EQ(
      error->message,
      "step 1, plant 0, module 2 ('E'): environment 'fake' answered nan for parameter 1 of query 0. Replies must be "
      "finite numbers: correct the environment. The simulation stays at step 0.");
  EXPECT_EQ(run.simulation.stringText(), "A?E(9)");
}

TEST(Simulation, ThePolicyKeepLetsModulesKeepWhatTheySent) {
  SimulationOptions options;
  options.environmentPolicy = EnvironmentPolicy::Keep;
  TestRun run(compileText(kHeightModel), 1, options);
  expectSuccess(run.simulation.rewind());
  run.log->nextError = turtle::EnvironmentError{"gone", true};
  expectSuccess(run.simulation.step());
  EXPECT_EQ(run.simulation.stringText(), "F(1)B(9)A?E(9)");
  EXPECT_EQ(run.simulation.statistics().answers, 0U);
}

TEST(Simulation, AStepWithoutQueriesTicksInEspaliersModeOnly) {
  const std::string model = "Lsystem: 1\nderivation length: 3\nAxiom: A\nA --> AB?E(1)\nB --> B\nendlsystem\n";
  TestRun own(compileText(model));
  expectSuccess(own.simulation.rewind());
  expectSuccess(own.simulation.step());
  EXPECT_EQ(own.log->ticks, std::vector<std::uint64_t>{0});
  EXPECT_EQ(own.log->stepCount, 0);
  expectSuccess(own.simulation.step());
  EXPECT_EQ(own.log->ticks.size(), 1U);
  EXPECT_EQ(own.log->stepCount, 1);
  TestRun reference(compileText(model, {}, core::Compatibility::Cpfg));
  expectSuccess(reference.simulation.rewind());
  expectSuccess(reference.simulation.step());
  EXPECT_TRUE(reference.log->ticks.empty());
  EXPECT_EQ(reference.log->stepCount, 0);
}

TEST(Simulation, ATickIsNotRepeatedWhenTheStepIsTriedAgain) {
  TestRun run(compileText("Lsystem: 1\nderivation length: 3\nAxiom: A(30)\nA(n) --> A(exp(n*n))\nendlsystem\n"));
  expectSuccess(run.simulation.rewind());
  EXPECT_TRUE(run.simulation.step().has_value());
  EXPECT_TRUE(run.simulation.step().has_value());
  EXPECT_EQ(run.log->ticks.size(), 1U);
}

TEST(Simulation, RepliesAreFloatsInTheCompatibleModesOnly) {
  TestRun own(compileText(kHeightModel));
  own.log->answer = 0.1;
  expectSuccess(own.simulation.rewind());
  expectSuccess(own.simulation.answer());
  EXPECT_EQ(own.simulation.string().parameters()[0], 0.1);
  TestRun reference(compileText(kHeightModel, {}, core::Compatibility::Cpfg));
  reference.log->answer = 0.1;
  expectSuccess(reference.simulation.rewind());
  expectSuccess(reference.simulation.answer());
  EXPECT_EQ(reference.simulation.string().parameters()[0], static_cast<double>(0.1F));
}

TEST(Simulation, AQueryOfAHomomorphismTakesPartAndItsReplyIsDiscarded) {
  TestRun run(
      compileText("Lsystem: 1\nderivation length: 2\nAxiom: J?E(2)A(5)\nJ --> J\nhomomorphism\nJ --> F(3)?E(7)\n"
                  "endlsystem\n"));
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.answer());
  // nothing is written behind the modules that ask for themselves
  EXPECT_EQ(run.simulation.stringText(), "J?E(1)A(5)");
  ASSERT_EQ(run.log->batches.size(), 1U);
  EXPECT_EQ(run.log->batches[0].isTransient, (std::vector<std::uint8_t>{1, 0}));
  EXPECT_EQ(run.log->batches[0].parameters, (std::vector<double>{7, 2}));
}

TEST(Simulation, ACutOfAHomomorphismEndsNoBranch) {
  const auto drawn = [](const std::string& axiom) {
    TestRun run(compileText(
        "Lsystem: 1\nderivation length: 1\nAxiom: " + axiom + "\nhomomorphism\nJ --> F(3)@mc(1)F(4)\nendlsystem\n",
        "interpretation past %: off\n"));
    expectSuccess(run.simulation.rewind());
    const auto scene = run.simulation.scene();
    return scene ? scene->segments.size() : std::size_t{0};
  };
  EXPECT_EQ(drawn("[JF(1)]F(2)"), 4U);
  EXPECT_EQ(drawn("[@mc(1)F(1)]F(2)"), 1U);
}

TEST(Simulation, PlantsShareTheEnvironmentAtTheirPlaces) {
  TestRun run(compileText("Lsystem: 1\nderivation length: 2\nAxiom: F?E(0)\nF --> F\nendlsystem\n"), 3);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.answer());
  ASSERT_EQ(run.log->batches.size(), 1U);
  const turtle::QueryBatch& batch = run.log->batches[0];
  EXPECT_EQ(batch.plant, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(batch.position[2], (core::Vec3{8, 1, 0}));
  EXPECT_EQ(run.simulation.stringText(2), "F?E(2)");
  EXPECT_EQ(run.log->context.plantCount, 3U);
  EXPECT_EQ(run.log->context.symbols.size(), run.simulation.program().symbols.size());
}

TEST(Simulation, CancellingGivesTheStepUp) {
  TestRun run(compileText(kAskingModel));
  expectSuccess(run.simulation.rewind());
  const std::string before = run.simulation.stringText();
  run.simulation.setCancelled(true);
  const auto error = run.simulation.step();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->code, core::SimulationErrorCode::Cancelled);
  EXPECT_EQ(run.simulation.stringText(), before);
  run.simulation.setCancelled(false);
  expectSuccess(run.simulation.step());
}

TEST(Simulation, TheCallersSeedReplacesTheModels) {
  SimulationOptions options;
  options.seed = 17;
  EXPECT_EQ(TestRun(compileText(kAskingModel), 1, options).simulation.seed(), 5U);
  options.hasSeed = true;
  EXPECT_EQ(TestRun(compileText(kAskingModel), 1, options).simulation.seed(), 17U);
  options.hasSeed = false;
  EXPECT_EQ(TestRun(compileText(kHeightModel), 1, options).simulation.seed(), 17U);
}

TEST(Simulation, DrawingDoesNotChangeIt) {
  TestRun run(compileText(kAskingModel));
  expectSuccess(run.simulation.rewind());
  for (int i = 0; i < 5; ++i) {
    expectSuccess(run.simulation.step());
  }
  const std::uint64_t hash = run.simulation.stateHash();
  const auto scene = run.simulation.scene();
  ASSERT_TRUE(scene.has_value());
  EXPECT_FALSE(scene->segments.empty());
  const auto records = run.simulation.turtleRecords();
  ASSERT_TRUE(records.has_value());
  EXPECT_FALSE(records->empty());
  EXPECT_EQ(run.simulation.stateHash(), hash);
}

TEST(Simulation, RewindStartsTheSameRunAgain) {
  TestRun run(compileText(kAskingModel));
  std::string first;
  for (int round = 0; round < 2; ++round) {
    expectSuccess(run.simulation.rewind());
    for (int i = 0; i < 6; ++i) {
      expectSuccess(run.simulation.step());
    }
    if (round == 0) {
      first = run.simulation.stringText();
    }
  }
  EXPECT_EQ(run.simulation.stringText(), first);
  EXPECT_EQ(run.log->openCount, 2);
}

TEST(Simulation, RewindWithASeedGivesTheBitsOfANewSimulation) {
  TestRun run(compileText(kAskingModel), 2);
  expectSuccess(run.simulation.rewind());
  const auto grow = [](Simulation& simulation) {
    std::vector<std::uint64_t> hashes{simulation.stateHash()};
    for (int i = 0; i < 6; ++i) {
      expectSuccess(simulation.step());
      EXPECT_TRUE(simulation.scene().has_value());
      hashes.push_back(simulation.stateHash());
    }
    return hashes;
  };
  std::set<std::uint64_t> ends{grow(run.simulation).back()};
  for (const std::uint64_t seed : {17U, 3U, 17U}) {
    expectSuccess(run.simulation.rewind(seed));
    EXPECT_EQ(run.simulation.seed(), seed);
    EXPECT_EQ(run.log->context.seed, seed);
    SimulationOptions options;
    options.seed = seed;
    options.hasSeed = true;
    TestRun fresh(compileText(kAskingModel), 2, options);
    expectSuccess(fresh.simulation.rewind());
    const std::vector<std::uint64_t> hashes = grow(run.simulation);
    EXPECT_EQ(hashes, grow(fresh.simulation));
    EXPECT_EQ(run.simulation.takeView()->options->seed, seed);
    ends.insert(hashes.back());
  }
  EXPECT_EQ(ends.size(), 3U);
}

TEST(Simulation, AFailingRewindKeepsTheSeed) {
  // Start fails with about half of the seeds
  TestRun run(compileText(
      "Lsystem: 1\nseed: 5\nderivation length: 2\nStart: {c=ran(1); if (c>0.5) {c=exp(10000);}}\nAxiom: A(c)\n"
      "A(x) --> A(x+ran(1))\nendlsystem\n"));
  std::uint64_t good = 0;
  while (run.simulation.rewind(++good).has_value() && good < 100) {
  }
  std::uint64_t bad = good;
  while (!run.simulation.rewind(++bad).has_value() && bad < 200) {
    good = bad;
  }
  ASSERT_LT(bad, 200U);
  EXPECT_EQ(run.simulation.seed(), good);
  expectSuccess(run.simulation.rewind());
  EXPECT_EQ(run.simulation.seed(), good);
  expectSuccess(run.simulation.rewind(good));
}

TEST(Simulation, TheViewVolumeIsTheBoundingBoxOfTheStringThatAStepReads) {
  // F(n) grows one unit a step: the step that makes step k reads a string of height k
  const auto program = compileText(
      "Lsystem: 1\nderivation length: 9\nAxiom: F(1)A(0,0)\nF(n) --> F(n+1)\n"
      "A(a,b) --> A(vvYmin(0),vvYmax(0))\nendlsystem\n");
  Simulation simulation(program, {turtle::PlantPlacement{}}, nullptr, {});
  expectSuccess(simulation.rewind());
  expectSuccess(simulation.step());
  EXPECT_EQ(simulation.stringText(), "F(2)A(0,1)");
  expectSuccess(simulation.step());
  EXPECT_EQ(simulation.stringText(), "F(3)A(0,2)");
}

}  // namespace
}  // namespace espalier::simulation::simulation_test
