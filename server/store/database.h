#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace espalier::server {

/// One SQLite connection. Not thread-safe. The first failure is kept: ask problem() after a series of calls. Until
/// clearProblem() further calls do nothing.
class Database {
 public:
  Database() = default;
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  /// Opens or makes the file with a write-ahead log.
  void open(const std::string& file);
  /// Opens a file that is there, beside a server that may write it.
  void openToRead(const std::string& file);
  void execute(const char* sql);
  void begin() { execute("BEGIN IMMEDIATE"); }
  /// Commits, or rolls back after a failure. True: it was committed.
  bool commit();

  [[nodiscard]] const std::optional<std::string>& problem() const { return problem_; }
  void clearProblem() { problem_.reset(); }

  /// A prepared statement; its parameters are numbered from 1, its columns from 0.
  class Statement {
   public:
    Statement(Database& database, const char* sql);
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& bind(int index, std::int64_t value);
    Statement& bind(int index, std::string_view text);
    /// The bytes must live until the statement is run.
    Statement& bindBytes(int index, std::string_view bytes);
    /// Whether there is a row.
    bool next();
    /// Runs it to its end.
    void run();
    [[nodiscard]] std::int64_t integer(int column) const;
    [[nodiscard]] std::string_view text(int column) const;
    [[nodiscard]] std::string_view bytes(int column) const;

   private:
    Database* database_;
    sqlite3_stmt* statement_ = nullptr;
  };

 private:
  void fail();
  void openFile(const std::string& file, int flags);

  sqlite3* connection_ = nullptr;
  std::optional<std::string> problem_;
};

}  // namespace espalier::server
