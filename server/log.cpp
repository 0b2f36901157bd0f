#include "server/log.h"

#include <poll.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <unistd.h>

#include <climits>
#include <cstdint>
#include <mutex>

#include "protocol/json_text.h"
#include "protocol/json_writer.h"

namespace espalier::server {

class Log::Implementation {
 public:
  Implementation(const std::string& level, bool isJson)
      : isJson_(isJson), logger_("espalier", std::make_shared<spdlog::sinks::stderr_sink_mt>()) {
    const auto known = spdlog::level::from_str(level);
    logger_.set_level(known == spdlog::level::off && level != "off" ? spdlog::level::info : known);
    logger_.set_pattern(isJson ? R"({"time":"%Y-%m-%dT%H:%M:%S.%e","level":"%l",%v})" : "%Y-%m-%dT%H:%M:%S.%e %l %v");
    logger_.flush_on(spdlog::level::trace);
  }
  void write(spdlog::level::level_enum level, std::string_view text, const LogSubject& subject) {
    if (!logger_.should_log(level)) {
      return;
    }
    const std::lock_guard lock(mutex_);
    if (!hasRoom()) {
      ++missedCount_;
      return;
    }
    if (missedCount_ > 0) {
      put(spdlog::level::warn, std::to_string(missedCount_) + " lines are missing here: nobody read the log", {});
      missedCount_ = 0;
      if (!hasRoom()) {
        ++missedCount_;
        return;
      }
    }
    put(level, text, subject);
  }

 private:
  /// A pipe whose reader has stopped would keep every thread waiting that has something to say.
  static bool hasRoom() {
    ::pollfd output{STDERR_FILENO, POLLOUT, 0};
    return ::poll(&output, 1, 0) != 0;
  }
  std::string lineOf(std::string_view text, const LogSubject& subject) const {
    return isJson_ ? logMembers(text, subject) : logText(text, subject);
  }
  void put(spdlog::level::level_enum level, std::string_view text, const LogSubject& subject) {
    // a pipe that has room has some for so many bytes
    constexpr std::size_t kMostBytes = PIPE_BUF - 500;
    const auto lineOfBeginning = [&](std::size_t mostBytes) {
      const std::string_view beginning = protocol::beginningOf(text, mostBytes);
      return beginning.size() < text.size() ? lineOf(std::string(beginning) + "…", subject) : lineOf(text, subject);
    };
    std::string line = lineOfBeginning(kMostBytes);
    if (line.size() > PIPE_BUF - 100) {
      // JSON makes six characters of some
      line = lineOfBeginning(kMostBytes / 6);
    }
    logger_.log(level, spdlog::string_view_t(line.data(), line.size()));
  }

  const bool isJson_;
  spdlog::logger logger_;
  std::mutex mutex_;
  std::uint64_t missedCount_ = 0;  // lines for which there was no room
};

Log::Log(const std::string& level, const std::string& format)
    : implementation_(std::make_unique<Implementation>(level, format == "json")) {}
Log::~Log() = default;

void Log::debug(std::string_view text, const LogSubject& subject) const {
  implementation_->write(spdlog::level::debug, text, subject);
}

void Log::info(std::string_view text, const LogSubject& subject) const {
  implementation_->write(spdlog::level::info, text, subject);
}

void Log::warn(std::string_view text, const LogSubject& subject) const {
  implementation_->write(spdlog::level::warn, text, subject);
}

void Log::error(std::string_view text, const LogSubject& subject) const {
  implementation_->write(spdlog::level::err, text, subject);
}

namespace {

/// Whether a character of UTF-8 that begins at `at` ends a line or moves the cursor of a terminal, with its length.
std::pair<bool, std::size_t> controlAt(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(at);
  if (first < 0x20U || first == 0x7fU) {
    return {true, 1};
  }
  if (first == 0xc2U && byte(at + 1) >= 0x80U && byte(at + 1) < 0xa0U) {
    return {true, 2};  // U+0080 to U+009F
  }
  if (first == 0xe2U && byte(at + 1) == 0x80U && (byte(at + 2) == 0xa8U || byte(at + 2) == 0xa9U)) {
    return {true, 3};  // the separators of lines and paragraphs
  }
  return {false, 1};
}

}  // namespace

std::string logText(std::string_view text, const LogSubject& subject) {
  constexpr std::size_t kMostNameBytes = 64;
  std::string said;
  if (!subject.session.empty()) {
    said += "session " + std::string(subject.session);
  }
  if (!subject.token.empty()) {
    said += " (" + std::string(subject.token) + ")";
  }
  if (!subject.simulation.empty()) {
    said +=
        (said.empty() ? "simulation " : ", simulation ") + std::string(subject.simulation.substr(0, kMostNameBytes));
  }
  said += said.empty() ? "" : ": ";
  said += text;
  // a peer's text, and a name that it asks for, may try to begin a line of its own
  std::string line;
  for (std::size_t at = 0; at < said.size();) {
    const auto [isControl, length] = controlAt(said, at);
    line += isControl ? std::string_view(" ") : std::string_view(said).substr(at, length);
    at += length;
  }
  return line;
}

std::string logMembers(std::string_view text, const LogSubject& subject) {
  protocol::JsonWriter writer;
  writer.beginObject();
  if (!subject.session.empty()) {
    writer.key("session").text(subject.session);
  }
  if (!subject.token.empty()) {
    writer.key("token").text(subject.token);
  }
  if (!subject.simulation.empty()) {
    writer.key("simulation").text(subject.simulation);
  }
  const std::string object = writer.key("message").text(text).endObject().take();
  return object.substr(1, object.size() - 2);
}

}  // namespace espalier::server
