#include "engine/turtle/export/text/rsml.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <span>
#include <unordered_map>
#include <vector>

#include "engine/core/hash.h"
#include "engine/core/number_text.h"
#include "engine/turtle/export/text_output.h"
#include "engine/turtle/turtle_motion.h"

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

/// Digits behind the point of coordinates, so that the largest has twelve. A turtle comes to a point by a length and a
/// direction, an error of about 16 digits; with twelve a file that was read and is written again has the same numbers.
int decimalsOf(std::span<const Segment> segments) {
  constexpr int kDigits = 12;
  double largest = 0.0;
  for (const Segment& segment : segments) {
    for (const core::Vec3& place : {segment.start, segment.end}) {
      largest = std::max({largest, std::abs(place.x), std::abs(place.y), std::abs(place.z)});
    }
  }
  if (!(largest > 0.0)) {
    return 0;
  }
  int decimals = kDigits;
  for (double power = 1.0; power <= largest && decimals > 0; power *= 10.0) {
    --decimals;
  }
  for (double power = 0.1; power > largest && decimals < 300; power /= 10.0) {
    ++decimals;
  }
  return decimals;
}

/// What a file says beside its lines.
struct RsmlFacts {
  std::string_view unit;              // empty: unknown
  std::optional<std::uint64_t> step;  // of a file that holds one step
  std::span<const double> days;       // of emergence (segments); or empty
};

class RsmlWriter {
 public:
  RsmlWriter(std::span<const Segment> segments, const RsmlFacts& facts, core::ByteSink& sink)
      : segments_(segments), facts_(facts), axes_(axesOf(segments)), decimals_(decimalsOf(segments)), out_(sink) {}

  void write() {
    out_ << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<rsml>\n<metadata><version>1</version><unit>";
    writeEscaped(facts_.unit.empty() ? "unknown" : facts_.unit);
    out_ << "</unit><resolution>1</resolution><software>Espalier</software>";
    const std::optional<std::uint64_t>& step = facts_.step;
    if (step) {
      out_ << "<time-sequence><index>" << std::to_string(*step) << "</index><unified>false</unified></time-sequence>";
    }
    out_ << "</metadata>\n<scene>\n";
    bool isOpen = false;
    std::uint32_t plant = 0;
    for (std::uint32_t axis = 0; axis < axes_.size(); ++axis) {
      if (axes_[axis].parent != kNoParent) {
        continue;
      }
      const std::uint32_t own = segments_[axes_[axis].segments.front()].plant;
      if (!isOpen || own != plant) {
        out_ << (isOpen ? "</plant>\n" : "") << "<plant ID=\"" << std::to_string(own) << "\">\n";
        isOpen = true;
        plant = own;
      }
      writeWithLaterals(axis);
    }
    out_ << (isOpen ? "</plant>\n" : "") << "</scene>\n</rsml>\n";
  }

 private:
  void writeEscaped(std::string_view text) {
    for (const char letter : text) {
      out_ << (letter == '&'   ? "&amp;"
               : letter == '<' ? "&lt;"
               : letter == '>' ? "&gt;"
                               : std::string_view(&letter, 1));
    }
  }

  void number(const char* name, double value) {
    std::string text;
    core::appendNumber(text, value, core::NumberStyle::Shortest);
    out_ << ' ' << name << "=\"" << text << '"';
  }

  void coordinate(const char* name, double value) {
    char text[700];  // 309 digits, the point and 300 decimals
    const auto written = std::to_chars(text, text + sizeof(text), value, std::chars_format::fixed, decimals_);
    std::string_view digits(text, static_cast<std::size_t>(written.ptr - text));
    if (digits.find('.') != std::string_view::npos) {
      digits = digits.substr(0, digits.find_last_not_of('0') + 1);
      digits.remove_suffix(digits.ends_with('.') ? 1 : 0);
    }
    out_ << ' ' << name << "=\"" << (digits == "-0" ? "0" : digits) << '"';
  }

