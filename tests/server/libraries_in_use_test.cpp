// What libraries in C take, and what lies on the disk: counted and bounded.
#include <gtest/gtest.h>

#include <new>
#include <string>
#include <thread>

#include "server/running/turn_meter.h"
#include "server/store/compression.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::libraries_in_use_test {
namespace {

/// Doubles its string in each step.
constexpr std::string_view kDoublingAgain =
    "Lsystem: 1\nderivation length: 40\nAxiom: A(1)\nA(x) --> A(x)A(x)\nendlsystem\n";

/// A number of `memory` of server.status.
std::uint64_t memoryOf(client::Client& client, std::string_view name) {
  return std::stoull(member(member(resultOf(client.request("server.status", "{}")), "memory"), name));
}

TEST(LibrariesInUse, SearchTreesOfEnvironmentsCount) {
  constexpr int kSpheres = 40'000;
  std::string spheres;
  for (int i = 0; i < kSpheres; ++i) {
    spheres += (i == 0 ? "[" : ",[") + std::to_string(i % 200) + ",9," + std::to_string(i / 200) + ",0.3]";
  }
  const std::string obstacles = R"([{"type":"obstacles","spheres":[)" + spheres + "]}]";
  constexpr std::string_view kAsking = "Lsystem: 1\nderivation length: 9\nAxiom: F?E(1)\nF --> FF\nendlsystem\n";
  const RunningServer server;
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kAsking, obstacles);
  resultOf(client->request("simulation.step", named(simulation)));
  // lists of spheres and their bounds take less than 100 bytes each, the tree of Embree more than as much again
  const std::uint64_t bytes = memoryOf(*client, "environmentBytes");
  EXPECT_GT(bytes, 150U * kSpheres);
  resultOf(client->request("simulation.delete", named(simulation)));
  while (memoryOf(*client, "environmentBytes") > 0) {
    std::this_thread::yield();
  }
}

TEST(LibrariesInUse, CompressionAndTheDatabaseCount) {
  // a turn has what zstd takes
  Account account("zstd", {.memoryBytes = 1'200'000}, nullptr);
  const std::string bytes(400'000, 'x');
  {
    TurnMeter meter(account, MemoryKind::Strings);
    const core::WorkMeter::Scope scope(&meter);
    const std::string packed = compress(bytes);
    EXPECT_EQ(decompress(packed), bytes);
    EXPECT_GT(meter.account().memoryBytes(), 0U);
  }
  EXPECT_EQ(account.memoryBytes(), 0U);
  Account narrow("zstd", {.memoryBytes = 0}, nullptr);
  {
    TurnMeter meter(narrow, MemoryKind::Strings);
    const core::WorkMeter::Scope scope(&meter);
    EXPECT_THROW((void)compress(bytes), std::bad_alloc);
    EXPECT_TRUE(meter.isRefused());
  }
  // SQLite counts for the server, and not for an owner
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation = create(*client, kDoublingAgain);
  resultOf(client->request("simulation.step", named(simulation, R"("steps":14)")));
  EXPECT_GT(memoryOf(*client, "databaseBytes"), 100'000U);
  EXPECT_EQ(member(member(resultOf(client->request("server.status", "{}")), "account"), "databaseBytes"), "0");
  EXPECT_GE(memoryOf(*client, "usedBytes"), 100'000U);
}

TEST(LibrariesInUse, TracesOnDiskAreBounded) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  options.limits.traceBytes = 20'000;
  // answers that do not compress
  constexpr std::string_view kNoise =
      "Lsystem: 1\nderivation length: 100000\nAxiom: A\nA --> F(ran(9))+(ran(360))?E(ran(1))A\nendlsystem\n";
  const auto traced = [&](client::Client& client) {
    return client.request("simulation.create",
                          createParams(kNoise, R"([{"type":"height"}])", R"("trace":true,"seed":1)"));
  };
  std::string first;
  {
    const RunningServer server(options);
    const auto client = connectTo(server);
    first = member(resultOf(traced(*client)), "simulation");
    const auto used = [&] { return memoryOf(*client, "traceBytes"); };
    const auto listed = [&] { return resultOf(client->request("simulation.list", "{}")); };
    for (int i = 0; i < 300 && listed().find("limit traceBytes") == std::string::npos; ++i) {
      resultOf(client->request("simulation.step", named(first, R"("steps":5)")));
      EXPECT_LE(used(), 20'000U);
    }
    // the simulation goes on without, and says so
    EXPECT_NE(listed().find("The trace ended, because all traces together have "), std::string::npos) << listed();
    EXPECT_GT(used(), 15'000U);
    resultOf(client->request("simulation.step", named(first)));
  }
  // what is on disk counts after a restart, too
  options.limits.traceBytes = 10'000;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const protocol::Error error = errorOf(traced(*client));
  EXPECT_EQ(member(error.data, "limit"), "traceBytes") << error.message;
  resultOf(client->request("simulation.delete", named(first)));
  EXPECT_LT(memoryOf(*client, "traceBytes"), 1'000U);
  resultOf(traced(*client));
}

}  // namespace
}  // namespace espalier::server::libraries_in_use_test
