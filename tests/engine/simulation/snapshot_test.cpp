#include "engine/simulation/snapshot.h"

#include <random>

#include "engine/turtle/weather.h"
#include "tests/engine/simulation/crafted_snapshot.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::snapshot_test {
namespace {

std::string messageOf(const tl::expected<SnapshotInfo, core::SimulationError>& result) {
  return result ? std::string() : result.error().message;
}

class SnapshotContinuation : public testing::TestWithParam<core::Compatibility> {};

TEST_P(SnapshotContinuation, RestoredRunsHaveEqualHashesNowAndAfterEveryFurtherStep) {
  const auto program = compileText(kAskingModel, {}, GetParam());
  TestRun run(program, 2);
  expectSuccess(run.simulation.rewind());
  for (int i = 0; i < 3; ++i) {
    expectSuccess(run.simulation.step());
  }
  const std::string snapshot = snapshotOf(run.simulation);
  for (const unsigned threads : {1U, 3U}) {
    SimulationOptions options;
    options.threads = threads;
    options.seed = 99;
    TestRun restored(program, 2, options);
    expectSuccess(restored.simulation.restore(snapshot));
    TestRun original(program, 2);
    expectSuccess(original.simulation.restore(snapshot));
    EXPECT_EQ(restored.simulation.stateHash(), run.simulation.stateHash());
    for (int i = 0; i < 5; ++i) {
      expectSuccess(original.simulation.step());
      expectSuccess(restored.simulation.step());
      EXPECT_EQ(restored.simulation.stateHash(), original.simulation.stateHash()) << "step " << i;
      EXPECT_EQ(restored.simulation.stringText(1), original.simulation.stringText(1));
    }
    if (threads == 1) {
      // the run that was never interrupted
      TestRun undisturbed(program, 2);
      expectSuccess(undisturbed.simulation.rewind());
      for (int i = 0; i < 8; ++i) {
        expectSuccess(undisturbed.simulation.step());
      }
      EXPECT_EQ(restored.simulation.stateHash(), undisturbed.simulation.stateHash());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Modes, SnapshotContinuation,
                         testing::Values(core::Compatibility::Espalier, core::Compatibility::Cpfg));

TEST(Snapshot, HoldsTheWorldWithItsWeather) {
  SimulationOptions options;
  options.world.lengthUnit = "cm";
  options.world.up = {0, 0, 1};
  options.world.north = {0, 1, 0};
  options.world.stepDurationDays = 0.25;
  options.world.latitudeDegrees = -33.5;
  options.world.start = "2026-06-21T06:00+10:00";
  options.world.baseTemperature = 8;
  options.world.weather = std::make_shared<const turtle::Weather>(*turtle::Weather::read("time,wind\n0,1\n9,2\n", ""));
  const turtle::World world = options.world;
  const auto program = compileText(kAskingModel);
  TestRun run(program, 1, options);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  const std::string snapshot = snapshotOf(run.simulation);
  EXPECT_EQ(snapshot[8], 3);
  EXPECT_EQ(readSnapshotInfo(snapshot).value().world, world);
  // a simulation of another world goes on in that of the run, and its environment is told
  TestRun restored(program);
  expectSuccess(restored.simulation.rewind());
  EXPECT_NE(restored.log->context.world, world);
  expectSuccess(restored.simulation.restore(snapshot));
  EXPECT_EQ(restored.simulation.options().world, world);
  EXPECT_EQ(restored.log->context.world, world);
  expectSuccess(restored.simulation.step());
  EXPECT_EQ(restored.log->batches.back().timeDays, 0.25);
  EXPECT_EQ(restored.simulation.options().world.weather->mean("wind", 8, 10), 1.5);
  // a run in the default world keeps the bytes of an older version
  TestRun plain(program);
  expectSuccess(plain.simulation.rewind());
  EXPECT_EQ(snapshotOf(plain.simulation)[8], 1);
}

TEST(Snapshot, HoldsTheRepliesOfTheStepUnderWay) {
  const auto program = compileText(kAskingModel);
  TestRun run(program);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  expectSuccess(run.simulation.answer());
  const std::string snapshot = snapshotOf(run.simulation);
  TestRun restored(program);
  expectSuccess(restored.simulation.restore(snapshot));
  EXPECT_TRUE(restored.simulation.isAnswered());
  EXPECT_EQ(restored.simulation.stringText(), run.simulation.stringText());
  EXPECT_EQ(restored.simulation.stateHash(), run.simulation.stateHash());
  // the environment is not asked again
  EXPECT_EQ(restored.log->stepCount, 0);
  expectSuccess(restored.simulation.step());
  expectSuccess(run.simulation.step());
  EXPECT_EQ(restored.simulation.stateHash(), run.simulation.stateHash());
}

TEST(Snapshot, ThatFailsOnItsWayInLeavesTheRunBeforeAsItWas) {
  const auto program = compileText(kAskingModel);
  TestRun run(program);
  TestRun twin(program);
  expectSuccess(run.simulation.rewind());
  expectSuccess(twin.simulation.rewind());
  expectSuccess(run.simulation.step());
  const std::string snapshot = snapshotOf(run.simulation);
  expectSuccess(run.simulation.step());
  expectSuccess(twin.simulation.step());
  expectSuccess(twin.simulation.step());

  // the environment does not take the state
  auto error = run.simulation.restore(crafted(snapshot, [](auto& content) { content.environmentState = "none"; }));
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(error->message.find("cannot be restored: the state is not a number"), std::string::npos) << error->message;
  EXPECT_EQ(run.simulation.completedSteps(), 2U);
  EXPECT_EQ(run.simulation.stateHash(), twin.simulation.stateHash());
  // it takes the state, and then gives no answers
  run.log->nextError = turtle::EnvironmentError{"it has gone", true};
  error = run.simulation.restore(crafted(snapshot, [](auto& content) { content.isAnswered = true; }));
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(error->message.find("it has gone"), std::string::npos) << error->message;
  EXPECT_EQ(run.simulation.completedSteps(), 2U);
  EXPECT_EQ(run.simulation.stateHash(), twin.simulation.stateHash());

  expectSuccess(run.simulation.step());
  expectSuccess(twin.simulation.step());
  EXPECT_EQ(run.simulation.stateHash(), twin.simulation.stateHash());
}

TEST(Snapshot, IsEnoughToCompileItsModelAnywhere) {
  const auto program = compileText(kAskingModel, "angle increment: 30\n");
  SimulationOptions options;
  options.name = "stand";
  options.seed = 12;
  options.hasSeed = true;
  TestRun run(program, 2, options);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  auto read = readSnapshotInfo(snapshotOf(run.simulation));
  ASSERT_EQ(messageOf(read), "");
  SnapshotInfo& info = *read;
  EXPECT_EQ(info.name, "stand");
  EXPECT_EQ(info.completedSteps, 1U);
  EXPECT_EQ(info.seed, 12U);
  EXPECT_TRUE(info.hasSeed);
  EXPECT_EQ(info.derivationLength, 8U);
  EXPECT_EQ(info.plantCount, 2U);
  EXPECT_EQ(info.plants[1].origin.placement.position, (core::Vec3{4, 0, 0}));
  EXPECT_EQ(info.environmentName, "fake");
  const auto compiled = compileModels(info, core::Limits{});
  ASSERT_TRUE(compiled.has_value());
  ASSERT_EQ(compiled->size(), 1U);
  const language::Program& again = *compiled->front();
  EXPECT_EQ(again.hash, info.models.front().programHash);
  EXPECT_EQ(again.view.angleIncrementDegrees, 30.0);
}

TEST(Snapshot, OfAnotherModelIsRefused) {
  TestRun run(compileText(kAskingModel));
  expectSuccess(run.simulation.rewind());
  TestRun other(compileText("Lsystem: 1\nderivation length: 1\nAxiom: A\nA --> B\nendlsystem\n"));
  expectSuccess(other.simulation.rewind());
  const std::uint64_t hash = other.simulation.stateHash();
  const auto error = other.simulation.restore(snapshotOf(run.simulation));
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->code, core::SimulationErrorCode::Snapshot);
  EXPECT_EQ(error->message,
            "The snapshot was made with another model, other definitions or in another mode than 'model.l'. Resume it "
            "without naming a model, or with the files it was made with. The simulation stays at step 0.");
  EXPECT_EQ(other.simulation.stateHash(), hash);
}

TEST(Snapshot, OfAnotherEnvironmentIsRefused) {
  const auto program = compileText(kAskingModel);
  TestRun run(program);
  expectSuccess(run.simulation.rewind());
  TestRun bare(program, 1, {}, false);
  const auto error = bare.simulation.restore(snapshotOf(run.simulation));
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(
      error->message,
      "The snapshot was made with environment 'fake' and the simulation has no environment. Give it the one it was "
      "made with.");
}

TEST(Snapshot, ThatIsNoneIsSaidToBeNone) {
  EXPECT_EQ(
      messageOf(readSnapshotInfo("<svg>")),
      "This is not a snapshot: it does not begin with 'ESPALIER'. Snapshots are made with 'espalier run MODEL.l -o "
      "NAME.snapshot'.");
}

TEST(Snapshot, OfANewerVersionIsRefused) {
  TestRun run(compileText(kAskingModel));
  expectSuccess(run.simulation.rewind());
  std::string snapshot = snapshotOf(run.simulation);
  snapshot[kSnapshotMagic.size()] = 9;
  EXPECT_EQ(
      messageOf(readSnapshotInfo(snapshot)),
      "The snapshot has version 9; this Espalier reads versions 1 to 3. Use the Espalier that made it, or a newer "
      "one.");
}

TEST(Snapshot, CutOffAnywhereIsAnError) {
  const auto program = compileText(kAskingModel);
  TestRun run(program);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  const std::string snapshot = snapshotOf(run.simulation);
  const std::uint64_t hash = run.simulation.stateHash();
  for (std::size_t length = 0; length < snapshot.size(); ++length) {
    ASSERT_NE(messageOf(readSnapshotInfo(snapshot.substr(0, length))), "") << length;
    ASSERT_TRUE(run.simulation.restore(snapshot.substr(0, length)).has_value()) << length;
  }
  EXPECT_EQ(messageOf(readSnapshotInfo(snapshot.substr(0, 40))),
            "The snapshot is cut off: it ends in the middle of a section. Use a complete copy of the file.");
  EXPECT_EQ(run.simulation.stateHash(), hash);
}

// behind the checksum: snapshot_check_test.cpp
TEST(Snapshot, ADamagedByteIsFoundByTheChecksum) {
  const auto program = compileText(kAskingModel);
  TestRun run(program);
  expectSuccess(run.simulation.rewind());
  expectSuccess(run.simulation.step());
  const std::string snapshot = snapshotOf(run.simulation);
  const std::uint64_t hash = run.simulation.stateHash();
  std::mt19937 random(1);
  for (int round = 0; round < 2000; ++round) {
    std::string damaged = snapshot;
    damaged[random() % damaged.size()] ^= static_cast<char>(1U << (random() % 8U));
    ASSERT_TRUE(run.simulation.restore(damaged).has_value());
  }
  std::string last = snapshot;
  last.back() ^= 1;
  EXPECT_EQ(messageOf(readSnapshotInfo(last)),
            "The snapshot is damaged: its checksum does not agree with its content. Use an intact copy.");
  EXPECT_EQ(run.simulation.stateHash(), hash);
}

}  // namespace
}  // namespace espalier::simulation::snapshot_test
