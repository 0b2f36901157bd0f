#include "server/store/schema.h"

#include <array>

namespace espalier::server {
namespace {

constexpr std::array kChanges{
    // version 1
    R"(
CREATE TABLE IF NOT EXISTS simulations(id TEXT PRIMARY KEY, record TEXT NOT NULL, step INTEGER NOT NULL,
                                       state INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS checkpoints(simulation TEXT, name TEXT, step INTEGER NOT NULL, state INTEGER NOT NULL,
                                       bytes INTEGER NOT NULL, PRIMARY KEY(simulation, name)) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS models(id TEXT PRIMARY KEY, text TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS parts(id INTEGER PRIMARY KEY, bytes BLOB NOT NULL);
)",
    // version 2: the account that a simulation counts for
    R"(
ALTER TABLE simulations ADD COLUMN owner TEXT NOT NULL DEFAULT '';
)",
};

}  // namespace

std::span<const char* const> storeChanges() {
  return kChanges;
}

std::int64_t storeVersion() {
  return static_cast<std::int64_t>(kChanges.size());
}

std::int64_t versionOf(Database& database) {
  Database::Statement statement(database, "PRAGMA user_version");
  return statement.next() ? statement.integer(0) : 0;
}

bool isOfAnotherProgram(Database& database) {
  if (versionOf(database) > 0) {
    return false;
  }
  Database::Statement statement(database,
                                "SELECT count(*), sum(name = 'simulations') FROM sqlite_master WHERE type = 'table'");
  return statement.next() && statement.integer(0) > 0 && statement.integer(1) == 0;
}

bool migrate(Database& database, std::span<const char* const> changes) {
  const std::int64_t version = versionOf(database);
  const auto newest = static_cast<std::int64_t>(changes.size());
  if (version > newest) {
    return false;
  }
  if (version < newest) {
    database.begin();
    for (const char* change : changes.subspan(static_cast<std::size_t>(version))) {
      database.execute(change);
    }
    database.execute(("PRAGMA user_version = " + std::to_string(newest)).c_str());
    (void)database.commit();
  }
  return true;
}

}  // namespace espalier::server
