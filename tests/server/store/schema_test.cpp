#include "server/store/schema.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>

#include "server/store/store.h"
#include "tests/server/server_fixture.h"
#include "tests/support/places.h"

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

/// A data folder with a copy of the database that version 1 has written: a simulation at step 5 with a checkpoint, and
/// a loaded model. Nobody makes this file again.
class OldFolder : public testing::Test {
 protected:
  OldFolder() { fs::copy_file(fs::path(sourceFolder()) / "tests/server/store/fixtures/version1.sqlite", file()); }
  [[nodiscard]] std::string file() const { return folder_.path() + "/espalier.sqlite"; }

  [[nodiscard]] std::int64_t version() const {
    Database database;
    database.open(file());
    return versionOf(database);
  }

  /// A server that uses the folder has everything, and goes on.
  void expectAllIsThere() {
    ServerOptions options;
    options.dataFolder = folder_.path();
    const RunningServer server(options);
    const auto client = connectTo(server);
    const auto hash = [&] {
      return member(resultOf(client->request("simulation.get", named(kSimulation, R"("what":"state-hash")"))),
                    "stateHash");
    };
    EXPECT_EQ(hash(), "e21dc4ffabc3ee78");
    EXPECT_EQ(stringOf(*client, kSimulation).substr(0, 23), "F(0.8083203231713106)?E");
    resultOf(client->request("simulation.restore", named(kSimulation, R"("checkpoint":"young")")));
    resultOf(client->request("simulation.step", named(kSimulation, R"("steps":2)")));
    EXPECT_EQ(hash(), "e21dc4ffabc3ee78");
    resultOf(client->request("simulation.create", R"({"model":{"loaded":"model-1"}})"));
  }

  static constexpr const char* kSimulation = "sim-d8f7b28eea29";
  const TemporaryFolder folder_;
};

TEST_F(OldFolder, OfVersionOneIsReadAndBecomesTheNewestVersion) {
  ASSERT_EQ(version(), 1);
  expectAllIsThere();
  EXPECT_EQ(version(), storeVersion());
  // and again
  expectAllIsThere();
}

/// Makes `count` of the changes from version 1 on in a transaction, in a process that is then killed.
void changeAndDie(const std::string& file, std::size_t count) {
  const pid_t child = ::fork();
  if (child == 0) {
    Database database;
    database.open(file);
    database.begin();
    for (const char* change : storeChanges().subspan(1, count)) {
      database.execute(change);
    }
    if (count == storeChanges().size() - 1) {
      database.execute(("PRAGMA user_version = " + std::to_string(storeVersion())).c_str());
    }
    ::kill(::getpid(), database.problem() ? SIGABRT : SIGKILL);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
}

TEST_F(OldFolder, AProgramThatIsKilledWithinTheChangeLeavesTheOldVersionWhole) {
  for (std::size_t count = 0; count < storeChanges().size(); ++count) {
    changeAndDie(file(), count);
    EXPECT_EQ(version(), 1) << count;
  }
  expectAllIsThere();
  EXPECT_EQ(version(), storeVersion());
}

TEST_F(OldFolder, AChangeThatFailsChangesNothing) {
  {
    Database database;
    database.open(file());
    // a later change would add this column
    database.execute("ALTER TABLE simulations ADD COLUMN owner TEXT NOT NULL DEFAULT ''");
    ASSERT_EQ(database.problem(), std::nullopt);
  }
  Store store(folder_.path());
  const std::string problem = store.open().value_or("");
  EXPECT_NE(problem.find("cannot use the data folder"), std::string::npos) << problem;
  EXPECT_EQ(version(), 1);
}

TEST(StoreVersion, ANewerDatabaseIsLeftAlone) {
  const TemporaryFolder folder;
  {
    Database database;
    database.open(folder.path() + "/espalier.sqlite");
    database.execute("CREATE TABLE other(id INTEGER)");
    database.execute("PRAGMA user_version = 99");
  }
  EXPECT_EQ(
      Store(folder.path()).open().value_or(""),
      "the data folder '" + folder.path() + "' was made by a newer Espalier. Use that, or give --data another folder.");
  Database database;
  database.open(folder.path() + "/espalier.sqlite");
  Database::Statement tables(database, "SELECT count(*) FROM sqlite_master");
  ASSERT_TRUE(tables.next());
  EXPECT_EQ(tables.integer(0), 1);
}

}  // namespace
}  // namespace espalier::server
