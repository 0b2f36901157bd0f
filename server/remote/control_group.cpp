#include "server/remote/control_group.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>
#include <thread>
#include <vector>

namespace espalier::server {
namespace {

namespace fs = std::filesystem;

/// The words of the first line of a file; none when it cannot be read.
std::vector<std::string> wordsOfFile(const fs::path& file) {
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  std::istringstream words(line);
  std::vector<std::string> all;
  for (std::string word; words >> word;) {
    all.push_back(word);
  }
  return all;
}

std::optional<std::int64_t> numberIn(std::string_view word) {
  std::int64_t number = 0;
  const auto [end, problem] = std::from_chars(word.data(), word.data() + word.size(), number);
  const bool isNumber = problem == std::errc() && end == word.data() + word.size();
  return isNumber ? std::optional(number) : std::nullopt;
}

/// The group of this process below a controller's root, with all groups above it: each of them has a bound.
std::vector<fs::path> groupsOf(const fs::path& root, const std::string& controller) {
  std::ifstream stream("/proc/self/cgroup");
  std::string group = "/";
  for (std::string line; std::getline(stream, line);) {
    // HIERARCHY:CONTROLLERS:GROUP, with no controllers in version 2
    const std::size_t first = line.find(':');
    const std::size_t second = line.find(':', first + 1);
    if (second == std::string::npos) {
      continue;
    }
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",";
    if (controller.empty() ? controllers == ",," : controllers.find("," + controller + ",") != std::string::npos) {
      group = line.substr(second + 1);
    }
  }
  std::vector<fs::path> groups{root};
  fs::path below = root;
  for (const fs::path& part : fs::path(group).relative_path()) {
    below /= part;
    groups.push_back(below);
  }
  return groups;
}

template <typename Value>
void lower(std::optional<Value>& bound, Value value) {
  bound = bound ? std::min(*bound, value) : value;
}

}  // namespace

std::optional<std::uint64_t> controlGroupMemoryBytes(const std::string& root) {
  std::optional<std::uint64_t> bound;
  const auto look = [&bound](const fs::path& file) {
    const auto words = wordsOfFile(file);
    if (const auto number = words.empty() ? std::nullopt : numberIn(words.front()); number && *number > 0) {
      lower(bound, static_cast<std::uint64_t>(*number));
    }
  };
  for (const fs::path& group : groupsOf(root, "")) {
    look(group / "memory.max");
    // beyond it the system slows the process down and takes its pages
    look(group / "memory.high");
  }
  for (const fs::path& group : groupsOf(fs::path(root) / "memory", "memory")) {
    look(group / "memory.limit_in_bytes");
  }
  return bound;
}

std::optional<std::uint64_t> processMemoryBytes() {
  std::optional<std::uint64_t> bound;
  for (const auto resource : {RLIMIT_AS, RLIMIT_DATA}) {
    ::rlimit limit{};
    if (::getrlimit(resource, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
      lower(bound, std::uint64_t{limit.rlim_cur});
    }
  }
  return bound;
}

std::uint64_t usableMemoryBytes() {
  const auto pages = static_cast<std::uint64_t>(std::max(::sysconf(_SC_PHYS_PAGES), 1L));
  const auto pageBytes = static_cast<std::uint64_t>(std::max(::sysconf(_SC_PAGESIZE), 1L));
  const std::uint64_t bytes = std::min(
      {pages * pageBytes, controlGroupMemoryBytes().value_or(UINT64_MAX), processMemoryBytes().value_or(UINT64_MAX)});
  return bytes / 5 * 4;
}

unsigned processorCount(const std::string& root) {
  std::optional<double> quota;
  for (const fs::path& group : groupsOf(root, "")) {
    // QUOTA PERIOD in microseconds, or "max PERIOD"
    const auto words = wordsOfFile(group / "cpu.max");
    const auto most = words.size() == 2 ? numberIn(words[0]) : std::nullopt;
    const auto period = words.size() == 2 ? numberIn(words[1]) : std::nullopt;
    if (most && period && *most > 0 && *period > 0) {
      lower(quota, static_cast<double>(*most) / static_cast<double>(*period));
    }
  }
  for (const fs::path& group : groupsOf(fs::path(root) / "cpu", "cpu")) {
    const auto most = wordsOfFile(group / "cpu.cfs_quota_us");
    const auto period = wordsOfFile(group / "cpu.cfs_period_us");
    const auto quotaNumber = most.empty() ? std::nullopt : numberIn(most.front());
    const auto periodNumber = period.empty() ? std::nullopt : numberIn(period.front());
    if (quotaNumber && periodNumber && *quotaNumber > 0 && *periodNumber > 0) {
      lower(quota, static_cast<double>(*quotaNumber) / static_cast<double>(*periodNumber));
    }
  }
  cpu_set_t allowed;
  const int count = sched_getaffinity(0, sizeof(allowed), &allowed) == 0 ? CPU_COUNT(&allowed) : 0;
  const unsigned processors =
      count > 0 ? static_cast<unsigned>(count) : std::max(std::thread::hardware_concurrency(), 1U);
  return quota ? std::clamp(static_cast<unsigned>(std::ceil(*quota)), 1U, processors) : processors;
}

}  // namespace espalier::server
