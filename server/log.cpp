#include "server/log.h"

#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_sinks.h>

namespace espalier::server {

class Log::Implementation {
 public:
  explicit Implementation(const std::string& level)
      : logger_("espalier", std::make_shared<spdlog::sinks::stderr_sink_mt>()) {
    const auto known = spdlog::level::from_str(level);
    logger_.set_level(known == spdlog::level::off && level != "off" ? spdlog::level::info : known);
    logger_.set_pattern("%Y-%m-%dT%H:%M:%S.%e %l %v");
    logger_.flush_on(spdlog::level::trace);
  }
  void write(spdlog::level::level_enum level, std::string_view text) {
    logger_.log(level, spdlog::string_view_t(text.data(), text.size()));
  }

 private:
  spdlog::logger logger_;
};

Log::Log(const std::string& level) : implementation_(std::make_unique<Implementation>(level)) {}
Log::~Log() = default;

void Log::debug(std::string_view text) const {
  implementation_->write(spdlog::level::debug, text);
}

void Log::info(std::string_view text) const {
  implementation_->write(spdlog::level::info, text);
}

void Log::warn(std::string_view text) const {
  implementation_->write(spdlog::level::warn, text);
}

void Log::error(std::string_view text) const {
  implementation_->write(spdlog::level::err, text);
}

}  // namespace espalier::server
