#include "server/stream/viewers.h"

#include <future>

#include "server/server_core.h"
#include "server/session/session.h"
#include "tests/engine/simulation/simulation_fixture.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::viewers_test {
namespace {

/// Keeps the frames that a session sends.
class FrameConnection final : public Connection {
 public:
  void send(std::shared_ptr<const std::string> line) override {
    const std::lock_guard lock(mutex_);
    frames_.push_back(member(*line, "params"));
  }
  void closeWhenSent() override {}
  void remind(std::chrono::milliseconds) override {}
  [[nodiscard]] std::size_t outboxBytes() const override { return 0; }
  [[nodiscard]] std::string peerName() const override { return "viewer"; }
  [[nodiscard]] std::vector<std::string> frames() {
    const std::lock_guard lock(mutex_);
    return frames_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> frames_;
};

ServerOptions oneWorker() {
  ServerOptions options;
  options.logLevel = "off";
  options.workers = 1;
  return options;
}

/// A simulation that a test steps, and its viewers, whose worker the test can hold.
class ViewersTest : public testing::Test {
 protected:
  explicit ViewersTest()
      : simulation_(simulation::compileText("Lsystem: 1\nderivation length: 100\nAxiom: X(30000)A\nX(n) : n > 0 --> "
                                            "X(n-1)\nA --> FA\nendlsystem\n"),
                    {{}}, nullptr, {}) {
    // one module to begin with, long enough that some states fill the queue
    simulation::expectSuccess(simulation_.rewind());
    viewers_ = std::make_shared<Viewers>(Viewers::Options{.simulation = "s",
                                                          .account = &core_.accounts().server(),
                                                          .limits = &limits_,
                                                          .askLatest = [this] { ++asked_; }},
                                         core_.pool(), core_.log());
  }
  ~ViewersTest() override {
    viewers_->end("over");
    core_.waitForWorkers();
  }

  std::shared_ptr<Stream> open(protocol::StreamOpenParams params) {
    params.simulation = "s";
    auto stream = std::make_shared<Stream>("stream", std::move(params), session_, 100'000'000);
    viewers_->add(stream);
    handOver(true, stream);
    return stream;
  }
  /// As SimulationRunner::publishState, each state as large as `bytes`.
  void show(bool isDue = true, std::uint64_t bytes = 100'000) {
    if (viewers_->takeState(simulation_.completedSteps(), bytes, isDue)) {
      handOver(isDue, nullptr);
    }
  }
  void step() {
    simulation::expectSuccess(simulation_.step());
    show();
  }
  void hold() {
    auto held = std::make_shared<std::promise<void>>();
    core_.pool().post({.run =
                           [held, free = free_.get_future().share()] {
                             held->set_value();
                             free.wait();
                           },
                       .lane = Lane::Frame});
    held->get_future().wait();
  }
  void release() {
    free_.set_value();
    free_ = {};
    core_.waitForWorkers();
  }
  std::vector<std::string> frames() { return connection_->frames(); }

  simulation::Simulation simulation_;
  LiveLimits limits_{ServerLimits()};
  ServerCore core_{oneWorker()};
  std::shared_ptr<FrameConnection> connection_ = std::make_shared<FrameConnection>();
  std::shared_ptr<Session> session_ = std::make_shared<Session>("viewer", core_, connection_);
  std::shared_ptr<Viewers> viewers_;
  std::atomic<int> asked_{0};
  std::weak_ptr<const simulation::PlantsView> lastView_;

 private:
  void handOver(bool isDue, std::shared_ptr<Stream> first) {
    simulation_.followChanges(viewers_->wantDifferences());
    auto view = simulation_.takeView();
    lastView_ = view;
    viewers_->handOver({.plants = std::move(view),
                        .milliseconds = 0.0,
                        .queries = nullptr,
                        .isDue = isDue,
                        .first = std::move(first)});
  }

