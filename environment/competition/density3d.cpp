// The process `density3d` (docs/environments.md): counts that queries leave in the voxels of a box.
//
// The counts are the state. By default all amounts of a step are added before any sum is read; with `order` "published"
// the sum is read right after the query's own amount, in string order. O(1) a query; memory grows with the touched
// voxels.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/base/state_bytes.h"
#include "environment/geometry/float_vec.h"
#include "environment/geometry/grid_keys.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kDensity3dSummary =
    "Counts in the voxels of a box: a query adds to its voxel and reads the sum.";
constexpr std::array<std::string_view, 2> kDensity3dOrders{"independent", "published"};
constexpr std::array kDensity3dKeys{
    sidesKey("range", "size of the box along x, y, z", kUnitSides),
    positionKey(kOrigin),
    gridSizeKey(kUnitSides, "number of voxels along x, y, z", 1048576.0),
    ConfigurationKey{
        .name = "octreeLevel",
        .kind = KeyKind::Integer,
        .description = "level k of an octree: 2^k voxels in each direction instead of gridSize; -1: not used",
        .minimum = -1,
        .maximum = 20,
        .defaultNumber = -1},
    ConfigurationKey{
        .name = "order",
        .kind = KeyKind::Choice,
        .description =
            "independent: read the sum after all queries of the step; published: after the own query, in string order",
        .defaultText = "independent",
        .choices = kDensity3dOrders},
};
constexpr std::array kDensity3dPublishedKeywords{
    PublishedKeyword{.keyword = "range", .kind = PublishedKind::Numbers, .key = "range", .count = 3},
    PublishedKeyword{.keyword = "position", .kind = PublishedKind::Numbers, .key = "position", .count = 3},
    PublishedKeyword{.keyword = "grid size", .kind = PublishedKind::Numbers, .key = "gridSize", .count = 3},
    PublishedKeyword{.keyword = "octree level", .kind = PublishedKind::Number, .key = "octreeLevel"},
};

struct Box {
  core::Vec3 position;
  core::Vec3 range;
  std::array<std::uint64_t, 3> voxelCount;
};

/// Whole numbers by voxel: an array where all voxels fit into 128 MB, otherwise a table of those that are not 0.
class VoxelCounts {
 public:
  explicit VoxelCounts(const std::array<std::uint64_t, 3>& voxelCount) {
    constexpr std::uint64_t kMostVoxels = std::uint64_t{1} << 24;
    const auto [nx, ny, nz] = voxelCount;
    if (nx <= kMostVoxels && ny <= kMostVoxels / nx && nz <= kMostVoxels / (nx * ny)) {
      arraySize_ = nx * ny * nz;
    }
  }

  void clear() {
    array_.clear();
    table_.clear();
  }
  /// Adds modulo 2^64: the same sum in any order.
  void add(std::uint64_t voxel, std::int64_t amount) {
    if (array_.empty() && arraySize_ > 0) {
      array_.resize(arraySize_);
    }
    std::int64_t& count = arraySize_ > 0 ? array_[voxel] : table_[voxel];
    count = static_cast<std::int64_t>(static_cast<std::uint64_t>(count) + static_cast<std::uint64_t>(amount));
  }
  [[nodiscard]] std::int64_t at(std::uint64_t voxel) const {
    if (arraySize_ > 0) {
      return array_.empty() ? 0 : array_[voxel];
    }
    const auto found = table_.find(voxel);
    return found == table_.end() ? 0 : found->second;
  }
  [[nodiscard]] bool contains(std::uint64_t voxel) const { return arraySize_ == 0 || voxel < arraySize_; }
  /// The counts other than 0, in ascending order of voxels.
  [[nodiscard]] std::vector<std::pair<std::uint64_t, std::int64_t>> sorted() const {
    std::vector<std::pair<std::uint64_t, std::int64_t>> counts(table_.begin(), table_.end());
    for (std::uint64_t voxel = 0; voxel < array_.size(); ++voxel) {
      if (array_[voxel] != 0) {
        counts.emplace_back(voxel, array_[voxel]);
      }
    }
    std::erase_if(counts, [](const auto& entry) { return entry.second == 0; });
    std::sort(counts.begin(), counts.end());
    return counts;
  }

 private:
  std::uint64_t arraySize_ = 0;      // 0: the table is used
  std::vector<std::int64_t> array_;  // by voxel; empty until something is added
  std::unordered_map<std::uint64_t, std::int64_t> table_;
};

