#include <expat.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

#include "clients/espalier/roots/root_system.h"
#include "engine/core/number_text.h"

namespace espalier::roots {

namespace {

constexpr std::size_t kMostPoints = 10'000'000;
constexpr std::size_t kMostOrders = 1000;
/// Names of units of length, each list under the name that the root system gets. `pixel` is a unit of pictures.
constexpr std::pair<std::string_view, std::string_view> kUnits[] = {
    {"m", "m"},
    {"meter", "m"},
    {"metre", "m"},
    {"dm", "dm"},
    {"cm", "cm"},
    {"centimeter", "cm"},
    {"centimetre", "cm"},
    {"mm", "mm"},
    {"millimeter", "mm"},
    {"millimetre", "mm"},
    {"um", "um"},
    {"micrometer", "um"},
    {"micrometre", "um"},
    {"inch", "inch"},
    {"in", "inch"},
    {"pixel", "pixel"},
    {"pixels", "pixel"},
    {"px", "pixel"},
    {"unknown", ""},
    {"", ""},
    {"meters", "m"},
    {"metres", "m"},
    {"centimeters", "cm"},
    {"centimetres", "cm"},
    {"millimeters", "mm"},
    {"millimetres", "mm"},
    {"micrometers", "um"},
    {"micrometres", "um"},
    {"micron", "um"},
    {"microns", "um"},
    {"µm", "um"},
    {"μm", "um"},  // the micro sign, and the Greek letter
    {"inches", "inch"},
    {"nm", "nm"},
    {"nanometer", "nm"},
    {"nanometre", "nm"},
};
/// Points that are looked at to find where laterals begin, in all. A file of people needs a small part of it.
constexpr std::uint64_t kMostLooks = 1'000'000'000;

/// A `root` element while it is read. Laterals are inside of it, after its geometry or before.
struct ReadAxis {
  std::size_t line = 0;
  std::vector<core::Vec3> points;
  std::vector<double> diameters, emergences;  // samples along the polyline
  std::optional<double> parentNode;
  std::size_t parent = std::string::npos;  // index of the axis that it is inside of
  std::uint32_t order = 1;
};

class Reader {
 public:
  tl::expected<RootSystem, std::string> read(std::string_view text) {
    const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(XML_ParserCreate(nullptr),
                                                                              XML_ParserFree);
    parser_ = parser.get();
    XML_SetUserData(parser_, this);
    XML_SetElementHandler(
        parser_,
        [](void* self, const char* name, const char** attributes) {
          static_cast<Reader*>(self)->begin(name, attributes);
        },
        [](void* self, const char* name) { static_cast<Reader*>(self)->end(name); });
    XML_SetCharacterDataHandler(parser_, [](void* self, const char* letters, int count) {
      static_cast<Reader*>(self)->letters(std::string_view(letters, static_cast<std::size_t>(count)));
    });
    // entities can make a small file large, and root files have none
    XML_SetEntityDeclHandler(parser_, [](void* self, const char*, int, const char*, int, const char*, const char*,
                                         const char*, const char*) {
      static_cast<Reader*>(self)->fail("the file declares an entity, which root files do not need. Remove it");
    });
    constexpr std::size_t kPiece = std::size_t{1} << 20;
    for (std::size_t from = 0; problem_.empty() && from <= text.size(); from += kPiece) {
      const std::string_view piece = text.substr(from, kPiece);
      const bool isLast = from + kPiece > text.size();
      if (XML_Parse(parser_, piece.data(), static_cast<int>(piece.size()), isLast ? 1 : 0) == XML_STATUS_ERROR) {
        fail(std::string("the file is no XML: ") + XML_ErrorString(XML_GetErrorCode(parser_)) +
             ". Give a file in the Root System Markup Language");
      }
      if (isLast) {
        break;
      }
    }
    if (problem_.empty() && !hasScene_) {
      fail("the file has no 'scene' of plants. Give a file in the Root System Markup Language");
    }
    if (!problem_.empty()) {
      return tl::unexpected(problem_);
    }
    return joined();
  }

 private:
  /// Keeps the first problem and ends the reading.
  void fail(const std::string& sentence) {
    if (problem_.empty()) {
      problem_ = "line " + std::to_string(XML_GetCurrentLineNumber(parser_)) + ": " + sentence;
      XML_StopParser(parser_, XML_FALSE);
    }
  }
  [[nodiscard]] std::optional<double> numberIn(std::string_view field) {
    const std::size_t from = field.find_first_not_of(" \t\r\n");
    const std::size_t until = field.find_last_not_of(" \t\r\n");
    field = from == std::string_view::npos ? std::string_view() : field.substr(from, until - from + 1);
    double value = 0.0;
    const auto [at, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || at != field.data() + field.size() || !std::isfinite(value)) {
      fail("expected a number, found '" + std::string(field.substr(0, 40)) + "'. Write a number there");
      return std::nullopt;
    }
    return value;
  }
  [[nodiscard]] static std::optional<std::string_view> attributeOf(const char** attributes, std::string_view name) {
    for (; *attributes != nullptr; attributes += 2) {
      if (name == *attributes) {
        return attributes[1];
      }
    }
    return std::nullopt;
  }