  std::promise<void> free_;
};

protocol::StreamOpenParams textParams(bool isDelta) {
  protocol::StreamOpenParams params;
  params.what = "string";
  params.isDelta = isDelta;
  return params;
}

TEST_F(ViewersTest, WhileNoFrameIsMadeTheSimulationGoesOnAndTheQueueHoldsSomeSteps) {
  hold();
  (void)open(textParams(false));
  for (int i = 0; i < 3; ++i) {
    step();
  }
  EXPECT_TRUE(frames().empty());
  release();
  const std::vector<std::string> all = frames();
  ASSERT_EQ(all.size(), 4U);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(member(all[i], "step"), std::to_string(i));
    EXPECT_EQ(member(all[i], "missed"), "0");
    EXPECT_EQ(member(all[i], "string"), "X(" + std::to_string(30'000 - i) + ")" + std::string(i, 'F') + "A");
  }
  EXPECT_EQ(asked_, 0);
}

TEST_F(ViewersTest, StepsThatFindTheQueueFullAreMissedAndADifferenceJoinsThem) {
  (void)open(textParams(true));
  core_.waitForWorkers();
  hold();
  // a state that no queue takes beside another one
  for (int i = 0; i < 50; ++i) {
    simulation::expectSuccess(simulation_.step());
    show(true, 600'000);
  }
  release();
  EXPECT_EQ(asked_, 1);
  // the worker asked for the latest
  show(false);
  core_.waitForWorkers();
  const std::vector<std::string> all = frames();
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(member(all[1], "step"), "1");
  EXPECT_EQ(member(all[2], "step"), "50");
  EXPECT_EQ(member(all[2], "missed"), "48");
  EXPECT_EQ(member(all[2], "key"), "true");
}

TEST_F(ViewersTest, EveryCountsOnlyTheStepsThatWereDue) {
  protocol::StreamOpenParams params = textParams(false);
  params.every = 10;
  (void)open(params);
  core_.waitForWorkers();
  hold();
  for (int i = 0; i < 35; ++i) {
    simulation::expectSuccess(simulation_.step());
    show(true, 600'000);
  }
  release();
  show(false);
  core_.waitForWorkers();
  const std::vector<std::string> all = frames();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(member(all[1], "step"), "35");
  // 10, 20 and 30
  EXPECT_EQ(member(all[1], "missed"), "3");
}

TEST_F(ViewersTest, CreditsAreNotForStatesThatWereHandedOverBefore) {
  protocol::StreamOpenParams params = textParams(false);
  params.credits = 1;
  const auto stream = open(params);
  core_.waitForWorkers();
  hold();
  for (int i = 0; i < 4; ++i) {
    step();
  }
  protocol::StreamAckParams ack;
  ack.sequence = 0;
  stream->acknowledge(ack);
  release();
  const std::vector<std::string> all = frames();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(member(all[1], "step"), "4");
  EXPECT_EQ(member(all[1], "missed"), "3");
}

TEST_F(ViewersTest, AViewerSeesNoStateFromBeforeItCame) {
  (void)open(textParams(false));
  core_.waitForWorkers();
  hold();
  step();
  step();
  (void)open(textParams(false));
  step();
  release();
  std::vector<std::string> steps;
  for (const std::string& frame : frames()) {
    steps.push_back(member(frame, "step"));
  }
  EXPECT_EQ(steps, (std::vector<std::string>{"0", "1", "2", "2", "3", "3"}));
}

TEST_F(ViewersTest, AfterTheEndNothingIsSentAndNoMemoryIsShared) {
  (void)open(textParams(false));
  core_.waitForWorkers();
  hold();
  step();
  step();
  viewers_->end("over");
  release();
  const std::vector<std::string> all = frames();
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(member(all[1], "reason"), "over");
  EXPECT_FALSE(viewers_->exist());
  EXPECT_TRUE(lastView_.expired());
}

}  // namespace
}  // namespace espalier::server::viewers_test