class Density3d final : public turtle::EnvironmentProcess {
 public:
  Density3d(const Box& box, bool isPublishedOrder)
      : box_(box), isPublishedOrder_(isPublishedOrder), counts_(box.voxelCount) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "density3d",
            .summary = std::string(kDensity3dSummary),
            .needs = {.position = true, .parameters = true},
            .inputs = {{"amount", "1", ""}},
            .outputs = {{"count", "1", ""}},
            .isStateful = true};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    counts_.clear();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (!isPublishedOrder_) {
      for (std::size_t query = 0; query < queries.size(); ++query) {
        addAmount(queries, query);
      }
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      if (isPublishedOrder_) {
        addAmount(queries, query);
      }
      if (!queries.parametersOf(query).empty()) {
        replies.set(queries, query, 0, static_cast<double>(countAt(queries.position[query])));
      }
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

  [[nodiscard]] std::string save() const override {
    const auto sorted = counts_.sorted();
    StateWriter writer;
    writer.integer(sorted.size());
    for (const auto& [voxel, count] : sorted) {
      writer.integer(voxel);
      writer.integer(static_cast<std::uint64_t>(count));
    }
    return writer.take();
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    StateReader reader(state);
    VoxelCounts counts(box_.voxelCount);
    bool isInBox = true;
    const std::uint64_t voxelCount = reader.integer();
    for (std::uint64_t i = 0; i < voxelCount && reader.isIntact(); ++i) {
      const std::uint64_t voxel = reader.integer();
      const auto amount = static_cast<std::int64_t>(reader.integer());
      isInBox = isInBox && counts.contains(voxel);
      if (isInBox && reader.isIntact()) {
        counts.add(voxel, amount);
      }
    }
    if (!reader.isComplete() || !isInBox) {
      return turtle::EnvironmentError{
          "The saved state of environment 'density3d' is damaged. Use a snapshot that is complete.", false};
    }
    counts_ = std::move(counts);
    return std::nullopt;
  }

 private:
  /// A point in voxels from the low corner.
  [[nodiscard]] std::array<double, 3> partsOf(const core::Vec3& point) const {
    const core::Vec3 offset = point - box_.position;
    return {offset.x / box_.range.x * static_cast<double>(box_.voxelCount[0]),
            offset.y / box_.range.y * static_cast<double>(box_.voxelCount[1]),
            offset.z / box_.range.z * static_cast<double>(box_.voxelCount[2])};
  }
  /// The same in 32-bit floats, as the published program.
  [[nodiscard]] std::array<double, 3> publishedParts(const core::Vec3& point) const {
    const FloatVec offset = toFloat(point) - toFloat(box_.position);
    const FloatVec range = toFloat(box_.range);
    return {offset.x / range.x * static_cast<float>(box_.voxelCount[0]),
            offset.y / range.y * static_cast<float>(box_.voxelCount[1]),
            offset.z / range.z * static_cast<float>(box_.voxelCount[2])};
  }

  /// The voxel of a point, or nothing outside the box.
  [[nodiscard]] std::optional<std::uint64_t> voxelOf(const core::Vec3& point) const {
    const std::array<double, 3> parts = isPublishedOrder_ ? publishedParts(point) : partsOf(point);
    std::uint64_t voxel = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto count = static_cast<double>(box_.voxelCount[axis]);
      const double index = std::floor(parts[axis]);
      if (!(index >= 0.0 && index < count)) {
        return std::nullopt;
      }
      voxel = voxel * box_.voxelCount[axis] + static_cast<std::uint64_t>(index);
    }
    return voxel;
  }

  void addAmount(const turtle::QueryBatch& queries, std::size_t query) {
    const auto parameters = queries.parametersOf(query);
    const auto voxel = voxelOf(queries.position[query]);
    if (parameters.empty() || !voxel) {
      return;
    }
    constexpr double kLargest = 1099511627776.0;  // 2^40
    const auto amount = static_cast<std::int64_t>(std::clamp(parameters[0], -kLargest, kLargest));
    if (amount != 0) {
      counts_.add(*voxel, amount);
    }
  }

  [[nodiscard]] std::int64_t countAt(const core::Vec3& point) const {
    const auto voxel = voxelOf(point);
    return voxel ? counts_.at(*voxel) : 0;
  }

  Box box_;
  bool isPublishedOrder_;
  VoxelCounts counts_;
};

Box boxOf(const Configuration& configuration) {
  Box box{vectorOf(configuration, "position"), vectorOf(configuration, "range"), {1, 1, 1}};
  const std::int64_t level = configuration.integer("octreeLevel");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.voxelCount[axis] = level >= 0 ? std::uint64_t{1} << static_cast<unsigned>(level)
                                      : static_cast<std::uint64_t>(configuration.numbers("gridSize")[axis]);
  }
  return box;
}

}  // namespace

extern constinit const ProcessEntry kDensity3dProcess{
    .name = "density3d",
    .summary = kDensity3dSummary,
    .source = "the published program density3d",
    .keys = kDensity3dKeys,
    .publishedKeywords = kDensity3dPublishedKeywords,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      return std::make_unique<Density3d>(boxOf(configuration), configuration.text("order") == "published");
    }};

}  // namespace espalier::environment
