#include "server/store/backup.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <thread>

#include "server/store/store.h"
#include "tests/server/server_fixture.h"

namespace espalier::server::backup_test {
namespace {

TEST(Backup, OfARunningServerHoldsWhatItHasAnswered) {
  const TemporaryFolder folder;
  const std::string data = folder.path() + "/data";
  ServerOptions options;
  options.dataFolder = data;
  const RunningServer server(options);
  const auto client = connectTo(server);
  const std::string simulation =
      create(*client, "Lsystem: 1\nderivation length: 100000\nAxiom: A(0.5)\nA(x) --> A(ran(1)+x/2)\nendlsystem\n");
  // the server goes on saving meanwhile
  std::atomic<bool> isDone{false};
  std::thread load([&] {
    const auto other = connectTo(server);
    while (!isDone) {
      resultOf(other->request("simulation.step", named(simulation)));
    }
  });
  for (int i = 0; i < 5; ++i) {
    const auto stepOf = [](const std::string& json) { return std::stoull(member(json, "step")); };
    const std::uint64_t least =
        stepOf(resultOf(client->request("simulation.get", named(simulation, R"("what":"statistics")"))));
    const std::string file = folder.path() + "/copy" + std::to_string(i);
    ASSERT_EQ(backUpStore(data, file).value_or(""), "");
    struct stat state {};
    ASSERT_EQ(::stat(file.c_str(), &state), 0);
    EXPECT_EQ(state.st_mode & 0777, 0600U);
    const std::string restored = folder.path() + "/restored" + std::to_string(i);
    ASSERT_EQ(restoreStore(file, restored).value_or(""), "");
    ServerOptions otherOptions;
    otherOptions.dataFolder = restored;
    const RunningServer other(otherOptions);
    EXPECT_GE(
        stepOf(resultOf(connectTo(other)->request("simulation.get", named(simulation, R"("what":"statistics")")))),
        least);
  }
  isDone = true;
  load.join();
}

TEST(Backup, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  const std::string data = folder.path() + "/data";
  const std::string file = folder.path() + "/copy";
  EXPECT_EQ(backUpStore(folder.path(), file).value_or(""),
            "'" + folder.path() + "' is no data folder: it has no file espalier.sqlite. Give the folder of --data.");
  Store store(data);
  ASSERT_EQ(store.open(), std::nullopt);
  ASSERT_EQ(store.save({"sim-1", "one", 0}, "first"), std::nullopt);
  EXPECT_EQ(backUpStore(data, folder.path() + "/none/copy").value_or(""),
            "there is no folder '" + folder.path() + "/none'. Make it first, or give another name.");
  ASSERT_EQ(backUpStore(data, file), std::nullopt);
  EXPECT_EQ(backUpStore(data, file).value_or(""),
            "'" + file + "' is there already. Give another name, or move it away first.");
  EXPECT_FALSE(std::filesystem::exists(file + ".partial"));

  // a folder that is in use, or full
  EXPECT_EQ(restoreStore(file, data).value_or(""),
            "the data folder '" + data + "' is used by another server. Stop it, or give --data another folder.");
  const std::string again = folder.path() + "/again";
  ASSERT_EQ(restoreStore(file, again), std::nullopt);
  EXPECT_EQ(restoreStore(file, again).value_or(""),
            "the data folder '" + again + "' holds a database already (" + again +
                "/espalier.sqlite). Give an empty folder, or move the database and its -wal away first.");
  EXPECT_EQ(restoreStore(folder.path() + "/nothing", again).value_or(""),
            "there is no file '" + folder.path() + "/nothing'. Give a file that `espalier backup` made.");

  // a copy that is damaged, or no copy
  std::ofstream(folder.path() + "/text") << std::string(5'000, 'x');
  const std::string fresh = folder.path() + "/fresh";
  EXPECT_EQ(restoreStore(folder.path() + "/text", fresh).value_or(""),
            "'" + folder.path() +
                "/text' is no backup of a data folder, or it is damaged (file is not a database). Give a file that "
                "`espalier backup` made.");
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  const std::string problem = restoreStore(file, fresh).value_or("");
  EXPECT_NE(problem.find("is no backup of a data folder, or it is damaged"), std::string::npos) << problem;
  EXPECT_FALSE(std::filesystem::exists(fresh + "/espalier.sqlite"));
}

}  // namespace
}  // namespace espalier::server::backup_test
