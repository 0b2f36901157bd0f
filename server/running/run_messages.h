#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "engine/core/streams.h"

namespace espalier::server {

/// What a simulation says in its steps until the next answer takes it: warnings, and what the model prints. The same
/// warning comes once, and of one simulation the first 50 come until it is reset: a model can make a different one in
/// each step.
/// Thread-safe.
class RunMessages {
 public:
  /// Of what is printed between two answers.
  static constexpr std::size_t kMostPrinted = 64'000;

  /// Where the simulation sends its messages. Files of the gallery are named as within it.
  [[nodiscard]] static core::MessageSink sinkOf(const std::shared_ptr<RunMessages>& messages, std::string gallery);
  [[nodiscard]] std::vector<std::string> takeWarnings();
  /// The simulation is reset: the same warnings may come again.
  void forgetWarnings();
  /// The beginning of what was printed, with a line that says how many bytes are missing.
  [[nodiscard]] std::string takePrinted();

 private:
  void warn(std::string_view text);
  void print(std::string_view text);

  std::mutex mutex_;
  std::set<std::string, std::less<>> said_;
  std::vector<std::string> waiting_;
  std::string printed_;
  std::uint64_t missingBytes_ = 0;  // that were printed behind printed_
};

}  // namespace espalier::server
