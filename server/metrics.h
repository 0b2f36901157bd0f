#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace espalier::server {

/// A histogram of durations as Prometheus wants it. Thread-safe.
class DurationHistogram {
 public:
  /// Upper bounds of the buckets in seconds; one more has no bound.
  static constexpr std::array<double, 14> kBounds{0.0001, 0.00025, 0.0005, 0.001, 0.0025, 0.005, 0.01,
                                                  0.025,  0.05,    0.1,    0.25,  1.0,    5.0,   30.0};

  void observe(double seconds);
  /// The lines NAME_bucket, NAME_sum and NAME_count.
  void appendTo(std::string& text, const std::string& name) const;

 private:
  std::array<std::atomic<std::uint64_t>, kBounds.size() + 1> counts_{};
  std::atomic<std::uint64_t> nanoseconds_{0};
};

/// Counts since the server was started. Thread-safe.
struct Metrics {
  std::atomic<std::uint64_t> steps{0};
  std::atomic<std::uint64_t> failedSteps{0};
  std::atomic<std::uint64_t> modules{0};  // of the strings after each step, summed
  std::atomic<std::uint64_t> queries{0};
  std::atomic<std::uint64_t> requests{0};
  std::atomic<std::uint64_t> bytesReceived{0};
  std::atomic<std::uint64_t> bytesSent{0};
  std::atomic<std::uint64_t> sessions{0};  // of peers that said hello
  std::atomic<std::uint64_t> frames{0};    // of streams, sent
  std::atomic<std::uint64_t> drops{0};     // frames left out because a viewer, or the server, was slow
  DurationHistogram stepSeconds;
  DurationHistogram environmentSeconds;  // calls of environments in other processes
};

/// Values of one account at this moment.
struct AccountGauges {
  std::string owner;
  std::vector<std::pair<std::string, std::uint64_t>> bytes;  // by what they are for
  std::uint64_t simulations = 0;
  std::uint64_t streams = 0;
  std::uint64_t traceBytes = 0;
  double cpuSeconds = 0.0;
};

/// Values of this moment.
struct Gauges {
  std::uint64_t sessions = 0;
  std::uint64_t simulations = 0;
  std::uint64_t passiveSimulations = 0;
  std::uint64_t workers = 0;
  std::uint64_t residentBytes = 0;
  // memory and disk
  std::uint64_t stringBytes = 0;
  std::uint64_t streamBytes = 0;
  std::uint64_t outboxBytes = 0;
  std::uint64_t decodingBytes = 0;
  std::uint64_t storeBytes = 0;
  std::uint64_t traceBytes = 0;
  std::uint64_t databaseBytes = 0;
  std::vector<AccountGauges> accounts{};
};

/// The text that Prometheus reads.
[[nodiscard]] std::string prometheusText(const Metrics& metrics, const Gauges& gauges);

/// Resident memory of this process in bytes; 0 when the system does not say.
[[nodiscard]] std::uint64_t residentBytes();

}  // namespace espalier::server
