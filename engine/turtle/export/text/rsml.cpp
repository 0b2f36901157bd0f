#include "engine/turtle/export/text/rsml.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/core/hash.h"
#include "engine/turtle/export/text/rsml_text.h"
#include "engine/turtle/turtle_motion.h"
#include "engine/turtle/world.h"

namespace espalier::turtle {

namespace {

/// A series of segments of one branch order, each growing from the one before.
struct Axis {
  std::vector<std::uint32_t> segments;
  std::uint32_t parent = kNoParent;     // axis that it grows from
  std::size_t parentNode = 0;           // point of that axis
  std::vector<std::uint32_t> laterals;  // axes
};

/// The axes of all plants; a parent comes before its laterals.
std::vector<Axis> axesOf(std::span<const Segment> segments) {
  std::vector<Axis> axes;
  std::vector<std::uint32_t> axisOf(segments.size());
  std::vector<std::size_t> placeIn(segments.size());  // of each segment in its axis
  for (std::uint32_t i = 0; i < segments.size(); ++i) {
    const Segment& segment = segments[i];
    const bool isRoot = segment.parent == kNoParent;
    const bool continues = !isRoot && segments[segment.parent].branchOrder == segment.branchOrder &&
                           placeIn[segment.parent] + 1 == axes[axisOf[segment.parent]].segments.size();
    if (!continues) {
      Axis axis;
      if (!isRoot) {
        axis.parent = axisOf[segment.parent];
        axis.parentNode = placeIn[segment.parent] + 1;
        axes[axis.parent].laterals.push_back(static_cast<std::uint32_t>(axes.size()));
      }
      axes.push_back(std::move(axis));
    }
    axisOf[i] = continues ? axisOf[segment.parent] : static_cast<std::uint32_t>(axes.size() - 1);
    placeIn[i] = axes[axisOf[i]].segments.size();
    axes[axisOf[i]].segments.push_back(i);
  }
  return axes;
}

/// Digits behind the point of numbers up to `largest`, which gets so many digits in all.
int decimalsFor(double largest, int digits) {
  if (!(largest > 0.0)) {
    return 0;
  }
  int decimals = digits;
  for (double power = 1.0; power <= largest && decimals > 0; power *= 10.0) {
    --decimals;
  }
  for (double power = 0.1; power > largest && decimals < 300; power /= 10.0) {
    ++decimals;
  }
  return decimals;
}

/// Digits behind the point of coordinates. A turtle comes to a point by a length and a direction, an error of about 16
/// digits; with twelve a model that draws a line twice writes the same numbers. Small plants far from the origin need
/// more.
int decimalsOf(std::span<const Segment> segments) {
  if (segments.empty()) {
    return 0;
  }
  double largest = 0.0;
  core::Vec3 low = segments.front().start;
  core::Vec3 high = low;
  for (const Segment& segment : segments) {
    for (const core::Vec3& place : {segment.start, segment.end}) {
      largest = std::max({largest, std::abs(place.x), std::abs(place.y), std::abs(place.z)});
      low = {std::min(low.x, place.x), std::min(low.y, place.y), std::min(low.z, place.z)};
      high = {std::max(high.x, place.x), std::max(high.y, place.y), std::max(high.z, place.z)};
    }
  }
  const double extent = std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  const int usual = decimalsFor(largest, 12);
  return std::max(usual, std::min(decimalsFor(extent, 12), decimalsFor(largest, 14)));
}

class RsmlWriter {
 public:
  RsmlWriter(std::span<const Segment> segments, const RsmlFacts& facts, core::ByteSink& sink)
      : segments_(segments), facts_(facts), axes_(axesOf(segments)), decimals_(decimalsOf(segments)), text_(sink) {}

  void write() {
    text_.beginScene(facts_);
    bool isOpen = false;
    std::uint32_t plant = 0;
    for (std::uint32_t axis = 0; axis < axes_.size(); ++axis) {
      if (axes_[axis].parent != kNoParent) {
        continue;
      }
      const std::uint32_t own = segments_[axes_[axis].segments.front()].plant;
      if (!isOpen || own != plant) {
        if (isOpen) {
          text_.endPlant();
        }
        text_.beginPlant(std::to_string(own), "");
        isOpen = true;
        plant = own;
      }
      writeWithLaterals(axis);
    }
    if (isOpen) {
      text_.endPlant();
    }
    text_.endScene();
  }

