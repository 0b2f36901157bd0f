// The behaviour of a server whose disk takes nothing more.
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <iterator>

#include "tests/server/server_fixture.h"

namespace espalier::server::full_disk_test {
namespace {

/// As long as it lives, no file of this process grows.
class FullDisk {
 public:
  FullDisk() {
    before_ = std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &limit_);
    ::rlimit nothing = limit_;
    nothing.rlim_cur = 1;
    ::setrlimit(RLIMIT_FSIZE, &nothing);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &limit_);
    std::signal(SIGXFSZ, before_);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  ::rlimit limit_{};
  void (*before_)(int) = nullptr;
};

constexpr std::string_view kModel =
    "Lsystem: 1\n#define K 2\nderivation length: 20\nAxiom: A\nA --> F(K)A\nendlsystem\n";

class FullDiskTest : public testing::Test {
 protected:
  FullDiskTest() {
    options_.dataFolder = folder_.path();
    start();
  }
  void start() {
    client_.reset();
    server_.reset();
    server_ = std::make_unique<RunningServer>(options_);
    client_ = connectTo(*server_);
  }
  [[nodiscard]] std::string state(const std::string& simulation) {
    const std::string told = resultOf(client_->request("simulation.get", named(simulation, R"("what":"model")")));
    return stringOf(*client_, simulation) + " " + member(told, "seed") + " " +
           member(member(told, "model"), "parameters");
  }

