#include "server/log.h"

#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_sinks.h>

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
    if (logger_.should_log(level)) {
      const std::string line = isJson_ ? logMembers(text, subject) : logText(text, subject);
      logger_.log(level, spdlog::string_view_t(line.data(), line.size()));
    }
  }

 private:
  const bool isJson_;
  spdlog::logger logger_;
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

std::string logText(std::string_view text, const LogSubject& subject) {
  std::string line;
  if (!subject.session.empty()) {
    line += "session " + std::string(subject.session);
  }
  if (!subject.token.empty()) {
    line += " (" + std::string(subject.token) + ")";
  }
  if (!subject.simulation.empty()) {
    line += (line.empty() ? "simulation " : ", simulation ") + std::string(subject.simulation);
  }
  line += line.empty() ? "" : ": ";
  // a peer's text may try to begin a line of its own
  for (const char c : text) {
    line += c == '\n' || c == '\r' ? ' ' : c;
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
