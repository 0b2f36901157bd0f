#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace espalier::server {

/// The server's log, on standard error. Thread-safe. The library behind it stays in log.cpp.
class Log {
 public:
  /// `level`: trace debug info warn error off; anything else is info.
  explicit Log(const std::string& level);
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void debug(std::string_view text) const;
  void info(std::string_view text) const;
  void warn(std::string_view text) const;
  void error(std::string_view text) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace espalier::server
