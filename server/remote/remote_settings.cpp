#include "server/remote/remote_settings.h"

#include <charconv>
#include <vector>

#include "environment/registry.h"
#include "protocol/envelope.h"
#include "protocol/json_text.h"

namespace espalier::server {
namespace {

constexpr std::string_view kFallback = "fallback:";
// a day
constexpr std::int64_t kLongestMilliseconds = 86'400'000;

std::string sentences(const std::vector<core::Diagnostic>& diagnostics) {
  std::string text;
  for (const core::Diagnostic& diagnostic : diagnostics) {
    text += (text.empty() ? "" : "; ") + diagnostic.message;
    if (!diagnostic.hint.empty()) {
      text += ": " + diagnostic.hint;
    }
  }
  return text;
}

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> RemotePolicy::around(std::unique_ptr<turtle::EnvironmentProcess> process,
                                                                 FailureSink sink) {
  return isTolerant ? withFailurePolicy(std::move(process), std::move(fallback), std::move(sink)) : std::move(process);
}

tl::expected<RemotePolicy, std::string> readRemotePolicy(const std::string& words) {
  RemotePolicy policy;
  if (words == "fail") {
    return policy;
  }
  policy.isTolerant = true;
  if (words == "keep") {
    return policy;
  }
  if (!words.starts_with(kFallback)) {
    return tl::unexpected("expected fail, keep or fallback:NAME of a built-in, found \"" + words + "\"");
  }
  auto made = environment::makeProcess(words.substr(kFallback.size()), "");
  if (!made) {
    return tl::unexpected(sentences(made.error()));
  }
  policy.fallback = std::move(*made);
  return policy;
}

tl::expected<RemoteSettings, RemoteSettingProblem> readRemoteSettings(const std::string& entryJson,
                                                                      const std::string& policy) {
  RemoteSettings settings;
  auto read = readRemotePolicy(protocol::memberOf(entryJson, "policy").value_or(policy));
  if (!read) {
    return tl::unexpected(RemoteSettingProblem{"policy", std::move(read.error())});
  }
  settings.policy = std::move(*read);
  if (const auto text = protocol::memberOf(entryJson, "timeoutMilliseconds")) {
    std::int64_t milliseconds = 0;
    const auto [end, problem] = std::from_chars(text->data(), text->data() + text->size(), milliseconds);
    if (problem != std::errc() || end != text->data() + text->size() || milliseconds < 1 ||
        milliseconds > kLongestMilliseconds) {
      return tl::unexpected(
          RemoteSettingProblem{"timeoutMilliseconds", "expected a whole number of milliseconds from 1 to " +
                                                          std::to_string(kLongestMilliseconds) + ", found " + *text});
    }
    settings.stepTimeout = std::chrono::milliseconds(milliseconds);
  }
  settings.configurationJson = protocol::memberOf(entryJson, "configuration").value_or("");
  return settings;
}

}  // namespace espalier::server
