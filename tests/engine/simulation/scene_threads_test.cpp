// Scenes of strings with branches, drawn by homomorphism: several threads draw what one draws, and warn as one does.

#include <algorithm>
#include <string>
#include <vector>

#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::scene_threads_test {
namespace {

struct Drawn {
  turtle::Scene scene;
  std::vector<std::string> messages;
};

// a tree of 120,000 modules
std::string treeWith(const std::string& homomorphism) {
  return "Lsystem: 1\n"
         "derivation length: 14\n"
         "Axiom: I(1)T(14)\n"
         "T(n) : n>0 --> I(n)/(137)[+(20+n)T(n-1)]I(0)[-(31)T(n-1)]\n"
         "homomorphism\n" +
         homomorphism + "endlsystem\n";
}

Drawn draw(const std::string& model, unsigned threads) {
  Drawn drawn;
  SimulationOptions options;
  options.threads = threads;
  options.messages = [&](core::MessageKind, std::string_view message) { drawn.messages.emplace_back(message); };
  Simulation simulation(compileText(model), {turtle::PlantPlacement{}}, nullptr, options);
  expectSuccess(simulation.rewind());
  while (!simulation.isFinished()) {
    expectSuccess(simulation.step());
  }
  EXPECT_GT(simulation.string().size(), 100'000U);
  auto scene = simulation.scene();
  EXPECT_TRUE(scene.has_value());
  if (scene) {
    drawn.scene = std::move(*scene);
  }
  // a second time: what was learnt at the first changes nothing
  auto again = simulation.scene();
  EXPECT_TRUE(again.has_value() && std::ranges::equal(again->segments, drawn.scene.segments));
  return drawn;
}

void expectSame(const std::string& homomorphism) {
  const std::string model = treeWith(homomorphism);
  const Drawn one = draw(model, 1);
  EXPECT_FALSE(one.scene.empty());
  for (const unsigned threads : {2U, 4U}) {
    const Drawn several = draw(model, threads);
    ASSERT_EQ(several.scene.segments.size(), one.scene.segments.size());
    EXPECT_TRUE(std::ranges::equal(several.scene.segments, one.scene.segments));
    EXPECT_EQ(several.scene.polygons, one.scene.polygons);
    EXPECT_EQ(several.scene.balls, one.scene.balls);
    EXPECT_EQ(several.scene.cylinders, one.scene.cylinders);
    EXPECT_EQ(several.messages, one.messages);
  }
}

TEST(SceneThreads, DrawTheImagesThatOneThreadDraws) {
  // images of several lines, of none, of images; organs
  expectSame("maximum depth: 3\nI(n) : n>2 --> !(n)G(n)F(1)\nI(n) : n==1 --> L(n)\nL(x) --> {+F(x)+F(x)}[@O(x)]\n");
}

// images that one thread draws alone: they depend on more than their module, or branches are none
TEST(SceneThreads, DrawImagesOfChanceBlocksNeighboursAndBrackets) {
  expectSame("I(n) --> F(n)\n[ --> F(1)\n");
  expectSame("I(n) --> F(n)]\n");
  expectSame("I(n) --> [F(n)\n");
  expectSame("I(n) --> ]F(n)[\n");
  expectSame("I(n) --> F(n)\n] --> F(1)]\n");
  expectSame("I(n) --> +(ran(90))F(n)\n");
  expectSame("I(n) : {s=s+1;} n>1 --> F(s)\n");
  expectSame("I(m) < I(n) --> F(m)\nI(n) --> F(n)\n");
  expectSame("I(n) --> F(n) : 0.5\nI(n) --> G(n) : 0.5\n");
}

TEST(SceneThreads, WarnAsOneThreadDoes) {
  const std::string divides = "I(n) : n<13 --> F(1/n)\n";
  expectSame(divides);
  EXPECT_FALSE(draw(treeWith(divides), 2).messages.empty());
}

}  // namespace
}  // namespace espalier::simulation::scene_threads_test