  void begin(std::string_view name, const char** attributes) {
    text_.clear();
    if (name == "scene") {
      hasScene_ = true;
    } else if (name == "property-definitions") {
      definesProperties_ = true;
    } else if (name == "root") {
      ReadAxis axis;
      axis.line = XML_GetCurrentLineNumber(parser_);
      axis.parent = open_.empty() ? std::string::npos : open_.back();
      axis.order = static_cast<std::uint32_t>(open_.size() + 1);
      if (open_.size() >= kMostOrders) {
        fail("roots stand inside each other more than " + std::to_string(kMostOrders) +
             " deep. Give a file with fewer orders");
      }
      open_.push_back(axes_.size());
      axes_.push_back(std::move(axis));
    } else if (name == "point" && !open_.empty()) {
      addPoint(attributes);
    } else if (name == "function") {
      function_ = attributeOf(attributes, "name").value_or("");
    } else if (name == "sample") {
      if (const auto value = attributeOf(attributes, "value")) {
        addSample(*value);
      }
      hasValue_ = attributeOf(attributes, "value").has_value();
    } else if (name == "parent-node" && !open_.empty()) {
      if (const auto value = attributeOf(attributes, "value")) {
        axes_[open_.back()].parentNode = numberIn(*value);
      }
    }
  }

  void end(std::string_view name) {
    if (name == "root" && !open_.empty()) {
      open_.pop_back();
    } else if (name == "sample" && !hasValue_) {
      addSample(text_);
    } else if (name == "parent-node" && !open_.empty() && !axes_[open_.back()].parentNode && !text_.empty()) {
      axes_[open_.back()].parentNode = numberIn(text_);
    } else if (name == "property-definitions") {
      definesProperties_ = false;
    } else if (name == "unit" && !definesProperties_) {
      setUnit();
    } else if (name == "resolution") {
      if (const auto resolution = numberIn(text_); resolution && *resolution <= 0.0) {
        fail("the resolution is not above 0. Write the number of pixels in a unit, or leave it out");
      }
    }
    text_.clear();
  }

  void letters(std::string_view some) {
    if (text_.size() < 1000) {
      text_ += some;
    }
  }

  /// The unit of all lengths; a property has its own.
  void setUnit() {
    std::string name;
    for (const char letter : text_) {
      if (std::isspace(static_cast<unsigned char>(letter)) == 0) {
        name += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
      }
    }
    const auto* const known = std::ranges::find(kUnits, name, &std::pair<std::string_view, std::string_view>::first);
    if (known == std::end(kUnits)) {
      fail("the unit '" + text_.substr(0, 40) +
           "' is unknown. Write one of m, dm, cm, mm, um, nm, inch, pixel, or unknown");
      return;
    }
    unit_ = known->second;
  }

  void addPoint(const char** attributes) {
    core::Vec3 place;
    for (const auto& [name, target] :
         {std::pair<std::string_view, double*>{"x", &place.x}, {"y", &place.y}, {"z", &place.z}}) {
      const auto field = attributeOf(attributes, name);
      if (!field && name != "z") {
        fail("a point has no '" + std::string(name) + "'. Write its coordinates as attributes x, y and z");
      }
      *target = field ? numberIn(*field).value_or(0.0) : 0.0;
      if (std::abs(*target) > kLargestCoordinate) {
        fail("the coordinate " + std::string(field->substr(0, 40)) + " is beyond 1e100. Correct the number");
      }
    }
    if (++pointCount_ > kMostPoints) {
      fail("the file has more than " + std::to_string(kMostPoints) + " points. Give a smaller file");
    }
    axes_[open_.back()].points.push_back(place);
  }

  void addSample(std::string_view field) {
    const bool isEmergence = function_ == "emergence_time" || function_ == "node_creation_time";
    if (open_.empty() || !(function_ == "diameter" || isEmergence)) {
      return;
    }
    const auto value = numberIn(field);
    if (value && function_ == "diameter" && *value < 0.0) {
      fail("a diameter is below 0. Correct the number");
    }
    ReadAxis& axis = axes_[open_.back()];
    if (value && axis.diameters.size() + axis.emergences.size() < 2 * kMostPoints) {
      (isEmergence ? axis.emergences : axis.diameters).push_back(*value);
    }
  }

