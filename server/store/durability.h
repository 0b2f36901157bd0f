#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>

namespace espalier::server {

/// The failure that a saved state survives.
enum class Durability : std::uint8_t {
  Process,  // the end of the server's process, however it ends
  Power,    // also a power failure or a crash of the system: the disk is asked to keep it before the answer
};

/// `process` or `power`, as options and the wire name them.
[[nodiscard]] std::string_view nameOf(Durability durability);
[[nodiscard]] std::optional<Durability> durabilityOf(std::string_view name);

/// Forces committed transactions to the disk, together: all that were committed before the disk was asked share one
/// request. Thread-safe.
class GroupCommit {
 public:
  /// `force` forces everything that was written so far to the disk, and returns 0 or an errno.
  explicit GroupCommit(std::function<int()> force) : force_(std::move(force)) {}

  /// To be called after each commit, in the order of commits. Returns its number.
  [[nodiscard]] std::uint64_t committed() { return ++committed_; }
  /// Waits until the disk has the commit of that number. An errno when it does not, now and from then on: what a disk
  /// has dropped once cannot be made safe by asking again.
  [[nodiscard]] int waitFor(std::uint64_t number);
  /// How often the disk was asked.
  [[nodiscard]] std::uint64_t requestCount() const { return requestCount_; }

 private:
  const std::function<int()> force_;
  std::atomic<std::uint64_t> committed_{0};
  std::atomic<std::uint64_t> requestCount_{0};
  std::mutex mutex_;
  std::condition_variable done_;
  std::uint64_t safe_ = 0;  // commits that the disk has
  bool isForcing_ = false;  // a thread asks the disk for all
  int failure_ = 0;
};

}  // namespace espalier::server
