#include "server/metrics.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>

namespace espalier::server {
namespace {

std::string numberText(double value) {
  std::array<char, 32> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return {buffer.data(), result.ptr};
}

void appendFamily(std::string& text, const std::string& name, const char* kind, const char* help) {
  text += "# HELP " + name + " " + help + "\n# TYPE " + name + " " + kind + "\n";
}

void append(std::string& text, const std::string& name, const char* kind, const char* help, std::uint64_t value) {
  appendFamily(text, name, kind, help);
  text += name + " " + std::to_string(value) + "\n";
}

/// The value of a label.
std::string label(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    escaped += c == '\n' ? "\\n" : c == '"' || c == '\\' ? std::string{'\\', c} : std::string{c};
  }
  return '"' + escaped + '"';
}

void appendAccounts(std::string& text, const std::vector<AccountGauges>& accounts) {
  const auto family = [&](const std::string& name, const char* kind, const char* help, auto value) {
    appendFamily(text, name, kind, help);
    for (const AccountGauges& account : accounts) {
      text += name + "{account=" + label(account.owner) + "} " + value(account) + "\n";
    }
  };
  appendFamily(text, "espalier_account_bytes", "gauge", "Memory of an account, by what it is for.");
  for (const AccountGauges& account : accounts) {
    for (const auto& [kind, bytes] : account.bytes) {
      text += "espalier_account_bytes{account=" + label(account.owner) + ",kind=" + label(kind) + "} " +
              std::to_string(bytes) + "\n";
    }
  }
  family("espalier_account_simulations", "gauge", "Simulations of an account.",
         [](const AccountGauges& account) { return std::to_string(account.simulations); });
  family("espalier_account_streams", "gauge", "Streams of an account.",
         [](const AccountGauges& account) { return std::to_string(account.streams); });
  family("espalier_account_trace_bytes", "gauge", "Traces of an account in the data folder.",
         [](const AccountGauges& account) { return std::to_string(account.traceBytes); });
  family("espalier_account_cpu_seconds_total", "counter", "Processor time of an account.",
         [](const AccountGauges& account) { return numberText(account.cpuSeconds); });
}

}  // namespace

void DurationHistogram::observe(double seconds) {
  const auto bucket =
      static_cast<std::size_t>(std::lower_bound(kBounds.begin(), kBounds.end(), seconds) - kBounds.begin());
  counts_[bucket].fetch_add(1, std::memory_order_relaxed);
  nanoseconds_.fetch_add(static_cast<std::uint64_t>(std::max(seconds, 0.0) * 1e9), std::memory_order_relaxed);
}

void DurationHistogram::appendTo(std::string& text, const std::string& name) const {
  std::uint64_t count = 0;
  for (std::size_t bucket = 0; bucket < counts_.size(); ++bucket) {
    count += counts_[bucket].load(std::memory_order_relaxed);
    const std::string bound = bucket < kBounds.size() ? numberText(kBounds[bucket]) : "+Inf";
    text += name + "_bucket{le=\"" + bound + "\"} " + std::to_string(count) + "\n";
  }
  text += name + "_sum " + numberText(static_cast<double>(nanoseconds_.load(std::memory_order_relaxed)) / 1e9) + "\n";
  text += name + "_count " + std::to_string(count) + "\n";
}

std::string prometheusText(const Metrics& metrics, const Gauges& gauges) {
  std::string text;
  append(text, "espalier_steps_total", "counter", "Steps completed.", metrics.steps);
  append(text, "espalier_failed_steps_total", "counter", "Steps that failed.", metrics.failedSteps);
  append(text, "espalier_modules_total", "counter", "Modules of the strings after each step.", metrics.modules);
  append(text, "espalier_queries_total", "counter", "Queries put to environments.", metrics.queries);
  append(text, "espalier_requests_total", "counter", "Requests of sessions.", metrics.requests);
  append(text, "espalier_received_bytes_total", "counter", "Bytes from sessions.", metrics.bytesReceived);
  append(text, "espalier_sent_bytes_total", "counter", "Bytes to sessions.", metrics.bytesSent);
  append(text, "espalier_sessions_total", "counter", "Sessions opened.", metrics.sessions);
  append(text, "espalier_stream_frames_total", "counter", "Frames sent to viewers.", metrics.frames);
  append(text, "espalier_stream_drops_total", "counter",
         "Frames left out because a viewer, or the server, was slower than the steps.", metrics.drops);
  append(text, "espalier_sessions", "gauge", "Sessions open now.", gauges.sessions);
  append(text, "espalier_simulations", "gauge", "Simulations of the server.", gauges.simulations);
  append(text, "espalier_passive_simulations", "gauge", "Of them on disk only, to make room in memory.",
         gauges.passiveSimulations);
  append(text, "espalier_workers", "gauge", "Simulations that may compute at a time.", gauges.workers);
  append(text, "espalier_resident_bytes", "gauge", "Resident memory of the process.", gauges.residentBytes);
  append(text, "espalier_string_bytes", "gauge", "Strings of all simulations.", gauges.stringBytes);
  append(text, "espalier_stream_bytes", "gauge", "Kept to tell viewers differences.", gauges.streamBytes);
  append(text, "espalier_outbox_bytes", "gauge", "Waiting for peers to read them.", gauges.outboxBytes);
  append(text, "espalier_decoding_bytes", "gauge", "Received from peers, not decoded yet.", gauges.decodingBytes);
  append(text, "espalier_store_bytes", "gauge", "The data folder's database on disk.", gauges.storeBytes);
  append(text, "espalier_trace_bytes", "gauge", "Traces in the data folder.", gauges.traceBytes);
  append(text, "espalier_database_memory_bytes", "gauge", "Memory of SQLite.", gauges.databaseBytes);
  appendAccounts(text, gauges.accounts);
  appendFamily(text, "espalier_step_seconds", "histogram", "Wall time of a step, environment included.");
  metrics.stepSeconds.appendTo(text, "espalier_step_seconds");
  appendFamily(text, "espalier_environment_seconds", "histogram", "Calls of environments in other processes.");
  metrics.environmentSeconds.appendTo(text, "espalier_environment_seconds");
  return text;
}

std::uint64_t residentBytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t total = 0;
  std::uint64_t resident = 0;
  file >> total >> resident;
  return file ? resident * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) : 0;
}

}  // namespace espalier::server
