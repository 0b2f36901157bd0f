// A step asks the environment the same, whatever of the pass before it takes over.
#include <cmath>
#include <memory>
#include <random>

#include "engine/simulation/snapshot_editing.h"
#include "tests/engine/simulation/crafted_snapshot.h"
#include "tests/engine/simulation/simulation_fixture.h"

namespace espalier::simulation::query_takeover_test {
namespace {

/// Needs everything of a query, and answers some, by their places.
class PlaceReader final : public turtle::EnvironmentProcess {
 public:
  explicit PlaceReader(std::shared_ptr<FakeEnvironmentLog> log) : log_(std::move(log)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description;
    description.name = "place";
    description.needs = {true, true, true, true, true, true, true, true, false};
    return description;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (log_->nextError) {
      return std::exchange(log_->nextError, std::nullopt);
    }
    log_->batches.assign(1, queries);
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const core::Vec3& p = queries.position[query];
      const double place = std::floor(10.0 * (p.x + p.y + p.z));
      if (std::fmod(place, 3.0) == 0.0) {
        replies.set(queries, query, 0, place);
      }
    }
    return std::nullopt;
  }

 private:
  std::shared_ptr<FakeEnvironmentLog> log_;
};

struct PlaceRun {
  explicit PlaceRun(const std::string& model)
      : simulation(compileText(model), TestRun::placements(2), std::make_unique<PlaceReader>(log), {}) {
    expectSuccess(simulation.rewind());
  }
  std::shared_ptr<FakeEnvironmentLog> log = std::make_shared<FakeEnvironmentLog>();
  Simulation simulation;
};

/// A long trunk with tips that grow and ask.
std::string longModel(std::mt19937& dice) {
  std::string trunk;
  for (int i = 0; i < 900; ++i) {
    trunk += i % 30 == 0 ? "[&(20)F(1)?E(0)A(0)]" : "F(0.1)+(3)F(0.1)-(2.5)F(0.1)/(0.5)F(0.1)";
  }
  return "Lsystem: 1\nderivation length: 1000\nAxiom: " + trunk + "[+(20)A(1)?E(0)]" + trunk + "[f(1)" + trunk +
         "?P(0,0,0)]" + trunk + "B(0)\nf(x) --> f(x+0.25)\nA(x) : ran(1) < 0." + std::to_string(1 + dice() % 9) +
         " --> F(1)[-(30)A(x+1)]?E(0)\nB(x) --> [&(10)F(x)?E(x)]B(x+1)\n?E(x) : ran(1) < 0.05 --> ?E(x+1)\n" +
         "endlsystem\n";
}

void expectSame(const turtle::QueryBatch& a, const turtle::QueryBatch& b) {
  ASSERT_EQ(a.module, b.module);
  EXPECT_EQ(a.plant, b.plant);
  EXPECT_TRUE(a.position == b.position);
  EXPECT_TRUE(a.heading == b.heading);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.parameters, b.parameters);
  EXPECT_EQ(a.following, b.following);
  EXPECT_EQ(a.followingParameters, b.followingParameters);
}

TEST(QueryTakeover, EachStepAsksWhatARestoredSimulationAsks) {
  int compared = 0;
  for (unsigned round = 0; round < 6; ++round) {
    std::mt19937 dice(round);
    const std::string model = longModel(dice);
    PlaceRun run(model);
    Simulation& simulation = run.simulation;
    ASSERT_GT(simulation.statistics().modules, 20'000U);
    std::string saved;
    for (int i = 0; i < 20; ++i) {
      switch (dice() % 8) {
        case 0:
          // the environment fails after the turtle wrote into the string
          run.log->nextError = turtle::EnvironmentError{"away", true};
          EXPECT_TRUE(simulation.step().has_value());
          break;
        case 1: {
          const EditedSnapshot edited = editString(
              snapshotOf(simulation),
              {.kind = StringEdit::Kind::Insert, .plant = 1, .module = dice() % 20'000, .modules = {{"F", {0.5}}}});
          if (edited) {
            expectSuccess(simulation.restore(*edited));
          }
          break;
        }
        case 2:
          expectSuccess(simulation.answer());
          break;
        case 3:
          simulation.followChanges(dice() % 2 == 0);
          break;
        case 4:
          if (!saved.empty()) {
            expectSuccess(simulation.restore(saved));
          }
          saved = snapshotOf(simulation);
          break;
        default:
          break;
      }
      // the other one takes nothing over
      PlaceRun whole(model);
      expectSuccess(whole.simulation.restore(snapshotOf(simulation)));
      expectSuccess(simulation.step());
      expectSuccess(whole.simulation.step());
      ASSERT_EQ(simulation.stateHash(), whole.simulation.stateHash()) << "round " << round << ", step " << i;
      // the answers of a step that was answered before came with the snapshot
      if (!whole.log->batches.empty()) {
        expectSame(run.log->batches.at(0), whole.log->batches.at(0));
        ++compared;
      }
    }
  }
  EXPECT_GT(compared, 80);
}

}  // namespace
}  // namespace espalier::simulation::query_takeover_test