  /// The node of an axis from which a lateral grows.
  [[nodiscard]] std::uint32_t joinOf(const RootSystem& roots, const ReadAxis& lateral,
                                     const std::vector<std::uint32_t>& nodesOfParent) {
    // -1: unknown
    if (const double wanted = lateral.parentNode.value_or(-1.0); wanted != -1.0) {
      if (wanted >= 0.0 && wanted < static_cast<double>(nodesOfParent.size()) && wanted == std::floor(wanted)) {
        return nodesOfParent[static_cast<std::size_t>(wanted)];
      }
      if (wrongJoins_++ == 0) {
        core::appendNumber(firstWrongJoin_, wanted, core::NumberStyle::Shortest);
        firstWrongJoin_ = "line " + std::to_string(lateral.line) + " has the parent-node " + firstWrongJoin_ +
                          ", and the parent has the points 0 to " + std::to_string(nodesOfParent.size() - 1);
      }
    }
    std::uint32_t best = nodesOfParent.front();
    looks_ += nodesOfParent.size();
    if (looks_ > kMostLooks) {
      return best;
    }
    for (const std::uint32_t node : nodesOfParent) {
      if (core::length(roots.nodes[node].place - lateral.points.front()) <
          core::length(roots.nodes[best].place - lateral.points.front())) {
        best = node;
      }
    }
    return best;
  }

  [[nodiscard]] tl::expected<RootSystem, std::string> joined() {
    RootSystem roots;
    roots.unit = unit_;
    std::vector<std::vector<std::uint32_t>> nodesOf(axes_.size());
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const ReadAxis& axis = axes_[i];
      const bool isLateral = axis.parent != std::string::npos && !nodesOf[axis.parent].empty() && !axis.points.empty();
      for (std::size_t k = 0; k < axis.points.size(); ++k) {
        RootSystem::Node node;
        node.place = axis.points[k];
        node.order = axis.order;
        node.axis = static_cast<std::uint32_t>(i);
        node.radius = axis.diameters.empty() ? 0.0 : 0.5 * axis.diameters[std::min(k, axis.diameters.size() - 1)];
        if (!axis.emergences.empty()) {
          node.emergence = axis.emergences[std::min(k, axis.emergences.size() - 1)];
        }
        if (k == 0 && isLateral) {
          node.parent = joinOf(roots, axis, nodesOf[axis.parent]);
          noteGap(axis, axes_[axis.parent].points, core::length(roots.nodes[node.parent].place - node.place));
          if (roots.nodes[node.parent].place == node.place) {
            // the lateral begins at the point itself
            nodesOf[i].push_back(node.parent);
            continue;
          }
        } else if (k > 0) {
          node.parent = nodesOf[i].back();
        }
        nodesOf[i].push_back(static_cast<std::uint32_t>(roots.nodes.size()));
        roots.nodes.push_back(node);
      }
    }
    if (wrongJoins_ > 0) {
      roots.remark =
          std::to_string(wrongJoins_) + (wrongJoins_ == 1 ? " lateral begins" : " laterals begin") +
          " at the nearest point of the parent, because the file names a point that is not there: " + firstWrongJoin_;
    }
    if (gaps_ > 0) {
      roots.remark +=
          (roots.remark.empty() ? "" : "; ") + std::to_string(gaps_) +
          (gaps_ == 1 ? " lateral begins" : " laterals begin") +
          " farther from the parent than the parent's points lie apart; a straight piece joins them: " + firstGap_;
    }
    if (looks_ > kMostLooks) {
      return tl::unexpected(std::string(
          "laterals have no 'parent-node', and their parents have too many points to look for it. Add the property"));
    }
    return roots;
  }

  /// Counts a lateral that begins away from its parent.
  void noteGap(const ReadAxis& lateral, const std::vector<core::Vec3>& parent, double distance) {
    double apart = 0.0;
    for (std::size_t k = 1; k < parent.size() && !(apart >= distance); ++k) {
      apart = std::max(apart, core::length(parent[k] - parent[k - 1]));
    }
    if (parent.size() > 1 && distance > apart && gaps_++ == 0) {
      core::appendNumber(firstGap_, distance, core::NumberStyle::Shortest);
      firstGap_ = "line " + std::to_string(lateral.line) + ", " + firstGap_ + " away";
    }
  }

  XML_Parser parser_ = nullptr;
  std::string problem_;
  std::size_t wrongJoins_ = 0;  // laterals whose parent-node is not there
  std::string firstWrongJoin_;
  std::size_t gaps_ = 0;  // laterals that begin away from their parents
  std::string firstGap_;
  std::vector<ReadAxis> axes_;     // parents come first
  std::vector<std::size_t> open_;  // axes whose elements are open
  std::string function_;           // name of the last function
  std::string text_;               // between the last two tags
  std::string unit_;
  std::size_t pointCount_ = 0;
  std::uint64_t looks_ = 0;
  bool hasScene_ = false;
  bool definesProperties_ = false;  // inside of property-definitions
  bool hasValue_ = false;           // the open sample has its value as an attribute
};

}  // namespace

tl::expected<RootSystem, std::string> readRsml(std::string_view text) {
  return Reader().read(text);
}

}  // namespace espalier::roots
