#include "server/store/database.h"

#include <sqlite3.h>

#include <algorithm>

namespace espalier::server {

namespace {

/// Beyond it SQLite forgets pages that it can read again.
constexpr std::int64_t kPlentyBytes = 32'000'000;

}  // namespace

std::uint64_t Database::memoryBytes() {
  return static_cast<std::uint64_t>(std::max<sqlite3_int64>(sqlite3_memory_used(), 0));
}

Database::~Database() {
  sqlite3_close(connection_);
}

void Database::fail() {
  if (!problem_) {
    problem_ = connection_ == nullptr ? "there is not enough memory" : sqlite3_errmsg(connection_);
    const int code = connection_ == nullptr ? SQLITE_NOMEM : sqlite3_errcode(connection_);
    isFileDamaged_ = code == SQLITE_CORRUPT || code == SQLITE_NOTADB;
  }
}

void Database::openFile(const std::string& file, int flags, Access access) {
  // for the whole process, and the same each time
  sqlite3_soft_heap_limit64(kPlentyBytes);
  sqlite3_hard_heap_limit64(kMostMemoryBytes);
  if (sqlite3_open_v2(file.c_str(), &connection_, flags | SQLITE_OPEN_NOMUTEX, nullptr) != SQLITE_OK) {
    fail();
    return;
  }
  // a file of a stranger may hold programs of its own
  sqlite3_db_config(connection_, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(connection_, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_db_config(connection_, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  if (access == Access::Exclusive) {
    execute("PRAGMA locking_mode = EXCLUSIVE");
    return;
  }
  // another process may hold the file for a moment: a backup begins while the server writes, or the other way round
  constexpr int kPatienceMilliseconds = 10'000;
  sqlite3_busy_timeout(connection_, kPatienceMilliseconds);
}

void Database::openToRead(const std::string& file) {
  // reading a write-ahead log needs its index, which a reader may have to make
  openFile(file, SQLITE_OPEN_READWRITE, Access::Shared);
}

void Database::open(const std::string& file, Access access) {
  openFile(file, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, access);
  execute("PRAGMA journal_mode = WAL");
  // the log is forced to disk when it is moved into the database, so that a power failure costs moments, never the file
  execute("PRAGMA synchronous = NORMAL");
  // after a big state the log gives its space back
  execute("PRAGMA journal_size_limit = 67108864");
}

void Database::execute(const char* sql) {
  if (!problem_ && sqlite3_exec(connection_, sql, nullptr, nullptr, nullptr) != SQLITE_OK) {
    fail();
  }
}

bool Database::commit() {
  execute("COMMIT");
  if (!problem_) {
    return true;
  }
  // some failures have rolled back already
  if (connection_ != nullptr && sqlite3_get_autocommit(connection_) == 0) {
    sqlite3_exec(connection_, "ROLLBACK", nullptr, nullptr, nullptr);
  }
  return false;
}

Database::Statement::Statement(Database& database, const char* sql) : database_(&database) {
  if (!database.problem_ && sqlite3_prepare_v2(database.connection_, sql, -1, &statement_, nullptr) != SQLITE_OK) {
    database.fail();
  }
}

Database::Statement::~Statement() {
  sqlite3_finalize(statement_);
}

Database::Statement& Database::Statement::bind(int index, std::int64_t value) {
  sqlite3_bind_int64(statement_, index, value);
  return *this;
}

Database::Statement& Database::Statement::bind(int index, double value) {
  sqlite3_bind_double(statement_, index, value);
  return *this;
}

Database::Statement& Database::Statement::bindNull(int index) {
  sqlite3_bind_null(statement_, index);
  return *this;
}

Database::Statement& Database::Statement::bind(int index, std::string_view text) {
  sqlite3_bind_text64(statement_, index, text.data(), text.size(), SQLITE_TRANSIENT, SQLITE_UTF8);
  return *this;
}

Database::Statement& Database::Statement::bindBytes(int index, std::string_view bytes) {
  sqlite3_bind_blob64(statement_, index, bytes.data(), bytes.size(), SQLITE_STATIC);
  return *this;
}

bool Database::Statement::next() {
  if (database_->problem_) {
    return false;
  }
  const int outcome = sqlite3_step(statement_);
  if (outcome != SQLITE_ROW && outcome != SQLITE_DONE) {
    database_->fail();
  }
  return outcome == SQLITE_ROW;
}

void Database::Statement::run() {
  while (next()) {
  }
}

void Database::Statement::reset() {
  sqlite3_reset(statement_);
}

std::int64_t Database::Statement::integer(int column) const {
  return sqlite3_column_int64(statement_, column);
}

double Database::Statement::real(int column) const {
  return sqlite3_column_double(statement_, column);
}

bool Database::Statement::isNull(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

std::string_view Database::Statement::text(int column) const {
  const auto* begin = sqlite3_column_text(statement_, column);
  return {reinterpret_cast<const char*>(begin), static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

std::string_view Database::Statement::bytes(int column) const {
  const auto* begin = static_cast<const char*>(sqlite3_column_blob(statement_, column));
  return {begin, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))};
}

}  // namespace espalier::server
