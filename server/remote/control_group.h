#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace espalier::server {

/// The memory that the control group of this process may have (cgroup v2, else v1). Nothing: no bound is known.
[[nodiscard]] std::optional<std::uint64_t> controlGroupMemoryBytes(const std::string& root = "/sys/fs/cgroup");

/// The memory that limits of this process allow (`ulimit -v` and `-d`). Nothing: no bound.
[[nodiscard]] std::optional<std::uint64_t> processMemoryBytes();

/// The memory that this process may have: four fifths of the least of the machine's, its control group's, and what the
/// limits of the process allow.
[[nodiscard]] std::uint64_t usableMemoryBytes();

/// How many threads this process can run at a time: the processors that it may use, or the quota of its control group
/// when that is less, rounded up. At least 1.
[[nodiscard]] unsigned processorCount(const std::string& root = "/sys/fs/cgroup");

}  // namespace espalier::server
