#include "environment/light/leaf_counts.h"

#include <utility>

#include "environment/base/state_bytes.h"

namespace espalier::environment {

std::string saveLeafCounts(const std::vector<std::int32_t>& leaves) {
  StateWriter writer;
  for (std::size_t begin = 0; begin < leaves.size();) {
    std::size_t end = begin;
    while (end < leaves.size() && leaves[end] == leaves[begin]) {
      ++end;
    }
    writer.integer(end - begin);
    writer.integer(static_cast<std::uint64_t>(static_cast<std::int64_t>(leaves[begin])));
    begin = end;
  }
  return writer.take();
}

namespace {
// of one cell in a saved state: half of what the type holds, so that a run can go on
constexpr std::int64_t kMostLeaves = std::int64_t{1} << 30U;
}  // namespace

std::optional<turtle::EnvironmentError> restoreLeafCounts(std::string_view state, std::vector<std::int32_t>& leaves) {
  StateReader reader(state);
  std::vector<std::int32_t> read;
  while (reader.isIntact() && read.size() < leaves.size()) {
    const std::uint64_t count = reader.integer();
    const auto value = static_cast<std::int64_t>(reader.integer());
    if (count == 0 || count > leaves.size() - read.size() || value < -kMostLeaves || value > kMostLeaves) {
      break;
    }
    read.insert(read.end(), static_cast<std::size_t>(count), static_cast<std::int32_t>(value));
  }
  if (!reader.isComplete() || read.size() != leaves.size()) {
    return turtle::EnvironmentError{
        "The saved state of environment 'clover' is damaged or of a raster of another size. Use a snapshot that is "
        "complete and was made with this configuration.",
        false};
  }
  leaves = std::move(read);
  return std::nullopt;
}

}  // namespace espalier::environment
