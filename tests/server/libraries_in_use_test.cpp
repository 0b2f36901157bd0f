// The memory of libraries in C, and the bytes on the disk: counted and bounded.
#include <gtest/gtest.h>

#include <filesystem>
#include <new>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "server/running/turn_meter.h"
#include "server/store/compression.h"
#include "tests/server/raw_peer.h"
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

/// Answers that do not compress, for long.
constexpr std::string_view kNoise =
    "Lsystem: 1\nderivation length: 100000\nAxiom: A\nA --> F(ran(9))+(ran(360))?E(ran(1))A\nendlsystem\n";

std::string tracedParams() {
  return createParams(kNoise, R"([{"type":"height"}])", R"("trace":true,"seed":1)");
}

std::vector<std::string> filesIn(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code missing;
  for (const auto& entry : std::filesystem::directory_iterator(folder, missing)) {
    names.push_back(entry.path().filename().string());
  }
  return names;
}

TEST(LibrariesInUse, TracesOnDiskAreBounded) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  options.limits.traceBytes = 20'000;
  const auto traced = [](client::Client& client) { return client.request("simulation.create", tracedParams()); };
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
  // bytes on the disk count after a restart, too
  options.limits.traceBytes = 10'000;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const protocol::Error error = errorOf(traced(*client));
  EXPECT_EQ(member(error.data, "limit"), "traceBytes") << error.message;
  resultOf(client->request("simulation.delete", named(first)));
  EXPECT_LT(memoryOf(*client, "traceBytes"), 1'000U);
  resultOf(traced(*client));
}

TEST(LibrariesInUse, ADeletedTraceGivesAllOfItsRoomBack) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  const RunningServer server(options);
  const auto client = connectTo(server);
  for (int i = 0; i < 5; ++i) {
    // it is still being written
    const std::string simulation = member(resultOf(client->request("simulation.create", tracedParams())), "simulation");
    resultOf(client->request("simulation.step", named(simulation, R"("steps":3)")));
    EXPECT_GT(memoryOf(*client, "traceBytes"), 100U);
    resultOf(client->request("simulation.delete", named(simulation)));
    EXPECT_EQ(memoryOf(*client, "traceBytes"), 0U);
  }
  // one that has ended, and one beside it that goes on
  const std::string simulation = member(resultOf(client->request("simulation.create", tracedParams())), "simulation");
  resultOf(client->request("simulation.step", named(simulation)));
  for (const char* const isTraced : {"false", "true"}) {
    resultOf(client->request("simulation.trace", named(simulation, std::string("\"trace\":") + isTraced)));
  }
  EXPECT_EQ(filesIn(folder.path() + "/traces").size(), 2U);
  resultOf(client->request("simulation.delete", named(simulation)));
  EXPECT_EQ(memoryOf(*client, "traceBytes"), 0U);
  // nor does one take room that never began, because its simulation could not be made
  errorOf(client->request("simulation.create", createParams(kNoise, R"([{"type":"hight"}])", R"("trace":true)")));
  EXPECT_EQ(memoryOf(*client, "traceBytes"), 0U);
  EXPECT_EQ(filesIn(folder.path() + "/traces"), std::vector<std::string>());
}

TEST(LibrariesInUse, TracesOfEachTokenAreBounded) {
  const TemporaryFolder folder;
  ServerOptions options;
  options.dataFolder = folder.path();
  options.httpHost = "127.0.0.1";
  options.limits.accountTraceBytes = 20'000;
  for (const char* name : {"ann", "ben"}) {
    options.tokens.push_back(tokenOf(name, name, {protocol::Role::Controller}));
  }
  const auto as = [](const RunningServer& server, const char* token) {
    client::ClientOptions own;
    own.token = token;
    return connectTo(server, own);
  };
  const auto ownBytes = [](client::Client& client) {
    return std::stoull(member(member(resultOf(client.request("server.status", "{}")), "account"), "traceBytes"));
  };
  std::string first;
  std::uint64_t bytesOfAnn = 0;
  std::uint64_t bytesOfBen = 0;
  {
    const RunningServer server(options);
    const auto ann = as(server, "ann");
    const auto ben = as(server, "ben");
    first = member(resultOf(ann->request("simulation.create", tracedParams())), "simulation");
    const std::string other = member(resultOf(ben->request("simulation.create", tracedParams())), "simulation");
    const auto listed = [&] { return resultOf(ann->request("simulation.list", "{}")); };
    for (int i = 0; i < 300 && listed().find("The trace ended") == std::string::npos; ++i) {
      resultOf(ann->request("simulation.step", named(first, R"("steps":5)")));
      EXPECT_LE(ownBytes(*ann), 20'000U);
    }
    EXPECT_NE(listed().find("The trace ended, because all traces of the account 'ann' have "), std::string::npos);
    EXPECT_NE(listed().find(" of 20000 bytes (limit accountTraceBytes): "), std::string::npos) << listed();
    // the limit of one account does not bind the other
    const std::uint64_t before = ownBytes(*ben);
    EXPECT_EQ(member(resultOf(ben->request("simulation.step", named(other, R"("steps":5)"))), "step"), "5");
    EXPECT_GT(ownBytes(*ben), before);
    // a fork counts for its maker
    const std::string fork = member(resultOf(ben->request("simulation.fork", named(first))), "simulation");
    bytesOfBen = ownBytes(*ben);
    resultOf(ben->request("simulation.step", named(fork)));
    EXPECT_GT(ownBytes(*ben), bytesOfBen);
  }
  options.limits.accountTraceBytes = 15'000;
  const RunningServer server(options);
  const auto ann = as(server, "ann");
  const auto ben = as(server, "ben");
  bytesOfAnn = ownBytes(*ann);
  bytesOfBen = ownBytes(*ben);
  EXPECT_GT(bytesOfAnn, 15'000U);
  EXPECT_GT(bytesOfBen, 100U);
  EXPECT_EQ(memoryOf(*ann, "traceBytes"), bytesOfAnn + bytesOfBen);
  const protocol::Error error = errorOf(ann->request("simulation.create", tracedParams()));
  EXPECT_EQ(member(error.data, "limit"), "accountTraceBytes") << error.message;
  resultOf(ben->request("simulation.create", tracedParams()));
  RawPeer browser(server.httpAddress());
  browser.send("GET /metrics HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  std::string told;
  for (std::string line = browser.line(); line != "(closed)" && line != "(timeout)"; line = browser.line()) {
    told += line.starts_with("espalier_account_trace_bytes{account=\"ann\"} ") ? line : "";
  }
  EXPECT_EQ(told, "espalier_account_trace_bytes{account=\"ann\"} " + std::to_string(bytesOfAnn));
  // also when another account deletes it
  resultOf(ben->request("simulation.delete", named(first)));
  EXPECT_EQ(ownBytes(*ann), 0U);
}

}  // namespace
}  // namespace espalier::server::libraries_in_use_test
