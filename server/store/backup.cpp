#include "server/store/backup.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "server/remote/partial_file.h"
#include "server/store/database.h"
#include "server/store/folder_lock.h"
#include "server/store/schema.h"

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

/// Why a file that begins to be written cannot be, or nothing. It appears under its name only when it is whole.
std::optional<std::string> problemOfNewFile(const std::string& file) {
  std::error_code error;
  if (fs::exists(file, error)) {
    return "'" + file + "' is there already. Give another name, or move it away first.";
  }
  const fs::path parent = fs::absolute(file).parent_path();
  if (!fs::is_directory(parent, error)) {
    return "there is no folder '" + parent.string() + "'. Make it first, or give another name.";
  }
  return std::nullopt;
}

/// Copies a database as it is at one moment, in pages that are packed. SQLite reads beside a server that writes.
std::optional<std::string> copyDatabase(const std::string& from, const std::string& to) {
  PartialFile partial(to + ".partial");
  std::error_code ignored;
  fs::remove(partial.name(), ignored);
  // SQLite writes into an empty file: so nobody else can read it at any moment
  const int made = ::open(partial.name().c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (made < 0) {
    return "'" + partial.name() + "' cannot be written: " + std::generic_category().message(errno) + ".";
  }
  std::optional<std::string> problem;
  {
    Database database;
    database.openToRead(from);
    if (versionOf(database) > storeVersion()) {
      problem = "'" + from + "' was made by a newer Espalier. Use that.";
    } else if (!database.problem()) {
      Database::Statement copy(database, "VACUUM INTO ?");
      copy.bind(1, std::string_view(partial.name())).run();
    }
    if (!problem && database.problem()) {
      problem = "'" + from + "' cannot be copied to '" + to + "': " + *database.problem() +
                ". Check both places and the room on the disk.";
    }
  }
  if (!problem) {
    if (const int reason = ::fsync(made) != 0 ? errno : partial.complete(to)) {
      problem = "'" + to + "' cannot be written: " + std::generic_category().message(reason) + ".";
    }
  }
  ::close(made);
  return problem;
}

/// Whether a file is a whole database of ours: an error sentence, or nothing.
std::optional<std::string> problemOfCopy(const std::string& file) {
  Database database;
  database.openToRead(file);
  bool isWhole = false;
  {
    Database::Statement check(database, "PRAGMA integrity_check(1)");
    isWhole = check.next() && check.text(0) == "ok";
  }
  if (isWhole) {
    Database::Statement others(database, "SELECT name FROM sqlite_master WHERE type NOT IN ('table', 'index')");
    if (others.next()) {
      return "'" + file + "' has triggers or views, which no backup has ('" + std::string(others.text(0)) +
             "'). Give a file that `espalier backup` made.";
    }
  }
  const std::int64_t version = database.problem() || !isWhole ? 0 : versionOf(database);
  if (version > storeVersion()) {
    return "'" + file + "' was made by a newer Espalier. Use that.";
  }
  if (version < 1) {
    return "'" + file + "' is no backup of a data folder, or it is damaged" +
           (database.problem() ? " (" + *database.problem() + ")" : std::string()) +
           ". Give a file that `espalier backup` made.";
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::string> backUpStore(const std::string& folder, const std::string& file) {
  const std::string database = (fs::path(folder) / kStoreFile).string();
  std::error_code error;
  if (!fs::is_regular_file(database, error)) {
    return "'" + folder + "' is no data folder: it has no file " + kStoreFile + ". Give the folder of --data.";
  }
  if (auto problem = problemOfNewFile(file)) {
    return problem;
  }
  return copyDatabase(database, file);
}

std::optional<std::string> restoreStore(const std::string& file, const std::string& folder) {
  std::error_code error;
  if (!fs::is_regular_file(file, error)) {
    return "there is no file '" + file + "'. Give a file that `espalier backup` made.";
  }
  if (auto problem = problemOfCopy(file)) {
    return problem;
  }
  auto locked = lockFolder(folder);
  if (!locked) {
    return std::move(locked.error());
  }
  for (const char* suffix : {"", "-wal"}) {
    const std::string old = (fs::path(folder) / (std::string(kStoreFile) + suffix)).string();
    if (fs::exists(old, error)) {
      return "the data folder '" + folder + "' holds a database already (" + old +
             "). Give an empty folder, or move the database and its -wal away first.";
    }
  }
  return copyDatabase(file, (fs::path(folder) / kStoreFile).string());
}

}  // namespace espalier::server
