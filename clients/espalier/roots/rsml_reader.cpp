#include <expat.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <memory>
#include <optional>

#include "clients/espalier/roots/root_system.h"
#include "clients/espalier/roots/rsml_axes.h"
#include "clients/espalier/roots/rsml_functions.h"

namespace espalier::roots {

namespace {

constexpr std::size_t kMostOrders = 1000;
constexpr std::size_t kLongestName = 1000;  // of a root or plant
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

/// Elements whose place in the file counts.
enum class Element : unsigned char { Other, Rsml, Metadata, Root, Geometry, Polyline, Functions, Function };
constexpr std::pair<std::string_view, Element> kElements[] = {
    {"rsml", Element::Rsml},         {"metadata", Element::Metadata}, {"root", Element::Root},
    {"geometry", Element::Geometry}, {"polyline", Element::Polyline}, {"functions", Element::Functions},
    {"function", Element::Function}};

/// The name of an element without the prefix of its namespace. Published files number functions: `function1`.
std::string_view localName(std::string_view name) {
  constexpr std::string_view kFunction = "function";
  name = name.substr(name.find(':') + 1);
  const bool isNumbered =
      name.starts_with(kFunction) && name.find_first_not_of("0123456789", kFunction.size()) == std::string_view::npos;
  return isNumbered ? kFunction : name;
}

class Reader {
 public:
  explicit Reader(std::size_t mostPoints) : mostPoints_(mostPoints) {}

  tl::expected<RootSystem, std::string> read(std::string_view text) {
    const std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> parser(XML_ParserCreate(nullptr),
                                                                              XML_ParserFree);
    parser_ = parser.get();
    XML_SetUserData(parser_, this);
    XML_SetElementHandler(
        parser_,
        [](void* self, const char* name, const char** attributes) {
          static_cast<Reader*>(self)->begin(localName(name), attributes);
        },
        [](void* self, const char* name) { static_cast<Reader*>(self)->end(localName(name)); });
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
    auto joined = joinAxes(std::move(axes_), unit_);
    if (joined) {
      joined->plants = std::move(plants_);
    }
    return joined;
  }