  void point(const core::Vec3& place) {
    out_ << "<point";
    coordinate("x", place.x);
    coordinate("y", place.y);
    coordinate("z", place.z);
    out_ << "/>";
  }

  void sample(double value) {
    out_ << "<sample";
    number("value", value);
    out_ << "/>";
  }

  /// What belongs to an axis alone, without the end of its element.
  void begin(std::uint32_t index) {
    const Axis& axis = axes_[index];
    out_ << "<root ID=\"" << std::to_string(index) << "\">";
    if (axis.parent != kNoParent) {
      out_ << "<properties><parent-node value=\"" << std::to_string(axis.parentNode) << "\"/></properties>";
    }
    out_ << "\n<geometry><polyline>";
    point(segments_[axis.segments.front()].start);
    for (const std::uint32_t segment : axis.segments) {
      point(segments_[segment].end);
    }
    out_ << "</polyline></geometry>\n<functions>";
    // roots that were read from a file may have no diameters
    const bool hasWidths = std::ranges::any_of(
        axis.segments, [&](std::uint32_t segment) { return segments_[segment].endWidth > kSmallestWidth; });
    if (hasWidths) {
      out_ << "<function name=\"diameter\" domain=\"polyline\">";
      sample(segments_[axis.segments.front()].startWidth);
      for (const std::uint32_t segment : axis.segments) {
        sample(segments_[segment].endWidth);
      }
      out_ << "</function>";
    }
    if (!facts_.days.empty()) {
      // a first point is there with the first segment
      out_ << (hasWidths ? "\n" : "") << "<function name=\"emergence_time\" domain=\"polyline\">";
      sample(facts_.days[axis.segments.front()]);
      for (const std::uint32_t segment : axis.segments) {
        sample(facts_.days[segment]);
      }
      out_ << "</function>";
    }
    out_ << "</functions>\n";
  }

  /// Laterals of any depth, without recursion.
  void writeWithLaterals(std::uint32_t first) {
    std::vector<std::pair<std::uint32_t, std::size_t>> open{{first, 0}};  // axis, and the number of its next lateral
    begin(first);
    while (!open.empty()) {
      auto& [axis, next] = open.back();
      if (next == axes_[axis].laterals.size()) {
        out_ << "</root>\n";
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
  TextOutput out_;
};

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
    segments_ = input.scene.segments;
    days_.clear();
    for (const Segment& segment : segments_) {
      const auto& [x, y, z] = segment.end;
      const PlantPoint point{
          segment.plant,
          {std::bit_cast<std::uint64_t>(x), std::bit_cast<std::uint64_t>(y), std::bit_cast<std::uint64_t>(z)}};
      const double day = static_cast<double>(step) * input.stepDurationDays;
      days_.push_back(firstDays_.try_emplace(point, day).first->second);
    }
    return std::nullopt;
  }

  void finish() override {
    const RsmlFacts facts{.unit = unit_, .step = {}, .days = days_};
    RsmlWriter(segments_, facts, target_.sink).write();
  }

 private:
  const ExportTarget& target_;
  std::string unit_;
  std::vector<Segment> segments_;  // of the last frame
  std::vector<double> days_;       // (segments)
  std::unordered_map<PlantPoint, double, PlantPointHash> firstDays_;
};

}  // namespace

std::optional<std::string> writeRsml(const ExportInput& input, const ExportTarget& target) {
  const RsmlFacts facts{.unit = input.lengthUnit, .step = input.step, .days = {}};
  RsmlWriter(input.scene.segments, facts, target.sink).write();
  return std::nullopt;
}

std::unique_ptr<GrowthExport> beginRsmlGrowth(const ExportTarget& target, const GrowthRange& /*range*/) {
  return std::make_unique<RsmlGrowth>(target);
}

}  // namespace espalier::turtle
