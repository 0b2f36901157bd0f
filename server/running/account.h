#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/errors.h"
#include "server/remote/disk_room.h"

namespace espalier::server {

struct ServerLimits;

/// The purpose of memory that is taken.
enum class MemoryKind : std::uint8_t { Strings, Environments, Frames, Decoding, Compiling, Database };

inline constexpr std::size_t kMemoryKindCount = 6;
/// Their names on the wire and in the metrics: stringBytes, environmentBytes, ...
inline constexpr std::array<std::string_view, kMemoryKindCount> kMemoryKindNames{
    "stringBytes", "environmentBytes", "frameBytes", "decodingBytes", "compilingBytes", "databaseBytes"};

/// The amounts that one owner takes from the server, and at most may take. The account of the server is the parent of
/// all others: the amounts of an owner count there too. Thread-safe.
class Account {
 public:
  struct Bounds {
    std::uint64_t memoryBytes = UINT64_MAX;
    std::uint64_t simulations = UINT64_MAX;
    std::uint64_t streams = UINT64_MAX;
    std::uint64_t cpuSeconds = UINT64_MAX;
    std::uint64_t traceBytes = UINT64_MAX;
  };

  Account(std::string owner, const Bounds& bounds, Account* parent);
  Account(const Account&) = delete;
  Account& operator=(const Account&) = delete;

  [[nodiscard]] const std::string& owner() const { return owner_; }
  [[nodiscard]] Bounds bounds() const {
    return {boundBytes_, boundSimulations_, boundStreams_, boundCpuSeconds_, traceRoom_.bound()};
  }
  /// Others from now on. Amounts of the owner beyond them stay.
  void setBounds(const Bounds& bounds);

  /// Takes memory when the owner and the server may have it. False: nothing was taken.
  [[nodiscard]] bool take(MemoryKind kind, std::uint64_t bytes);
  /// Takes or gives back memory that is there, without asking.
  void add(MemoryKind kind, std::int64_t bytes);
  [[nodiscard]] std::uint64_t bytes(MemoryKind kind) const;
  [[nodiscard]] std::uint64_t memoryBytes() const { return memoryBytes_; }
  /// The error of memory that the owner, or the server, may not have.
  [[nodiscard]] protocol::Error memoryError() const;

  void addSimulations(std::int64_t count);
  void addStreams(std::int64_t count);
  void spend(std::uint64_t nanoseconds);
  /// Counts one more download that is being made, unless there are `most`. False: not counted.
  [[nodiscard]] bool beginDownload(std::uint64_t most);
  void endDownload() { --downloads_; }
  [[nodiscard]] std::uint64_t simulations() const { return simulations_; }
  [[nodiscard]] std::uint64_t streams() const { return streams_; }
  [[nodiscard]] double cpuSeconds() const { return static_cast<double>(nanoseconds_.load()) * 1e-9; }
  /// Of its traces in the data folder.
  [[nodiscard]] DiskRoom& traceRoom() { return traceRoom_; }
  [[nodiscard]] const DiskRoom& traceRoom() const { return traceRoom_; }
  /// Why the owner may not compute any more, or nothing.
  [[nodiscard]] std::optional<protocol::Error> cpuProblem() const;

 private:
  [[nodiscard]] bool isFull(std::uint64_t bytes) const { return bytes > boundBytes_; }

  const std::string owner_;
  Account* const parent_;  // null: this is the server's
  DiskRoom traceRoom_;
  // Bounds
  std::atomic<std::uint64_t> boundBytes_{UINT64_MAX};
  std::atomic<std::uint64_t> boundSimulations_{UINT64_MAX};
  std::atomic<std::uint64_t> boundStreams_{UINT64_MAX};
  std::atomic<std::uint64_t> boundCpuSeconds_{UINT64_MAX};
  std::atomic<std::uint64_t> memoryBytes_{0};
  std::array<std::atomic<std::int64_t>, kMemoryKindCount> bytes_{};
  std::atomic<std::uint64_t> simulations_{0};
  std::atomic<std::uint64_t> streams_{0};
  std::atomic<std::uint64_t> downloads_{0};
  std::atomic<std::uint64_t> nanoseconds_{0};
};

/// The account of the server and those of all owners. An owner's account lives as long as the server. Thread-safe.
class Accounts {
 public:
  explicit Accounts(const ServerLimits& limits);

  /// Other bounds from now on.
  void setLimits(const ServerLimits& limits);
  [[nodiscard]] Account& server() { return server_; }
  [[nodiscard]] const Account& server() const { return server_; }
  /// The account of the token with that name. Empty: the account `local` of all peers of a server without tokens.
  [[nodiscard]] Account& of(const std::string& token);
  [[nodiscard]] std::vector<const Account*> all() const;

 private:
  Account server_;
  mutable std::mutex mutex_;
  Account::Bounds ownerBounds_;
  std::map<std::string, std::unique_ptr<Account>> owners_;
};

/// Memory of an account that something holds for long. The destructor gives it back. For one thread at a time.
class Holding {
 public:
  Holding(Account& account, MemoryKind kind) : account_(&account), kind_(kind) {}
  ~Holding() { set(0); }
  Holding(const Holding&) = delete;
  Holding& operator=(const Holding&) = delete;

  /// It holds so many bytes now.
  void set(std::uint64_t bytes) {
    account_->add(kind_, static_cast<std::int64_t>(bytes) - static_cast<std::int64_t>(bytes_));
    bytes_ = bytes;
  }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  Account* account_;
  MemoryKind kind_;
  std::uint64_t bytes_ = 0;
};

}  // namespace espalier::server
