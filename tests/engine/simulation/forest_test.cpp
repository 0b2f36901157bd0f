#include "engine/simulation/forest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>

#include "engine/simulation/snapshot.h"
#include "engine/simulation/snapshot_editing.h"
#include "engine/simulation/trace.h"
#include "tests/engine/simulation/crafted_snapshot.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::forest_test {
namespace {

// grows a random internode each step, asks the environment, drops a seed to its side in its third step and dies in its
// sixth
constexpr const char* kTree =
    "Lsystem: 1\n"
    "Module: ?Seed(asks), ?Death(asks)\n"
    "seed: 5\n"
    "derivation length: 12\n"
    "Axiom: A(1)?E(0)\n"
    "A(t) > ?E(x) : t == 3 --> F(1+ran(1))[+(90)f(3+ran(4))?Seed(1)]A(t+1)\n"
    "A(t) > ?E(x) : t == 6 --> ?Death(1)\n"
    "A(t) > ?E(x) : t != 3 && t != 6 --> F(1+ran(1))A(t+1)\n"
    "endlsystem\n";

// another model with other symbols, which waits and drops a seed of the first model
constexpr const char* kShrub =
    "Lsystem: 1\n"
    "Module: ?Seed(asks, model)\n"
    "derivation length: 4\n"
    "Axiom: G(0.5)B(1)?E(0)\n"
    "B(t) : t == 2 --> [f(2)?Seed(1,1)]B(t+1)\n"
    "B(t) --> B(t+1)G(ran(1))\n"
    "endlsystem\n";

/// Answers with a sum over the other queries that does not depend on their order, and remembers how much was asked.
class Neighbours final : public turtle::EnvironmentProcess {
 public:
  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = "neighbours";
    description.needs.position = true;
    description.isStateful = true;
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    symbols_ = context.symbols;
    asked_ = 0;
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    asked_ += static_cast<int>(queries.size());
    for (std::size_t query = 0; query < queries.size(); ++query) {
      EXPECT_EQ(symbols_.at(queries.symbol[query]), "E");
      double near = 0.0;
      for (const core::Vec3& other : queries.position) {
        near += std::floor(1e6 / (1.0 + length(other - queries.position[query])));
      }
      replies.set(queries, query, 0, near + asked_);
    }
    return std::nullopt;
  }
  [[nodiscard]] std::string save() const override { return std::to_string(asked_); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    asked_ = std::stoi(std::string(state));
    return std::nullopt;
  }

 private:
  std::vector<std::string> symbols_;
  int asked_ = 0;
};

PlantOrigin at(double x, double z, std::uint32_t model = 0) {
  PlantOrigin origin;
  origin.model = model;
  origin.placement.position = {x, 0, z};
  return origin;
}

std::vector<PlantOrigin> stand() {
  return {at(0, 0), at(6, 1), at(-7, 2, 1), at(3, 9), at(12, -4, 1), at(12, -4), at(5, 5)};
}

std::unique_ptr<Simulation> makeForest(std::vector<PlantOrigin> plants, SimulationOptions options = {}) {
  return std::make_unique<Simulation>(Programs{compileText(kTree), compileText(kShrub)}, std::move(plants),
                                      std::make_unique<Neighbours>(), std::move(options));
}

TEST(Forest, PlantsOfDifferentModelsShareOneEnvironment) {
  const auto forest = makeForest(stand());
  expectSuccess(forest->rewind());
  EXPECT_EQ(forest->plantCount(), 7U);
  expectSuccess(forest->step());
  // every plant asks once: the names are found in the symbols of its own model
  EXPECT_EQ(forest->statistics().queries, 7U);
  EXPECT_EQ(&forest->program(0), forest->programs()[1].get());
  EXPECT_EQ(forest->stringText(0).substr(0, 6), "G(0.5)");
  EXPECT_EQ(forest->stringText(1).substr(0, 2), "F(");
}