 private:
  /// Keeps the first problem and ends the reading.
  void failAt(std::size_t line, const std::string& sentence) {
    if (problem_.empty()) {
      problem_ = "line " + std::to_string(line) + ": " + sentence;
      XML_StopParser(parser_, XML_FALSE);
    }
  }
  void fail(const std::string& sentence) { failAt(XML_GetCurrentLineNumber(parser_), sentence); }
  /// Whether the elements around the one that begins or ends are these, the innermost last.
  [[nodiscard]] bool isInside(std::initializer_list<Element> elements) const {
    return path_.size() >= elements.size() &&
           std::equal(elements.begin(), elements.end(), path_.end() - std::ssize(elements));
  }
  [[nodiscard]] std::optional<double> numberIn(std::string_view field) {
    const std::size_t from = field.find_first_not_of(" \t\r\n");
    const std::size_t until = field.find_last_not_of(" \t\r\n");
    field = from == std::string_view::npos ? std::string_view() : field.substr(from, until - from + 1);
    double value = 0.0;
    const auto [at, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error != std::errc() || at != field.data() + field.size() || !std::isfinite(value)) {
      fail("expected a number, found '" + std::string(field.substr(0, 40)) +
           "'. Write a number there, with a decimal point");
      return std::nullopt;
    }
    return value;
  }
  /// Without blanks.
  [[nodiscard]] static std::string inSmallLetters(std::string_view text) {
    std::string small;
    for (const char letter : text) {
      if (std::isspace(static_cast<unsigned char>(letter)) == 0) {
        small += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
      }
    }
    return small;
  }
  [[nodiscard]] std::optional<double> numberOf(const char** attributes, std::string_view name) {
    const auto field = attributeOf(attributes, name);
    return field ? numberIn(*field) : std::nullopt;
  }
  [[nodiscard]] static std::optional<std::string_view> attributeOf(const char** attributes, std::string_view name) {
    for (; *attributes != nullptr; attributes += 2) {
      if (name == *attributes) {
        return attributes[1];
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] static std::string nameOf(const char** attributes, std::string_view attribute) {
    std::string_view name = attributeOf(attributes, attribute).value_or("");
    if (name.size() > kLongestName) {
      std::size_t end = kLongestName;
      while ((static_cast<unsigned char>(name[end]) & 0xC0U) == 0x80U) {
        --end;  // not within a character
      }
      name = name.substr(0, end);
    }
    return std::string(name);
  }

  void begin(std::string_view name, const char** attributes) {
    text_.clear();
    if (name == "scene") {
      hasScene_ = true;
    } else if (name == "plant" && open_.empty()) {
      plants_.push_back({.id = nameOf(attributes, "ID"), .label = nameOf(attributes, "label")});
    } else if (name == "root") {
      beginRoot(attributes);
    } else if (name == "point" && isInside({Element::Root, Element::Geometry, Element::Polyline})) {
      addPoint(attributes);
    } else if (name == "function" && isInside({Element::Root, Element::Functions})) {
      beginFunction(attributes);
    } else if (name == "sample" && isInside({Element::Root, Element::Functions, Element::Function})) {
      position_ = isRead_ ? numberOf(attributes, "position") : std::nullopt;
      const auto value = attributeOf(attributes, "value");
      hasValue_ = value.has_value();
      if (value) {
        addSample(*value);
      }
    } else if (name == "parent-node" && !open_.empty()) {
      if (const auto value = numberOf(attributes, "value")) {
        axes_[open_.back()].parentNode = value;
      }
    }
    const auto* const known = std::ranges::find(kElements, name, &std::pair<std::string_view, Element>::first);
    path_.push_back(known == std::end(kElements) ? Element::Other : known->second);
  }

  void end(std::string_view name) {
    path_.pop_back();
    if (name == "root") {
      evaluateFunctions(axes_[open_.back()]);
      open_.pop_back();
    } else if (name == "function" && isInside({Element::Root, Element::Functions})) {
      if (!function_.samples.empty()) {
        axes_[open_.back()].functions.push_back(std::move(function_));
      }
    } else if (name == "sample" && isInside({Element::Root, Element::Functions, Element::Function}) && !hasValue_) {
      addSample(text_);
    } else if (name == "parent-node" && !open_.empty() && !axes_[open_.back()].parentNode && !text_.empty()) {
      axes_[open_.back()].parentNode = numberIn(text_);
    } else if (isInside({Element::Metadata}) || isInside({Element::Rsml})) {
      // elsewhere both belong to a property, or to a picture
      if (name == "unit") {
        setUnit();
      } else if (name == "resolution") {
        if (const auto resolution = numberIn(text_); resolution && *resolution <= 0.0) {
          fail("the resolution is not above 0. Write the number of pixels in a unit, or leave it out");
        }
      }
    }
    text_.clear();
  }

  void beginRoot(const char** attributes) {
    RsmlAxis axis;
    axis.line = XML_GetCurrentLineNumber(parser_);
    axis.id = nameOf(attributes, "ID");
    axis.label = nameOf(attributes, "label");
    if (plants_.empty()) {
      plants_.emplace_back();
    }
    axis.plant = static_cast<std::uint32_t>(plants_.size() - 1);
    axis.parent = open_.empty() ? std::string::npos : open_.back();
    axis.order = static_cast<std::uint32_t>(open_.size() + 1);
    if (open_.size() >= kMostOrders) {
      fail("roots stand inside each other more than " + std::to_string(kMostOrders) +
           " deep. Give a file with fewer orders");
    }
    open_.push_back(axes_.size());
    axes_.push_back(std::move(axis));
  }

  void beginFunction(const char** attributes) {
    function_ = RsmlFunction();
    function_.name = attributeOf(attributes, "name").value_or("");
    function_.domain = inSmallLetters(attributeOf(attributes, "domain").value_or(""));
    function_.line = XML_GetCurrentLineNumber(parser_);
    isRead_ = function_.name == "diameter" || isEmergence(function_);
    if (isRead_) {
      function_.origin = numberOf(attributes, "origin");
      function_.step = numberOf(attributes, "step");
    }
  }

  [[nodiscard]] static bool isEmergence(const RsmlFunction& function) {
    return function.name == "emergence_time" || function.name == "node_creation_time";
  }

  /// The first function of a kind counts.
  void evaluateFunctions(RsmlAxis& axis) {
    for (const RsmlFunction& function : axis.functions) {
      std::vector<double>& target = isEmergence(function) ? axis.emergences : axis.diameters;
      if (axis.points.empty() || !target.empty()) {
        continue;
      }
      auto values = valuesAt(function, axis.points, std::string_view(axis.id).substr(0, 40));
      if (!values) {
        failAt(function.line, values.error());
        return;
      }
      target = std::move(*values);
    }
    axis.functions = {};
  }

  void letters(std::string_view some) {
    if (text_.size() < 1000) {
      text_ += some;
    }
  }

  /// The unit of all lengths; a property has its own.
  void setUnit() {
    const std::string name = inSmallLetters(text_);
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
    if (++pointCount_ > mostPoints_) {
      fail("the file has more than " + std::to_string(mostPoints_) +
           (mostPoints_ < kMostPoints
                ? " points, which is as many as can be drawn: 'espalier traits' measures more, and "
                  "--limit sourceBytes=N lets more be drawn (50 bytes a point)"
                : " points. Give a smaller file"));
      return;
    }
    axes_[open_.back()].points.push_back(place);
  }

  void addSample(std::string_view field) {
    if (!isRead_) {
      return;
    }
    const auto value = numberIn(field);
    if (value && function_.name == "diameter" && *value < 0.0) {
      fail("a diameter is below 0. Correct the number");
    }
    if (++sampleCount_ > 2 * kMostPoints) {
      fail("the file has more than " + std::to_string(2 * kMostPoints) + " samples. Give a smaller file");
    }
    function_.samples.push_back({.value = value.value_or(0.0), .position = position_});
  }

  XML_Parser parser_ = nullptr;
  std::string problem_;
  std::size_t mostPoints_;
  std::vector<turtle::RsmlLabels::Plant> plants_;
  std::vector<RsmlAxis> axes_;      // parents come first
  std::vector<std::size_t> open_;   // axes whose elements are open
  std::vector<Element> path_;       // elements that are open
  RsmlFunction function_;           // that is open
  bool isRead_ = false;             // the open function is one of those that are read
  std::optional<double> position_;  // of the open sample
  std::string text_;                // between the last two tags
  std::string unit_;
  std::size_t pointCount_ = 0;
  std::size_t sampleCount_ = 0;
  bool hasScene_ = false;
  bool hasValue_ = false;  // the open sample has its value as an attribute
};

}  // namespace

tl::expected<RootSystem, std::string> readRsml(std::string_view text, std::size_t mostPoints) {
  return Reader(mostPoints).read(text);
}

}  // namespace espalier::roots
