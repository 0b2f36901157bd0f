#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "engine/core/streams.h"

namespace espalier::server {

/// The warnings of a simulation's steps until the next answer takes them. The same one comes once, and of one
/// simulation the first 50 come: a model can make a different one in each step. Thread-safe.
class RunWarnings {
 public:
  /// Where the simulation sends its messages. What a model prints is dropped. Files of the gallery are named as within
  /// it.
  [[nodiscard]] static core::MessageSink sinkOf(const std::shared_ptr<RunWarnings>& warnings, std::string gallery);
  [[nodiscard]] std::vector<std::string> take();

 private:
  void add(std::string_view text);

  std::mutex mutex_;
  std::set<std::string, std::less<>> said_;
  std::vector<std::string> waiting_;
};

}  // namespace espalier::server
