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

  enum class Access : std::uint8_t {
    Shared,    // several connections, on one machine
    Exclusive  // no other connection can open the file; works on file systems of networks too
  };
  /// Opens or makes the file with a write-ahead log.
  void open(const std::string& file, Access access = Access::Shared);
  /// Opens a file that is there, beside a server that may write it.
  void openToRead(const std::string& file);
  void execute(const char* sql);
  /// Of SQLite in this process. It takes no more than kMostMemoryBytes: then a statement fails.
  [[nodiscard]] static std::uint64_t memoryBytes();
  /// A model's text of a whole message, in several copies.
  static constexpr std::int64_t kMostMemoryBytes = 512'000'000;
  void begin() { execute("BEGIN IMMEDIATE"); }
  /// Commits, or rolls back after a failure. True: it was committed.
  bool commit();

  [[nodiscard]] const std::optional<std::string>& problem() const { return problem_; }
  /// Whether the problem is the file: it is damaged, or no database at all.
  [[nodiscard]] bool isFileDamaged() const { return problem_ && isFileDamaged_; }
  void clearProblem() { problem_.reset(); }

  /// A prepared statement; its parameters are numbered from 1, its columns from 0.
  class Statement {
   public:
    Statement(Database& database, const char* sql);
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& bind(int index, std::int64_t value);
    Statement& bind(int index, double value);
    Statement& bind(int index, std::string_view text);
    Statement& bindNull(int index);
    /// The bytes must live until the statement is run.
    Statement& bindBytes(int index, std::string_view bytes);
    /// Whether there is a row.
    bool next();
    /// Runs it to its end.
    void run();
    /// Makes it ready for other values.
    void reset();
    [[nodiscard]] std::int64_t integer(int column) const;
    [[nodiscard]] double real(int column) const;
    [[nodiscard]] bool isNull(int column) const;
    [[nodiscard]] std::string_view text(int column) const;
    [[nodiscard]] std::string_view bytes(int column) const;

   private:
    Database* database_;
    sqlite3_stmt* statement_ = nullptr;
  };

 private:
  void fail();
  void openFile(const std::string& file, int flags, Access access);

  sqlite3* connection_ = nullptr;
  std::optional<std::string> problem_;
  bool isFileDamaged_ = false;  // of the problem
};

}  // namespace espalier::server
