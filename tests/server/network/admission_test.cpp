#include "server/network/admission.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/remote/limits.h"

namespace espalier::server::admission_test {
namespace {

TEST(Admission, TheConnectionThatHasWaitedLongestGivesItsPlaceToANewOne) {
  Admission admission;
  admission.setBounds({.sessions = 10, .waiting = 3, .perAddress = 0});
  std::string closed;
  std::vector<std::unique_ptr<Admission::Place>> places;
  for (const char name : {'a', 'b', 'c', 'd'}) {
    places.push_back(admission.enter(Side::Protocol, {}));
    places.back()->onEvicted([&closed, name] { closed += name; });
  }
  EXPECT_EQ(closed, "a");
  EXPECT_FALSE(places[0]->trust());
  // one that said hello stays, one that asked again goes last
  EXPECT_TRUE(places[1]->trust());
  places[2]->renew();
  for (int i = 0; i < 2; ++i) {
    places.push_back(admission.enter(Side::Protocol, {}));
  }
  EXPECT_EQ(closed, "ad");
  EXPECT_EQ(admission.waitingCount(Side::Protocol), 3U);
  EXPECT_EQ(admission.trustedCount(), 1U);
  places.clear();
  EXPECT_EQ(admission.waitingCount(Side::Protocol), 0U);
  EXPECT_EQ(admission.trustedCount(), 0U);
}

TEST(Admission, TheSidesHavePlacesOfTheirOwn) {
  Admission admission;
  admission.setBounds({.sessions = 10, .waiting = 1, .perAddress = 0});
  bool isClosed = false;
  const auto client = admission.enter(Side::Protocol, {});
  client->onEvicted([&isClosed] { isClosed = true; });
  std::vector<std::unique_ptr<Admission::Place>> browsers;
  for (int i = 0; i < 5; ++i) {
    browsers.push_back(admission.enter(Side::Http, {}));
  }
  EXPECT_FALSE(isClosed);
  EXPECT_TRUE(client->trust());
}

TEST(Admission, AClosingConnectionMayDropItsPlaceAtOnce) {
  Admission admission;
  admission.setBounds({.sessions = 1, .waiting = 1, .perAddress = 0});
  auto first = admission.enter(Side::Protocol, {});
  first->onEvicted([&first] { first.reset(); });
  const auto second = admission.enter(Side::Protocol, {});
  EXPECT_EQ(first, nullptr);
  EXPECT_TRUE(admission.evictOne());
  EXPECT_FALSE(admission.evictOne());
}

TEST(Admission, NoMoreAreTrustedThanThereMayBeSessions) {
  Admission admission;
  admission.setBounds({.sessions = 1, .waiting = 5, .perAddress = 0});
  auto first = admission.enter(Side::Protocol, {});
  const auto second = admission.enter(Side::Protocol, {});
  EXPECT_TRUE(first->trust());
  EXPECT_TRUE(first->trust());
  EXPECT_FALSE(second->trust());
  first.reset();
  EXPECT_TRUE(second->trust());
}

TEST(Admission, AnAddressHasItsOwnBoundAndLoopbackHasNone) {
  Admission admission;
  admission.setBounds({.sessions = 10, .waiting = 10, .perAddress = 2});
  std::vector<std::unique_ptr<Admission::Place>> places;
  for (int i = 0; i < 3; ++i) {
    places.push_back(admission.enter(i == 0 ? Side::Http : Side::Protocol, "192.0.2.7"));
    EXPECT_EQ(places.back()->isBeyondAddressBound(), i == 2);
  }
  EXPECT_FALSE(admission.enter(Side::Protocol, "192.0.2.8")->isBeyondAddressBound());
  for (int i = 0; i < 3; ++i) {
    places.push_back(admission.enter(Side::Protocol, {}));
    EXPECT_FALSE(places.back()->isBeyondAddressBound());
  }
  places.clear();
  EXPECT_FALSE(admission.enter(Side::Protocol, "192.0.2.7")->isBeyondAddressBound());
}

TEST(Admission, FewDescriptorsLowerTheBounds) {
  ServerLimits limits;
  limits.sessions = 1'000;
  limits.waitingConnections = 500;
  const std::size_t needed = AdmissionBounds::neededDescriptors(limits);
  EXPECT_EQ(AdmissionBounds::of(limits, needed).sessions, 1'000U);
  EXPECT_EQ(AdmissionBounds::of(limits, needed).waiting, 500U);
  for (const std::size_t descriptors : {64U, 256U, 1'024U}) {
    const AdmissionBounds bounds = AdmissionBounds::of(limits, descriptors);
    EXPECT_GT(bounds.sessions, 0U);
    EXPECT_GT(bounds.waiting, 0U);
    EXPECT_LT(bounds.sessions + 2 * bounds.waiting, descriptors);
  }
}

}  // namespace
}  // namespace espalier::server::admission_test
