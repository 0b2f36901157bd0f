#include "engine/turtle/export/text/rsml.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>
#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

#include "engine/core/hash.h"
#include "engine/core/number_text.h"
#include "engine/turtle/export/text_output.h"
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
  const RsmlLabels* labels = nullptr;
};

/// The pieces of labels that are drawn after a step, if they are the lines of the scene; else none.
std::vector<const RsmlLabels::Piece*> piecesOf(const RsmlLabels* labels, std::uint64_t step, std::size_t lines) {
  std::vector<const RsmlLabels::Piece*> pieces;
  if (labels != nullptr) {
    for (const RsmlLabels::Piece& piece : labels->pieces) {
      if (piece.step <= step) {
        pieces.push_back(&piece);
      }
    }
  }
  if (pieces.size() != lines) {
    pieces.clear();
  }
  return pieces;
}

class RsmlWriter {
 public:
  RsmlWriter(std::span<const Segment> segments, const RsmlFacts& facts, std::vector<const RsmlLabels::Piece*> pieces,
             core::ByteSink& sink)
      : segments_(segments),
        facts_(facts),
        pieces_(std::move(pieces)),
        axes_(axesOf(segments)),
        decimals_(decimalsOf(segments)),
        out_(sink) {
    hasLabelledDays_ = std::ranges::any_of(pieces_, [](const auto* piece) { return !std::isnan(piece->day); });
  }

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
      const RsmlLabels::Root* const root = labelOf(axes_[axis]);
      const std::uint32_t own = root != nullptr ? root->plant : segments_[axes_[axis].segments.front()].plant;
      if (!isOpen || own != plant) {
        out_ << (isOpen ? "</plant>\n" : "") << "<plant";
        named(root != nullptr ? facts_.labels->plants[own] : RsmlLabels::Plant(), own);
        out_ << ">\n";
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
               : letter == '"' ? "&quot;"
               // else a reader of XML gives a blank
               : letter == '\n' ? "&#10;"
               : letter == '\t' ? "&#9;"
               : letter == '\r' ? "&#13;"
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

  /// The label of an axis; null: none.
  [[nodiscard]] const RsmlLabels::Root* labelOf(const Axis& axis) const {
    return pieces_.empty() ? nullptr : &facts_.labels->roots[pieces_[axis.segments.front()]->root];
  }

  /// The attributes that name a plant or root; without a name of its own it has its number.
  template <typename Named>
  void named(const Named& label, std::uint32_t number) {
    out_ << " ID=\"";
    writeEscaped(label.id.empty() ? std::to_string(number) : label.id);
    if (!label.label.empty()) {
      out_ << "\" label=\"";
      writeEscaped(label.label);
    }
    out_ << '"';
  }

  /// A function with a sample at each point, up to the last one that has a value.
  void function(std::string_view name, std::span<const double> values) {
    std::size_t count = values.size();
    while (count > 0 && std::isnan(values[count - 1])) {
      --count;
    }
    // a gap in the middle cannot be written, and one sample alone would be that of the whole root
    if (count < 2 || std::ranges::any_of(values.first(count), [](double value) { return std::isnan(value); })) {
      return;
    }
    out_ << (hasFunction_ ? "\n" : "") << "<function name=\"" << name << "\" domain=\"polyline\">";
    for (std::size_t i = 0; i < count; ++i) {
      sample(values[i]);
    }
    out_ << "</function>";
    hasFunction_ = true;
  }

  void writeFunctions(const Axis& axis, const RsmlLabels::Root* label) {
    constexpr double kNoSample = std::numeric_limits<double>::quiet_NaN();
    const auto orNone = [](double width) { return width > kSmallestWidth ? width : kNoSample; };
    const bool hasFirst = label != nullptr && !std::isnan(label->firstDiameter);
    // roots that were read from a file may have no diameters
    std::vector<double> values{hasFirst ? label->firstDiameter : segments_[axis.segments.front()].startWidth};
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
      function("diameter", values);
    }
    if (hasLabelledDays_ || !facts_.days.empty()) {
      // a first point is there with the first segment unless the file says another day
      const auto dayOf = [&](std::uint32_t segment) {
        return hasLabelledDays_ ? pieces_[segment]->day : facts_.days[segment];
      };
      values.assign(1, label != nullptr && hasLabelledDays_ && !std::isnan(label->firstDay)
                           ? label->firstDay
                           : dayOf(axis.segments.front()));
      for (const std::uint32_t segment : axis.segments) {
        values.push_back(dayOf(segment));
      }
      function("emergence_time", values);
    }
  }

  /// What belongs to an axis alone, without the end of its element.
  void begin(std::uint32_t index) {
    const Axis& axis = axes_[index];
    const RsmlLabels::Root* const label = labelOf(axis);
    out_ << "<root";
    named(label != nullptr ? *label : RsmlLabels::Root(), index);
    out_ << ">";
    if (axis.parent != kNoParent) {
      out_ << "<properties><parent-node value=\"" << std::to_string(axis.parentNode) << "\"/></properties>";
    }
    out_ << "\n<geometry><polyline>";
    point(segments_[axis.segments.front()].start);
    for (const std::uint32_t segment : axis.segments) {
      point(segments_[segment].end);
    }
    out_ << "</polyline></geometry>\n<functions>";
    hasFunction_ = false;
    writeFunctions(axis, label);
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
  std::vector<const RsmlLabels::Piece*> pieces_;  // (segments), or empty
  bool hasLabelledDays_ = false;                  // one of them at least
  bool hasFunction_ = false;                      // of the axis that is written
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
    RsmlWriter(segments_, facts, piecesOf(labels_, step_, segments_.size()), target_.sink).write();
  }

 private:
  const ExportTarget& target_;
  std::string unit_;
  const RsmlLabels* labels_ = nullptr;
  std::uint64_t step_ = 0;         // of the last frame
  std::vector<Segment> segments_;  // of the last frame
  std::vector<double> days_;       // (segments)
  std::unordered_map<PlantPoint, double, PlantPointHash> firstDays_;
};

}  // namespace

std::optional<std::string> writeRsml(const ExportInput& input, const ExportTarget& target) {
  const std::span<const Segment> segments = input.scene.segments;
  const RsmlFacts facts{.unit = input.lengthUnit, .step = input.step, .days = {}, .labels = input.rsml};
  RsmlWriter(segments, facts, piecesOf(input.rsml, input.step.value_or(0), segments.size()), target.sink).write();
  return std::nullopt;
}

std::unique_ptr<GrowthExport> beginRsmlGrowth(const ExportTarget& target, const GrowthRange& /*range*/) {
  return std::make_unique<RsmlGrowth>(target);
}

}  // namespace espalier::turtle