  TemporaryFolder folder_;
  ServerOptions options_;
  std::unique_ptr<RunningServer> server_;
  std::unique_ptr<client::Client> client_;
};

TEST_F(FullDiskTest, AChangeThatCannotBeSavedChangesNothing) {
  const std::string simulation = create(*client_, kModel, {}, R"("seed":3)");
  resultOf(client_->request("simulation.step", named(simulation, R"("steps":4)")));
  const std::string snapshot = member(resultOf(client_->request("simulation.save", named(simulation, ""))), "snapshot");
  const std::string before = state(simulation);
  {
    const FullDisk full;
    for (const auto& [method, more] :
         {std::pair<std::string, std::string>{
              "simulation.edit",
              R"("action":"insert","plant":0,"module":1,"modules":[{"symbol":"F","parameters":[9]}])"},
          {"simulation.edit", R"("action":"prune","plant":0,"module":0)"},
          {"simulation.set", R"("parameters":{"K":7})"},
          {"simulation.reset", ""},
          {"simulation.reset", R"("seed":9)"},
          {"simulation.restore", "\"snapshot\":\"" + snapshot + "\""},
          {"simulation.trace", R"("trace":true)"}}) {
      const protocol::Error error = errorOf(client_->request(method, named(simulation, more)));
      EXPECT_EQ(static_cast<int>(error.code), 1014) << method << more << ": " << error.message;
      EXPECT_TRUE(error.message.starts_with("Nothing was changed: ")) << method << more << ": " << error.message;
      EXPECT_EQ(state(simulation), before) << method << more;
    }
  }
  resultOf(client_->request(
      "simulation.edit",
      named(simulation, R"("action":"insert","plant":0,"module":1,"modules":[{"symbol":"F","parameters":[9]}])")));
  const std::string after = state(simulation);
  EXPECT_NE(after, before);
  start();
  EXPECT_EQ(state(simulation), after);
  EXPECT_EQ(member(resultOf(client_->request("simulation.get", named(simulation, R"("what":"traces")"))), "traces"),
            "[]");
}

TEST_F(FullDiskTest, ADeletionThatFailsDeletesNothing) {
  const std::string simulation = create(*client_, kModel, {}, R"("save":100)");
  resultOf(client_->request("simulation.step", named(simulation, R"("steps":4)")));
  const std::string before = state(simulation);
  {
    const FullDisk full;
    const protocol::Error error = errorOf(client_->request("simulation.delete", named(simulation)));
    EXPECT_EQ(static_cast<int>(error.code), 1014);
    EXPECT_TRUE(error.message.starts_with("Nothing was deleted: ")) << error.message;
  }
  EXPECT_EQ(state(simulation), before);
  EXPECT_EQ(resultOf(client_->request("simulation.delete", named(simulation))), "{}");
  EXPECT_EQ(errorOf(client_->request("simulation.step", named(simulation))).code, protocol::ErrorCode::NotFound);
  start();
  EXPECT_EQ(resultOf(client_->request("simulation.list", "{}")), R"({"simulations":[]})");
}

TEST_F(FullDiskTest, ATraceEndsAndTheSimulationSaysSo) {
  const std::string simulation = create(*client_, kModel, {}, R"("save":false,"trace":true)");
  resultOf(client_->request("simulation.step", named(simulation)));
  const auto listed = [&] { return resultOf(client_->request("simulation.list", "{}")); };
  EXPECT_EQ(listed().find("The trace ended"), std::string::npos);
  {
    const FullDisk full;
    resultOf(client_->request("simulation.step", named(simulation, R"("steps":2)")));
  }
  EXPECT_NE(listed().find("The trace ended, because the data folder does not take more of it"), std::string::npos)
      << listed();
  // it does not go on in the middle when there is room again
  resultOf(client_->request("simulation.step", named(simulation)));
  EXPECT_NE(listed().find("The trace ended"), std::string::npos);
  EXPECT_EQ(member(resultOf(client_->request("simulation.trace", named(simulation, R"("trace":true)"))), "traced"),
            "true");
  resultOf(client_->request("simulation.step", named(simulation)));
  EXPECT_EQ(listed().find("The trace ended"), std::string::npos);
}

TEST_F(FullDiskTest, ASimulationThatCannotBeSavedLeavesNoTrace) {
  const auto bytes = [&] {
    return member(member(resultOf(client_->request("server.status", "{}")), "memory"), "traceBytes");
  };
  const std::string original = create(*client_, kModel, {}, R"("save":false,"trace":true)");
  const std::string before = bytes();
  {
    const FullDisk full;
    for (const auto& [method, params] :
         {std::pair("simulation.create", createParams(kModel, {}, R"("trace":true)")),
          {"simulation.create", createParams(kModel, {}, R"("trace":true,"simulation":")" + original + "\"")}}) {
      EXPECT_EQ(static_cast<int>(errorOf(client_->request(method, params)).code), 1014) << params;
    }
  }
  EXPECT_EQ(bytes(), before);
  const std::filesystem::directory_iterator files(folder_.path() + "/traces");
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST_F(FullDiskTest, ATraceCountsWithTheBytesThatTheDiskTook) {
  const std::string simulation = create(*client_, kModel, {}, R"("save":false,"trace":true)");
  {
    const FullDisk full;
    resultOf(client_->request("simulation.step", named(simulation, R"("steps":9)")));
  }
  // another one takes its place
  resultOf(client_->request("simulation.trace", named(simulation, R"("trace":true)")));
  std::uintmax_t size = 0;
  for (const char* const number : {"1", "2"}) {
    size += std::filesystem::file_size(folder_.path() + "/traces/" + simulation + "-" + number + ".trace.zst");
  }
  EXPECT_EQ(member(member(resultOf(client_->request("server.status", "{}")), "memory"), "traceBytes"),
            std::to_string(size));
}

TEST_F(FullDiskTest, ADeletedSimulationLeavesNoTraces) {
  const std::string simulation = create(*client_, kModel, {}, R"("trace":true)");
  resultOf(client_->request("simulation.step", named(simulation)));
  const std::filesystem::path file = std::filesystem::path(folder_.path()) / "traces" / (simulation + "-1.trace.zst");
  EXPECT_TRUE(std::filesystem::exists(file));
  resultOf(client_->request("simulation.delete", named(simulation)));
  EXPECT_FALSE(std::filesystem::exists(file));
}

TEST_F(FullDiskTest, WhatTakesAPlaceAndIsNeverSavedLeavesNothingOfTheOldOne) {
  const std::string simulation = create(*client_, kModel);
  resultOf(client_->request("simulation.step", named(simulation)));
  EXPECT_EQ(create(*client_, kGrowth, "[]", R"("save":false,"simulation":")" + simulation + "\""), simulation);
  start();
  EXPECT_EQ(resultOf(client_->request("simulation.list", "{}")), R"({"simulations":[]})");
}

}  // namespace
}  // namespace espalier::server::full_disk_test
