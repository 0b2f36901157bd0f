#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace espalier::server {

/// The session and the simulation that a line of the log is about, and the name of the session's token. Empty: none.
struct LogSubject {
  std::string_view session{};
  std::string_view simulation{};
  std::string_view token{};
};

/// The server's log, on standard error. Thread-safe. The library behind it stays in log.cpp.
///   text: 2026-05-01T12:00:00.000 info session 3 (alice), simulation sim-5d03a1c7e2b4: created
///   json: {"time":"2026-05-01T12:00:00.000","level":"info","session":"3","token":"alice","simulation":"sim-…",
///          "message":"created"}
class Log {
 public:
  /// `level`: trace debug info warn error off; anything else is info. `format`: json, anything else is text.
  Log(const std::string& level, const std::string& format);
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void debug(std::string_view text, const LogSubject& subject = {}) const;
  void info(std::string_view text, const LogSubject& subject = {}) const;
  void warn(std::string_view text, const LogSubject& subject = {}) const;
  void error(std::string_view text, const LogSubject& subject = {}) const;

 private:
  class Implementation;
  std::unique_ptr<Implementation> implementation_;
};

/// The part of a line after time and level: the text after its subject, or the members of the JSON object after them.
[[nodiscard]] std::string logText(std::string_view text, const LogSubject& subject);
[[nodiscard]] std::string logMembers(std::string_view text, const LogSubject& subject);

}  // namespace espalier::server
