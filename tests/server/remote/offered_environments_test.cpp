#include "server/remote/offered_environments.h"

#include <gtest/gtest.h>

namespace espalier::server::offered_environments_test {
namespace {

using Outcome = OfferedEnvironments::Outcome;

/// A peer that never answers.
class Silent final : public AskedPeer {
 public:
  explicit Silent(std::string owner) : owner_(std::move(owner)) {}
  [[nodiscard]] std::string ask(std::string_view, const protocol::Body&, std::shared_ptr<PendingCall>) override {
    return "1";
  }
  [[nodiscard]] PeerTerms terms() const override { return {}; }
  void forget(const std::string&) override {}
  [[nodiscard]] std::string owner() const override { return owner_; }
  [[nodiscard]] bool hasMissedHeartbeat() const override { return isSilent; }
  bool isSilent = false;

 private:
  std::string owner_;
};

Outcome offer(OfferedEnvironments& offered, const std::shared_ptr<Silent>& peer) {
  bool isAnnounced = false;
  const Outcome outcome = offered.offer("light", peer, [&isAnnounced] { isAnnounced = true; });
  EXPECT_EQ(isAnnounced, outcome != Outcome::Taken);
  return outcome;
}

TEST(OfferedEnvironments, OnlyTheSameTokenTakesANameOver) {
  OfferedEnvironments offered;
  const auto alice = std::make_shared<Silent>("alice");
  const auto other = std::make_shared<Silent>("alice");
  const auto bob = std::make_shared<Silent>("bob");
  EXPECT_EQ(offer(offered, alice), Outcome::New);
  EXPECT_EQ(offer(offered, alice), Outcome::New);
  alice->isSilent = true;
  EXPECT_EQ(offer(offered, bob), Outcome::Taken);
  EXPECT_EQ(offered.find("light")->peer.lock(), alice);
  EXPECT_EQ(offer(offered, other), Outcome::Replaced);
  EXPECT_EQ(offered.find("light")->peer.lock(), other);
  offered.withdraw(other.get());
  EXPECT_EQ(offer(offered, bob), Outcome::New);
}

TEST(OfferedEnvironments, WithoutTokensTheOlderPeerMustHaveMissedItsHeartbeat) {
  OfferedEnvironments offered;
  auto first = std::make_shared<Silent>("");
  const auto second = std::make_shared<Silent>("");
  EXPECT_EQ(offer(offered, first), Outcome::New);
  EXPECT_EQ(offer(offered, second), Outcome::Taken);
  first->isSilent = true;
  EXPECT_EQ(offer(offered, second), Outcome::Replaced);
  EXPECT_EQ(offer(offered, first), Outcome::Taken);
}

TEST(OfferedEnvironments, TheQuestionOfASimulationFailsWhenItsPeerIsReplaced) {
  OfferedEnvironments offered;
  const auto first = std::make_shared<Silent>("alice");
  const auto second = std::make_shared<Silent>("alice");
  EXPECT_EQ(offer(offered, first), Outcome::New);
  const auto call = std::make_shared<PendingCall>();
  ASSERT_TRUE(offered.find("light", call));
  EXPECT_FALSE(call->wait(std::chrono::milliseconds(0)));
  EXPECT_EQ(offer(offered, second), Outcome::Replaced);
  const auto outcome = call->wait(std::chrono::milliseconds(0));
  ASSERT_TRUE(outcome);
  ASSERT_FALSE(outcome->has_value());
  EXPECT_EQ(outcome->error().kind, LinkFailure::Kind::Closed);
  EXPECT_EQ(outcome->error().message, "was replaced by another connection that offers the name");
}

/// A peer that answers at once.
class Answering final : public AskedPeer {
 public:
  explicit Answering(std::string owner) : owner_(std::move(owner)) {}
  [[nodiscard]] std::string ask(std::string_view, const protocol::Body&, std::shared_ptr<PendingCall> call) override {
    ++askedCount;
    call->complete(protocol::Payload());
    return "1";
  }
  [[nodiscard]] PeerTerms terms() const override { return {}; }
  void forget(const std::string&) override {}
  [[nodiscard]] std::string owner() const override { return owner_; }
  [[nodiscard]] bool hasMissedHeartbeat() const override { return false; }
  int askedCount = 0;

 private:
  std::string owner_;
};

TEST(OfferedEnvironments, AnotherTokenDoesNotGetTheSimulationOfAnEnvironmentThatHasGone) {
  OfferedEnvironments offered;
  OfferedLink link("light", offered);
  const auto announce = [] {};
  auto alice = std::make_shared<Answering>("alice");
  (void)offered.offer("light", alice, announce);
  EXPECT_TRUE(link.call("environment.step", "{}", std::chrono::seconds(1)));
  offered.withdraw(alice.get());
  const auto mallory = std::make_shared<Answering>("mallory");
  EXPECT_EQ(offered.offer("light", mallory, announce), Outcome::New);
  EXPECT_EQ(link.generation(), 0U);
  const auto outcome = link.call("environment.restore", "{}", std::chrono::seconds(1));
  ASSERT_FALSE(outcome);
  EXPECT_EQ(outcome.error().message, "is offered with another token than before ('alice')");
  EXPECT_EQ(mallory->askedCount, 0);
  // a simulation that has not asked yet takes it
  EXPECT_TRUE(OfferedLink("light", offered).call("environment.step", "{}", std::chrono::seconds(1)));
  offered.withdraw(mallory.get());
  (void)offered.offer("light", alice, announce);
  EXPECT_TRUE(link.call("environment.step", "{}", std::chrono::seconds(1)));
}

}  // namespace
}  // namespace espalier::server::offered_environments_test
