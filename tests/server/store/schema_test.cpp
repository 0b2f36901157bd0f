#include "server/store/schema.h"

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <vector>

#include "server/store/store.h"
#include "tests/server/server_fixture.h"
#include "tests/support/places.h"

namespace espalier::server::schema_test {
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

  /// Columns that version 2 adds.
  [[nodiscard]] std::int64_t ownerColumns() const {
    Database database;
    database.open(file());
    Database::Statement columns(database, "SELECT count(*) FROM pragma_table_info('simulations') WHERE name = 'owner'");
    return columns.next() ? columns.integer(0) : -1;
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

void killThisProcess(sqlite3_context*, int, sqlite3_value**) {
  (void)::kill(::getpid(), SIGKILL);
}

int dieAtCommit(void*) {
  (void)::kill(::getpid(), SIGKILL);
  return 0;
}

/// Gives every connection of this process the SQL function die().
int addDeath(sqlite3* connection, const char**, const sqlite3_api_routines*) {
  return sqlite3_create_function(connection, "die", 0, SQLITE_UTF8, nullptr, &killThisProcess, nullptr, nullptr);
}

/// The same, and lets the next change that is committed end the process.
int addDeathAtCommit(sqlite3* connection, const char**, const sqlite3_api_routines*) {
  (void)sqlite3_commit_hook(connection, &dieAtCommit, nullptr);
  return SQLITE_OK;
}

using Extension = int (*)(sqlite3*, const char**, const sqlite3_api_routines*);

/// Migrates in a process that is killed by one of the changes, or by the extension.
void migrateAndDie(const std::string& file, const std::vector<const char*>& changes, Extension extension) {
  const pid_t child = ::fork();
  if (child == 0) {
    sqlite3_auto_extension(reinterpret_cast<void (*)()>(extension));
    Database database;
    database.open(file);
    (void)migrate(database, changes);
    ::_exit(1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
}

TEST_F(OldFolder, AProgramThatIsKilledWithinTheMigrationLeavesTheOldVersionWhole) {
  const auto released = storeChanges();
  // killed before the first change from version 1 on, between any two, and after the last
  for (std::size_t at = 1; at <= released.size(); ++at) {
    std::vector<const char*> changes(released.begin(), released.end());
    changes.insert(changes.begin() + static_cast<std::ptrdiff_t>(at), "SELECT die()");
    migrateAndDie(file(), changes, &addDeath);
    EXPECT_EQ(version(), 1) << at;
    EXPECT_EQ(ownerColumns(), 0) << at;
  }
  migrateAndDie(file(), {released.begin(), released.end()}, &addDeathAtCommit);
  EXPECT_EQ(version(), 1);
  EXPECT_EQ(ownerColumns(), 0);
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
}  // namespace espalier::server::schema_test
