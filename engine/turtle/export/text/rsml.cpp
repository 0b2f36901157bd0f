#include "engine/turtle/export/text/rsml.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include "engine/core/number_text.h"
#include "engine/turtle/export/text_output.h"

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
std::vector<Axis> axesOf(const Scene& scene) {
  std::vector<Axis> axes;
  std::vector<std::uint32_t> axisOf(scene.segments.size());
  std::vector<std::size_t> placeIn(scene.segments.size());  // of each segment in its axis
  for (std::uint32_t i = 0; i < scene.segments.size(); ++i) {
    const Segment& segment = scene.segments[i];
    const bool isRoot = segment.parent == kNoParent;
    const bool continues = !isRoot && scene.segments[segment.parent].branchOrder == segment.branchOrder &&
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
int decimalsOf(const Scene& scene) {
  constexpr int kDigits = 12;
  double largest = 0.0;
  for (const Segment& segment : scene.segments) {
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

class RsmlWriter {
 public:
  RsmlWriter(const Scene& scene, core::ByteSink& sink)
      : scene_(scene), axes_(axesOf(scene)), decimals_(decimalsOf(scene)), out_(sink) {}

  void write(std::optional<std::uint64_t> step) {
    out_ << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<rsml>\n<metadata><version>1</version><unit>unknown</unit>"
            "<resolution>1</resolution><software>Espalier</software>";
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
      const std::uint32_t own = scene_.segments[axes_[axis].segments.front()].plant;
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

  void sample(double diameter) {
    out_ << "<sample";
    number("value", diameter);
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
    point(scene_.segments[axis.segments.front()].start);
    for (const std::uint32_t segment : axis.segments) {
      point(scene_.segments[segment].end);
    }
    out_ << "</polyline></geometry>\n<functions><function name=\"diameter\" domain=\"polyline\">";
    sample(scene_.segments[axis.segments.front()].startWidth);
    for (const std::uint32_t segment : axis.segments) {
      sample(scene_.segments[segment].endWidth);
    }
    out_ << "</function></functions>\n";
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

  const Scene& scene_;
  std::vector<Axis> axes_;
  int decimals_;
  TextOutput out_;
};

}  // namespace

std::optional<std::string> writeRsml(const ExportInput& input, const ExportTarget& target) {
  RsmlWriter(input.scene, target.sink).write(input.step);
  return std::nullopt;
}

}  // namespace espalier::turtle