 private:
  void writeFunctions(const Axis& axis) {
    constexpr double kNoSample = std::numeric_limits<double>::quiet_NaN();
    const auto orNone = [](double width) { return width > kSmallestWidth ? width : kNoSample; };
    std::vector<double> values{segments_[axis.segments.front()].startWidth};
    for (const std::uint32_t segment : axis.segments) {
      values.push_back(orNone(segments_[segment].endWidth));
    }
    const bool hasWidths =
        std::any_of(values.begin() + 1, values.end(), [](double width) { return !std::isnan(width); });
    if (hasWidths) {
      // a width that is nothing in the middle is a sample, too
      bool isLater = false;
      for (auto value = values.rbegin(); value != values.rend(); ++value) {
        isLater = isLater || !std::isnan(*value);
        *value = isLater && std::isnan(*value) ? 0.0 : *value;
      }
      text_.function("diameter", values);
    }
    if (!facts_.days.empty()) {
      // a first point is there with the first segment
      values.assign(1, facts_.days[axis.segments.front()]);
      for (const std::uint32_t segment : axis.segments) {
        values.push_back(facts_.days[segment]);
      }
      text_.function("emergence_time", values);
    }
  }

  /// Writes the part that belongs to an axis alone, without the end of its element.
  void begin(std::uint32_t index) {
    const Axis& axis = axes_[index];
    text_.beginRoot(std::to_string(index), "",
                    axis.parent != kNoParent ? std::optional(axis.parentNode) : std::nullopt);
    text_.point(segments_[axis.segments.front()].start, decimals_);
    for (const std::uint32_t segment : axis.segments) {
      text_.point(segments_[segment].end, decimals_);
    }
    text_.endPoints();
    writeFunctions(axis);
    text_.endFunctions();
  }

  /// Laterals of any depth, without recursion.
  void writeWithLaterals(std::uint32_t first) {
    std::vector<std::pair<std::uint32_t, std::size_t>> open{{first, 0}};  // axis, and the number of its next lateral
    begin(first);
    while (!open.empty()) {
      auto& [axis, next] = open.back();
      if (next == axes_[axis].laterals.size()) {
        text_.endRoot();
        open.pop_back();
        continue;
      }
      const std::uint32_t lateral = axes_[axis].laterals[next++];
      begin(lateral);
      open.emplace_back(lateral, 0);
    }
  }

  std::span<const Segment> segments_;
  RsmlFacts facts_;
  std::vector<Axis> axes_;
  int decimals_;
  RsmlText text_;
};

/// Writes the roots of the labels where they are what is drawn, or else the lines.
void writeRoots(std::span<const Segment> segments, std::uint64_t step, const RsmlFacts& facts, core::ByteSink& sink) {
  if (!writeLabelledRsml(segments, step, facts, sink)) {
    RsmlWriter(segments, facts, sink).write();
  }
}

/// A point and the plant that it belongs to.
struct PlantPoint {
  std::uint32_t plant = 0;
  std::array<std::uint64_t, 3> bits{};  // of the coordinates

  [[nodiscard]] bool operator==(const PlantPoint&) const = default;
};

struct PlantPointHash {
  [[nodiscard]] std::size_t operator()(const PlantPoint& point) const {
    core::Hasher hasher;
    hasher.integer(point.plant);
    for (const std::uint64_t bits : point.bits) {
      hasher.integer(bits);
    }
    return hasher.value();
  }
};

class RsmlGrowth final : public GrowthExport {
 public:
  explicit RsmlGrowth(const ExportTarget& target) : target_(target) {}

  [[nodiscard]] std::optional<std::string> addFrame(const ExportInput& input, std::uint64_t step) override {
    unit_ = input.lengthUnit;
    labels_ = input.rsml;
    step_ = step;
    segments_ = input.scene.segments;
    days_.clear();
    for (const Segment& segment : segments_) {
      const auto& [x, y, z] = segment.end;
      const PlantPoint point{
          segment.plant,
          {std::bit_cast<std::uint64_t>(x), std::bit_cast<std::uint64_t>(y), std::bit_cast<std::uint64_t>(z)}};
      const double day = beginOfStep(input.stepDurationDays, step);
      days_.push_back(firstDays_.try_emplace(point, day).first->second);
    }
    return std::nullopt;
  }

  void finish() override {
    const RsmlFacts facts{.unit = unit_, .step = {}, .days = days_, .labels = labels_};
    writeRoots(segments_.view(), step_, facts, target_.sink);
  }

 private:
  const ExportTarget& target_;
  std::string unit_;
  const RsmlLabels* labels_ = nullptr;
  std::uint64_t step_ = 0;          // of the last frame
  core::Buffer<Segment> segments_;  // of the last frame
  std::vector<double> days_;        // (segments)
  std::unordered_map<PlantPoint, double, PlantPointHash> firstDays_;
};

}  // namespace

std::optional<std::string> writeRsml(const ExportInput& input, const ExportTarget& target) {
  const std::span<const Segment> segments = input.scene.segments.view();
  const RsmlFacts facts{.unit = input.lengthUnit, .step = input.step, .days = {}, .labels = input.rsml};
  writeRoots(segments, input.step.value_or(0), facts, target.sink);
  return std::nullopt;
}

std::unique_ptr<GrowthExport> beginRsmlGrowth(const ExportTarget& target, const GrowthRange& /*range*/) {
  return std::make_unique<RsmlGrowth>(target);
}

}  // namespace espalier::turtle
