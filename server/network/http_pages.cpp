#include "server/network/http_pages.h"

#include <algorithm>
#include <boost/beast/http/rfc7230.hpp>

#include "protocol/json_writer.h"
#include "protocol/version.h"
#include "server/server_core.h"

namespace espalier::server {
namespace {

namespace http = boost::beast::http;

HttpPage healthPage(const ServerCore& core) {
  protocol::JsonWriter json;
  json.beginObject().key("status").text(core.isShuttingDown() ? "stopping" : "ok");
  json.key("server").text("espalier " + std::string(protocol::kProgramVersion));
  json.key("sessions").integer(core.sessionCount.load());
  json.key("simulations").integer(std::uint64_t{core.all().size()}).endObject();
  return {core.isShuttingDown() ? 503U : 200U, "application/json", json.take() + "\n"};
}

HttpPage metricsPage(const ServerCore& core) {
  const auto runners = core.all();
  Gauges gauges{.sessions = core.sessionCount,
                .simulations = runners.size(),
                .workers = core.pool().workers(),
                .residentBytes = residentBytes(),
                .outboxBytes = core.outboxBytes(),
                .decodingBytes = core.decodingBytes,
                .storeBytes = core.store().bytes(),
                .traceBytes = core.accounts().server().traceRoom().used()};
  gauges.databaseBytes = core.accounts().server().bytes(MemoryKind::Database);
  gauges.stringBytes = core.accounts().server().bytes(MemoryKind::Strings);
  for (const auto& runner : runners) {
    gauges.streamBytes += runner->streamBytes();
    gauges.passiveSimulations += runner->isPassive() ? 1U : 0U;
  }
  for (const Account* account : core.accounts().all()) {
    AccountGauges values{.owner = account->owner(),
                         .bytes = {},
                         .simulations = account->simulations(),
                         .streams = account->streams(),
                         .traceBytes = account->traceRoom().used(),
                         .cpuSeconds = account->cpuSeconds()};
    for (std::size_t kind = 0; kind < kMemoryKindCount; ++kind) {
      std::string name(kMemoryKindNames[kind]);
      name.resize(name.size() - std::string_view("Bytes").size());
      values.bytes.emplace_back(std::move(name), account->bytes(static_cast<MemoryKind>(kind)));
    }
    gauges.accounts.push_back(std::move(values));
  }
  return {200, "text/plain; version=0.0.4; charset=utf-8", prometheusText(core.metrics, gauges)};
}

}  // namespace

bool acceptsGzip(std::string_view encodings) {
  for (const auto& [name, parameters] : http::ext_list(encodings)) {
    if (boost::beast::iequals(name, "gzip")) {
      // a weight of 0 refuses it
      return std::ranges::none_of(parameters, [](const auto& parameter) {
        return parameter.first == "q" && parameter.second.find_first_not_of("0.") == std::string_view::npos;
      });
    }
  }
  return false;
}

bool hasFile(std::string_view tags, std::string_view tag) {
  return !tag.empty() && tags.find(tag) != std::string_view::npos;
}

HttpPage pageOf(std::string_view target, const ServerCore& core) {
  const std::string_view path = target.substr(0, target.find('?'));
  for (const WebFile& file : core.options().pages) {
    if (path == file.path) {
      HttpPage page{200, file.type, {}, {}, file.policy};
      page.file = &file;
      return page;
    }
  }
  if (path == "/health") {
    return healthPage(core);
  }
  if (path == "/metrics") {
    return metricsPage(core);
  }
  if (path == "/espalier/1") {
    return {426, "text/plain; charset=utf-8", "WebSockets are opened here: ask for an upgrade.\n"};
  }
  return {404, "text/plain; charset=utf-8",
          "There is no such page. There are /health, /metrics, /simulations and /espalier/1.\n"};
}

bool isHostAllowed(std::string_view host, bool isLoopback) {
  if (!isLoopback || host.empty()) {
    return true;
  }
  // without the port
  const std::size_t bracket = host.find(']');
  const std::string_view name =
      bracket != std::string_view::npos ? host.substr(0, bracket + 1) : host.substr(0, host.find(':'));
  const bool isNumeric = name.find_first_not_of("0123456789.") == std::string_view::npos;
  return name == "localhost" || name == "[::1]" || (isNumeric && name.starts_with("127."));
}

bool isOriginAllowed(std::string_view origin, std::string_view host, bool isLoopback,
                     const std::vector<std::string>& allowed) {
  if (origin.empty() || std::find(allowed.begin(), allowed.end(), origin) != allowed.end()) {
    return true;
  }
  const std::size_t colon = origin.find("://");
  return colon != std::string_view::npos && !host.empty() && origin.substr(colon + 3) == host &&
         isHostAllowed(host, isLoopback);
}

}  // namespace espalier::server
