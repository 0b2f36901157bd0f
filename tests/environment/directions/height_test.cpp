#include <gtest/gtest.h>

#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "tests/environment/query_builder.h"

namespace espalier::environment::height_test {
namespace {

TEST(Height, IsTheDistanceFromTheOriginAlongUp) {
  // up = (0, 3, 4) has length 5: the point (1, 5, 10) is (3*5 + 4*10) / 5 = 11 above the origin
  turtle::EnvironmentContext context;
  context.world.up = {0, 3, 4};
  const auto process = openProcess("height", "", context);
  QueryBuilder builder;
  builder.add({1, 5, 10}, {0, 6}).add({7, 0, 0}, {5});
  const ReplyTable table = answersOf(*process, builder.batch());
  EXPECT_NEAR(*table[0][0], 11.0, 1e-14);
  EXPECT_EQ(table[0][1], std::nullopt);
  EXPECT_EQ(*table[1][0], 0.0);
}

TEST(Height, AlongTheDefaultUpIsExactlyY) {
  const auto process = openProcess("height", "{}");
  QueryBuilder builder;
  builder.add({0.3, 0.1, -2}, {0});
  EXPECT_EQ(firstValues(answersOf(*process, builder.batch())), (std::vector<double>{0.1}));
}

TEST(Height, AModuleWithoutParametersGetsNoAnswer) {
  const auto process = openProcess("height", "");
  QueryBuilder builder;
  builder.add({0, 1, 0}, {}).add({0, 2, 0}, {0});
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  ASSERT_FALSE(process->step(builder.batch(), replies));
  EXPECT_EQ(replies.answeredCount, 1U);
  EXPECT_EQ(replies.surplusCount, 0U);
}

TEST(Height, RefusesAWorldWithoutUp) {
  auto made = makeProcess("height", "");
  turtle::EnvironmentContext context;
  context.world.up = {0, 0, 0};
  const auto error = made.value()->open(context);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->message, "Environment 'height' needs the world's vector 'up', which has length 0. Set it to 0 1 0.");
}

TEST(Height, UnitIsTheWorldsLengthUnit) {
  turtle::EnvironmentContext context;
  context.world.lengthUnit = "cm";
  EXPECT_EQ(openProcess("height", "", context)->describe().outputs[0].unit, "cm");
}

TEST(Height, TheLecturesModelDerivesThePrintedStrings) {
  core::MemoryFileProvider files;
  files.add("height.l",
            "Lsystem: 1\nderivation length: 3\nAxiom: F(0,0)A?E(0)\n"
            "F(x,z) < A > ?E(h) : h < 2 --> F(x,z+1)A\nF(x,z) < A > ?E(h) : h >= 2 --> *\n"
            "homomorphism\nF(x,y) --> @M(x,y)\nendlsystem\n");
  language::CompileInput input;
  input.modelFile = "height.l";
  const auto compiled = language::compile(input, files);
  ASSERT_NE(compiled.program, nullptr);
  auto made = makeProcess("height", "");
  simulation::Simulation simulation(compiled.program, {turtle::PlantPlacement{}}, std::move(made.value()),
                                    simulation::SimulationOptions{});
  ASSERT_FALSE(simulation.rewind());
  std::vector<std::string> strings{simulation.stringText()};
  while (!simulation.isFinished()) {
    ASSERT_FALSE(simulation.step());
    strings.push_back(simulation.stringText());
  }
  EXPECT_EQ(strings, (std::vector<std::string>{"F(0,0)A?E(0)", "F(0,0)F(0,1)A?E(0)", "F(0,0)F(0,1)F(0,2)A?E(1)",
                                               "F(0,0)F(0,1)F(0,2)?E(2)"}));
}

}  // namespace
}  // namespace espalier::environment::height_test