TEST(Forest, TheOrderOfThePlantsDoesNotMatter) {
  const auto forest = makeForest(stand());
  expectSuccess(forest->rewind());
  std::vector<std::uint64_t> hashes;
  for (int step = 0; step < 12; ++step) {
    expectSuccess(forest->step());
    hashes.push_back(forest->stateHash());
  }
  EXPECT_GT(forest->plantCount(), 12U);
  std::vector<PlantOrigin> plants = stand();
  std::minstd_rand shuffler(3);
  for (int turn = 0; turn < 5; ++turn) {
    std::shuffle(plants.begin(), plants.end(), shuffler);
    const auto other = makeForest(plants);
    expectSuccess(other->rewind());
    for (int step = 0; step < 12; ++step) {
      expectSuccess(other->step());
      ASSERT_EQ(other->stateHash(), hashes[static_cast<std::size_t>(step)]) << turn << " " << step;
    }
  }
}

TEST(Forest, TheNumberOfThreadsDoesNotMatter) {
  std::vector<std::uint64_t> hashes;
  for (const unsigned threads : {1U, 2U, 4U}) {
    SimulationOptions options;
    options.threads = threads;
    const auto forest = makeForest(stand(), options);
    expectSuccess(forest->rewind());
    for (int step = 0; step < 12; ++step) {
      expectSuccess(forest->step());
    }
    hashes.push_back(forest->stateHash());
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

// doubles its apices at random and says so once a step
constexpr const char* kBush =
    "Lsystem: 1\n"
    "seed: 5\n"
    "derivation length: 12\n"
    "Axiom: P(0)A\n"
    "P(n) : n == 9 { printf(\"nine\\n\"); } --> P(n+1)\n"
    "P(n) : n != 9 --> P(n+1)\n"
    "A --> F(ran(1))[+A]A : 0.7\n"
    "A --> F(ran(2))A : 0.3\n"
    "endlsystem\n";

TEST(Forest, PlantsDerivedSideBySideAreThoseDerivedOneAfterTheOther) {
  // 40 plants with up to some thousand modules each
  std::vector<PlantOrigin> plants;
  for (int i = 0; i < 40; ++i) {
    plants.push_back(at(3 * i % 17, i));
  }
  std::minstd_rand shuffler(4);
  std::vector<std::uint64_t> hashes;
  std::vector<std::string> said;
  for (const unsigned threads : {1U, 2U, 4U, 4U}) {
    SimulationOptions options;
    options.threads = threads;
    options.messages = [&said](core::MessageKind, std::string_view text) { said.back() += text; };
    said.emplace_back();
    Simulation forest(Programs{compileText(kBush)}, plants, nullptr, options);
    expectSuccess(forest.rewind());
    std::uint64_t modules = 0;
    for (int step = 0; step < 12; ++step) {
      expectSuccess(forest.step());
      modules = forest.statistics().modules;
    }
    EXPECT_GT(modules, 50'000U);
    hashes.push_back(forest.stateHash());
    std::shuffle(plants.begin(), plants.end(), shuffler);
  }
  EXPECT_EQ(hashes, std::vector<std::uint64_t>(4, hashes[0]));
  EXPECT_EQ(said[0].size(), 40 * std::string("nine\n").size());
  EXPECT_EQ(said, std::vector<std::string>(4, said[0]));
}

TEST(Forest, OfPlantsDerivedSideBySideTheFirstThatFailsIsNamed) {
  // plant by plant: the eighth and all after it get an infinite number in the tenth step; each says something before
  const auto model = [](const std::string& word, const std::string& number) {
    return compileText(
        "Lsystem: 1\n"
        "derivation length: 12\n"
        "Axiom: P(0)A\n"
        "P(n) : n == 9 { printf(\"" +
        word + "\"); } --> P(" + number +
        ")\n"
        "P(n) --> P(n+1)\n"
        "A --> F[+A]A\n"
        "endlsystem\n");
  };
  const Programs programs{model("well ", "n"), model("ill ", "exp(100*n)")};
  std::vector<PlantOrigin> plants;
  for (int i = 0; i < 40; ++i) {
    plants.push_back(at(i, 0, i < 7 ? 0 : 1));
  }
  std::vector<std::string> said;
  std::vector<std::string> messages;
  std::vector<std::uint64_t> hashes;
  for (const unsigned threads : {1U, 2U, 4U}) {
    SimulationOptions options;
    options.threads = threads;
    options.messages = [&said](core::MessageKind, std::string_view text) { said.back() += text; };
    said.emplace_back();
    Simulation forest(programs, plants, nullptr, options);
    expectSuccess(forest.rewind());
    for (int step = 0; step < 9; ++step) {
      expectSuccess(forest.step());
    }
    const std::uint64_t before = forest.stateHash();
    const auto error = forest.step();
    ASSERT_TRUE(error.has_value());
    messages.push_back(error->message);
    EXPECT_EQ(error->plant, 7U) << error->message;
    hashes.push_back(forest.stateHash());
    EXPECT_EQ(hashes.back(), before);
  }
  EXPECT_EQ(said, std::vector<std::string>(3, "well well well well well well well ill "));
  EXPECT_EQ(messages, std::vector<std::string>(3, messages[0]));
  EXPECT_EQ(hashes, std::vector<std::uint64_t>(3, hashes[0]));
}

TEST(Forest, ASeedBecomesAPlantAtTheEndOfTheStep) {
  const auto forest = makeForest({at(0, 0)});
  expectSuccess(forest->rewind());
  for (int step = 0; step < 3; ++step) {
    expectSuccess(forest->step());
  }
  // the module is in the string since step 3 and is read by the pass of step 4
  EXPECT_EQ(forest->plantCount(), 1U);
  expectSuccess(forest->answer());
  EXPECT_NE(forest->stringText(0).find("?Seed(0)"), std::string::npos) << forest->stringText(0);
  expectSuccess(forest->step());
  ASSERT_EQ(forest->plantCount(), 2U);
  EXPECT_EQ(forest->plant(1).birthStep, 4U);
  EXPECT_EQ(forest->stringText(1), "A(1)?E(0)");
  EXPECT_EQ(forest->statistics().births, 1U);
  EXPECT_EQ(forest->statistics().plants, 2U);
  // on the ground, where the turtle was: + turns to the left, towards -x, at the height of the internodes before
  const core::Vec3 place = forest->plant(1).origin.placement.position;
  EXPECT_EQ(place.y, 0.0);
  EXPECT_LT(place.x, -3.0);
  // it is asked for only once
  expectSuccess(forest->step());
  EXPECT_EQ(forest->plantCount(), 2U);
  // its own age, its own random numbers
  EXPECT_EQ(forest->plantState(1).step, 1U);
  EXPECT_NE(forest->stringText(1).substr(0, 8), forest->stringText(0).substr(0, 8));
}

TEST(Forest, ADeadPlantIsGoneAndItsNumberIsNotGivenAgain) {
  const auto forest = makeForest({at(0, 0), at(20, 0)});
  expectSuccess(forest->rewind());
  for (int step = 0; step < 7; ++step) {
    ASSERT_TRUE(forest->plant(0).isAlive());
    expectSuccess(forest->step());
  }
  EXPECT_FALSE(forest->plant(0).isAlive());
  EXPECT_EQ(forest->plant(0).deathStep, 7U);
  EXPECT_EQ(forest->stringText(0), "");
  EXPECT_EQ(forest->statistics().deaths, 2U);
  EXPECT_EQ(forest->livingPlantCount(), 2U);  // their seedlings
  const auto scene = forest->scene().value();
  for (const turtle::Segment& segment : scene.segments) {
    EXPECT_GE(segment.plant, 2U);
  }
  // the seedlings have seeds of their own
  for (int step = 0; step < 5; ++step) {
    expectSuccess(forest->step());
  }
  EXPECT_EQ(forest->plantCount(), 8U);  // born with the steps 4, 8 and 12
}

TEST(Forest, ASeedCanBeOfAnotherModel) {
  const auto forest = makeForest({at(0, 0, 1)});
  expectSuccess(forest->rewind());
  for (int step = 0; step < 3; ++step) {
    expectSuccess(forest->step());
  }
  ASSERT_EQ(forest->plantCount(), 2U);
  EXPECT_EQ(forest->plant(1).origin.model, 0U);
  EXPECT_EQ(forest->stringText(1), "A(1)?E(0)");
  // the name Seed is in both models, with other numbers of parameters
  EXPECT_NE(forest->stringText(0).find("?Seed(0,1)"), std::string::npos) << forest->stringText(0);
}

TEST(Forest, ALostSeedIsToldSo) {
  SimulationOptions options;
  options.seeds.maximumPlants = 1;
  const auto forest = makeForest({at(0, 0)}, options);
  expectSuccess(forest->rewind());
  for (int step = 0; step < 4; ++step) {
    expectSuccess(forest->step());
  }
  EXPECT_EQ(forest->plantCount(), 1U);
  EXPECT_NE(forest->stringText(0).find("?Seed(-1)"), std::string::npos) << forest->stringText(0);
}

TEST(Forest, AShortModelEndsWithItsCompany) {
  const auto lasting = [](const std::string& steps) {
    return compileText("Lsystem: 1\nderivation length: " + steps +
                       "\nAxiom: A(0)\nA(n) --> A(GetDerivationLength(0))\nendlsystem\n");
  };
  Simulation alone({lasting("2")}, {at(0, 0)}, nullptr, {});
  Simulation together({lasting("2"), lasting("5")}, {at(0, 0, 0), at(1, 0, 1)}, nullptr, {});
  for (Simulation* simulation : {&alone, &together}) {
    expectSuccess(simulation->rewind());
    expectSuccess(simulation->step());
  }
  EXPECT_EQ(alone.stringText(0), "A(2)");
  EXPECT_EQ(together.stringText(0), "A(5)");
  EXPECT_EQ(together.stringText(1), "A(5)");
}

TEST(Forest, AModelThatIsNotThereIsAnErrorThatNamesTheModule) {
  const auto program = compileText(
      "Lsystem: 1\nModule: ?Seed(asks, model)\nderivation length: 3\nAxiom: F?Seed(1,3)\nF --> F\nendlsystem\n");
  Simulation forest({program}, {at(0, 0)}, nullptr, {});
  expectSuccess(forest.rewind());
  const std::uint64_t hash = forest.stateHash();
  const auto error = forest.step();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message,
            "step 1, plant 0, module 2 ('Seed'): there is no model 3. Parameter 2 is the number of a model, 1 to 1 in "
            "the order in which they are listed, or 0 for the plant's own. The simulation stays at step 0.");
  EXPECT_EQ(forest.stateHash(), hash);
}

TEST(Forest, AFailedStepFoundsNobodyAndKillsNobody) {
  const auto log = std::make_shared<FakeEnvironmentLog>();
  Simulation forest({compileText(kTree)}, {at(0, 0), at(20, 0)}, std::make_unique<FakeEnvironment>(log), {});
  expectSuccess(forest.rewind());
  for (int step = 0; step < 12; ++step) {
    const std::uint64_t hash = forest.stateHash();
    const std::size_t count = forest.plantCount();
    log->nextError = turtle::EnvironmentError{"away.", true};
    ASSERT_TRUE(forest.step().has_value());
    ASSERT_EQ(forest.stateHash(), hash) << step;
    ASSERT_EQ(forest.plantCount(), count);
    expectSuccess(forest.step());
  }
  // as a run without failures
  Simulation smooth({compileText(kTree)}, {at(0, 0), at(20, 0)},
                    std::make_unique<FakeEnvironment>(std::make_shared<FakeEnvironmentLog>()), {});
  expectSuccess(smooth.rewind());
  for (int step = 0; step < 12; ++step) {
    expectSuccess(smooth.step());
  }
  EXPECT_EQ(forest.stateHash(), smooth.stateHash());
  EXPECT_EQ(forest.plantCount(), 8U);
}

TEST(Forest, ASnapshotGoesOnAsTheRunDid) {
  const auto forest = makeForest(stand());
  expectSuccess(forest->rewind());
  for (int step = 0; step < 8; ++step) {
    expectSuccess(forest->step());
  }
  expectSuccess(forest->answer());
  const std::string saved = snapshotOf(*forest);
  auto read = readSnapshotInfo(saved);
  ASSERT_TRUE(read.has_value());
  SnapshotInfo& info = *read;
  ASSERT_EQ(info.models.size(), 2U);
  EXPECT_EQ(info.plants.size(), forest->plantCount());
  auto programs = compileModels(info, core::Limits{});
  ASSERT_TRUE(programs.has_value());
  for (const unsigned threads : {1U, 4U}) {
    SimulationOptions options;
    options.threads = threads;
    Simulation again(*programs, std::vector<PlantOrigin>(info.plantCount), std::make_unique<Neighbours>(), options);
    expectSuccess(again.restore(saved));
    EXPECT_EQ(again.stateHash(), forest->stateHash());
    EXPECT_EQ(again.livingPlantCount(), forest->livingPlantCount());
    EXPECT_EQ(snapshotOf(again), saved);
    const auto original = makeForest(stand());
    expectSuccess(original->restore(saved));
    for (int step = 0; step < 8; ++step) {
      expectSuccess(again.step());
      expectSuccess(original->step());
      ASSERT_EQ(again.stateHash(), original->stateHash()) << step;
    }
  }
}

TEST(Forest, RewindingTakesBackWhoCameAndWhoWent) {
  const auto forest = makeForest(stand());
  expectSuccess(forest->rewind());
  const std::uint64_t start = forest->stateHash();
  for (int step = 0; step < 9; ++step) {
    expectSuccess(forest->step());
  }
  const std::uint64_t later = forest->stateHash();
  expectSuccess(forest->rewind());
  EXPECT_EQ(forest->stateHash(), start);
  EXPECT_EQ(forest->plantCount(), 7U);
  for (int step = 0; step < 9; ++step) {
    expectSuccess(forest->step());
  }
  EXPECT_EQ(forest->stateHash(), later);
}

TEST(Forest, ARunEndsForAllPlantsTogether) {
  const auto forest = makeForest(stand());
  expectSuccess(forest->rewind());
  EXPECT_EQ(forest->derivationLength(), 12U);  // the longest of the models
  while (!forest->isFinished()) {
    expectSuccess(forest->step());
  }
  EXPECT_EQ(forest->completedSteps(), 12U);
}

TEST(Forest, WithoutLivingPlantsThereIsNoStep) {
  const auto program =
      compileText("Lsystem: 1\nModule: ?Death(asks)\nderivation length: 9\nAxiom: F?Death(1)\nF --> F\nendlsystem\n");
  Simulation forest({program}, {at(0, 0)}, nullptr, {});
  expectSuccess(forest.rewind());
  expectSuccess(forest.step());
  EXPECT_TRUE(forest.isFinished());
  const auto error = forest.step();
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(
      error->message,
      "step 2: no plant is alive, there is no further step. Rewind the simulation to run it again. The simulation "
      "stays at step 1.");
}

TEST(Forest, ATraceOfItCanBeReplayed) {
  core::StringSink sink;
  const auto recorder = std::make_shared<TraceRecorder>(sink);
  Simulation forest({compileText(kTree), compileText(kShrub)}, stand(),
                    record(std::make_unique<Neighbours>(), recorder), {});
  expectSuccess(forest.rewind());
  recorder->begin(forest);
  for (int step = 0; step < 12; ++step) {
    expectSuccess(forest.step());
    recorder->complete(forest);
  }
  const std::string trace = sink.take();
  const auto replayed = replayTrace(trace, 2);
  ASSERT_TRUE(replayed.has_value()) << replayed.error();
  const ReplayResult& result = *replayed;
  EXPECT_FALSE(result.divergence.has_value()) << result.divergence->message;
  EXPECT_EQ(result.steps, 12U);
}

TEST(Forest, APictureHasThePlantsColours) {
  std::vector<PlantOrigin> plants{at(0, 0), at(20, 0, 1)};
  plants[1].colourShift = 7;
  const auto forest = makeForest(plants);
  expectSuccess(forest->rewind());
  expectSuccess(forest->step());
  const auto scene = forest->scene().value();
  ASSERT_FALSE(scene.segments.empty());
  for (const turtle::Segment& segment : scene.segments) {
    EXPECT_EQ(segment.colour, segment.plant == 1 ? 135 : 128);
  }
}

TEST(Forest, EditingKnowsTheModelOfThePlant) {
  const auto forest = makeForest({at(0, 0), at(20, 0, 1)});
  expectSuccess(forest->rewind());
  StringEdit edit;
  edit.plant = 1;
  edit.modules = {{"G", {2.0}}};
  const auto edited = editString(snapshotOf(*forest), edit);
  ASSERT_TRUE(edited.has_value());
  expectSuccess(forest->restore(*edited));
  EXPECT_EQ(forest->stringText(1), "G(2)G(0.5)B(1)?E(0)");
  edit.plant = 0;
  EXPECT_FALSE(editString(snapshotOf(*forest), edit).has_value());
}

}  // namespace
}  // namespace espalier::simulation::forest_test
