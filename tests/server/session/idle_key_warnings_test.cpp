// Keys of environments that have no effect are told with the answer of simulation.create.
#include "tests/server/server_fixture.h"

namespace espalier::server::idle_key_warnings_test {
namespace {

TEST(IdleKeyWarnings, ComeWithTheAnswer) {
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string warned =
      resultOf(client->request("simulation.create", createParams(kGrowth, R"([{"type":"xylem","rhizosphere":true}])")));
  const std::string expected = "environment process 'xylem': 'rhizosphere' has no effect, because 'soil' is not given";
  EXPECT_NE(warned.find(expected), std::string::npos) << warned;
  const std::string silent =
      resultOf(client->request("simulation.create", createParams(kGrowth, R"([{"type":"xylem"}])")));
  EXPECT_EQ(silent.find("has no effect"), std::string::npos) << silent;
}

}  // namespace
}  // namespace espalier::server::idle_key_warnings_test
