#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>

#include "engine/language/view/view_commands.h"

namespace espalier::language {
namespace {

using Context = ViewCommandContext;

constexpr int kLeastContourSides = 3;
constexpr int kMostContourSides = 1000;

template <double files::ViewSettings::*Member>
bool setNumber(Context& c) {
  const std::optional<double> value = c.lexer.number();
  if (value) {
    c.settings().*Member = *value;
  }
  return value.has_value();
}

/// A factor; 0 would hide the whole plant and becomes 1.
template <double files::ViewSettings::*Member>
bool setFactor(Context& c) {
  const std::optional<double> value = c.lexer.number();
  if (!value) {
    return false;
  }
  if (*value == 0.0) {
    c.warn("a scale of 0 is taken as 1");
  }
  c.settings().*Member = *value == 0.0 ? 1.0 : *value;
  return true;
}

bool initialHeading(Context& c) {
  const std::optional<core::Vec3> direction = c.lexer.triple();
  if (!direction) {
    return false;
  }
  if (!(core::length(*direction) > 0.0)) {
    c.warn("the initial heading has no length and is ignored");
    return true;
  }
  c.settings().initialHeading = core::normalised(*direction);
  return true;
}

/// `color map entry: 3 255,128,0`; entry 0 is the background.
bool colourMapEntry(Context& c) {
  const std::optional<int> index = c.lexer.integer();
  const std::optional<core::Vec3> colour = index ? c.lexer.triple() : std::nullopt;
  if (!colour) {
    return false;
  }
  const auto isByte = [](double value) { return value >= 0.0 && value <= 255.0; };
  if (*index < 0 || *index >= files::Palette::kBlockSize || !isByte(colour->x) || !isByte(colour->y) ||
      !isByte(colour->z)) {
    c.warn("a color map has entries 0 to 255 with red, green and blue from 0 to 255; this one is ignored");
    return true;
  }
  c.settings().colourEntries[*index] = {static_cast<std::uint8_t>(std::lround(colour->x)),
                                        static_cast<std::uint8_t>(std::lround(colour->y)),
                                        static_cast<std::uint8_t>(std::lround(colour->z))};
  return true;
}

std::optional<bool> readFlag(Context& c, bool isPresent) {
  const std::optional<std::string_view> word = c.lexer.word();
  if (!word) {
    return std::nullopt;
  }
  if (*word == "on" || *word == "off") {
    return *word == "on";
  }
  c.warn("expected 'on' or 'off', found '" + std::string(word->substr(0, 40)) + "'; it stays " +
         (isPresent ? "on" : "off"));
  return isPresent;
}

template <bool files::ViewSettings::*Member>
bool setFlag(Context& c) {
  const std::optional<bool> flag = readFlag(c, c.settings().*Member);
  if (flag) {
    c.settings().*Member = *flag;
  }
  return flag.has_value();
}

template <core::Vec3 files::ViewSettings::*Member>
bool setTriple(Context& c) {
  const std::optional<core::Vec3> value = c.lexer.triple();
  if (value) {
    c.settings().*Member = *value;
  }
  return value.has_value();
}

bool angleFactor(Context& c) {
  const std::optional<double> value = c.lexer.number();
  if (!value) {
    return false;
  }
  const double degrees = 360.0 / *value;
  if (!std::isfinite(degrees)) {
    c.warn("an angle factor of 0 is ignored", "the angle increment becomes 360 / factor");
    return true;
  }
  c.settings().angleIncrementDegrees = degrees;
  return true;
}

bool initialLineWidth(Context& c) {
  const std::optional<double> value = c.lexer.number();
  if (!value) {
    return false;
  }
  c.settings().initialLineWidth = *value;
  c.settings().isLineStyleGiven = true;
  // the unit also chooses the line style
  const std::string_view unit = c.lexer.optionalUnit();
  c.settings().lineStyle = unit.starts_with('p')   ? files::LineStyle::Pixel
                           : unit.starts_with('s') ? files::LineStyle::Cylinder
                                                   : files::LineStyle::Polygon;
  return true;
}

bool initialColour(Context& c) {
  const std::optional<int> front = c.lexer.integer();
  if (!front) {
    return false;
  }
  c.settings().initialColour = *front;
  if (const std::optional<int> back = c.lexer.optionalInteger()) {
    c.settings().initialBackColour = *back;
    c.settings().hasTwoSidedColour = true;
  }
  return true;
}

bool colourIncrement(Context& c) {
  const std::optional<int> front = c.lexer.integer();
  if (!front) {
    return false;
  }
  c.settings().colourIncrement = *front;
  c.settings().backColourIncrement = c.lexer.optionalInteger().value_or(c.settings().backColourIncrement);
  return true;
}

bool lineStyle(Context& c) {
  const std::optional<std::string_view> word = c.lexer.word();
  if (!word) {
    return false;
  }
  c.settings().isLineStyleGiven = true;
  if (*word == "pixel" || *word == "1") {
    c.settings().lineStyle = files::LineStyle::Pixel;
  } else if (*word == "polygon" || *word == "2") {
    c.settings().lineStyle = files::LineStyle::Polygon;
  } else if (*word == "cylinder" || *word == "3") {
    c.settings().lineStyle = files::LineStyle::Cylinder;
  } else if (*word != "wireframe") {
    // `wireframe` occurs in many published files and has no effect
    c.warn("unknown line style '" + std::string(word->substr(0, 40)) + "'; the style stays as it is",
           core::suggestName(*word, {"pixel", "polygon", "cylinder"}));
  }
  return true;
}

void setContourSides(Context& c, int sides) {
  if (sides > kMostContourSides) {
    c.warn("more than " + std::to_string(kMostContourSides) + " contour sides; " + std::to_string(kMostContourSides) +
           " are used");
  }
  c.settings().contourSides = std::clamp(sides, kLeastContourSides, kMostContourSides);
}

bool contourSides(Context& c) {
  const std::optional<int> sides = c.lexer.integer();
  if (sides) {
    setContourSides(c, *sides);
  }
  return sides.has_value();
}

bool polygonizationLevel(Context& c) {
  const std::optional<int> level = c.lexer.integer();
  if (level) {
    setContourSides(c, 1 << (std::clamp(*level, 0, 20) + 1));
  }
  return level.has_value();
}

bool tropism(Context& c) {
  readMovement(c, files::Movement::Kind::Tropism);
  return true;
}

bool torque(Context& c) {
  readMovement(c, files::Movement::Kind::Torque);
  return true;
}

bool tropismDirection(Context& c) {
  const std::optional<core::Vec3> direction = c.lexer.triple();
  if (!direction) {
    return false;
  }
  if (!(core::length(*direction) > 0.0)) {
    c.warn("the tropism direction has no length and is ignored");
    return true;
  }
  c.settings().oldTropism.direction = core::normalised(*direction);
  c.settings().oldTropism.isActive = true;
  return true;
}

template <double files::OldTropism::*Member>
bool setOldTropism(Context& c) {
  const std::optional<double> value = c.lexer.number();
  if (value) {
    c.settings().oldTropism.*Member = *value;
    c.settings().oldTropism.isActive = true;
  }
  return value.has_value();
}

bool interpretationPastCut(Context& c) {
  const std::optional<std::string_view> word = c.lexer.word();
  if (word) {
    c.settings().interpretsPastCut = !word->starts_with("off");
  }
  return word.has_value();
}

bool environmentDisplay(Context& c) {
  const std::optional<std::string_view> word = c.lexer.word();
  if (word) {
    c.settings().hasEnvironmentDisplayBefore = *word == "before";
  }
  return word.has_value();
}

bool projection(Context& c) {
  const std::optional<std::string_view> word = c.lexer.word();
  if (!word) {
    return false;
  }
  constexpr std::string_view kParallel = "parallel";
  constexpr std::string_view kPerspective = "perspective";
  const bool isParallel = kParallel.starts_with(*word) || word->starts_with(kParallel);
  const bool isPerspective = !isParallel && (kPerspective.starts_with(*word) || word->starts_with(kPerspective));
  if (!isParallel && !isPerspective) {
    c.warn("unknown projection '" + std::string(word->substr(0, 40)) + "'; parallel is used",
           core::suggestName(*word, {kParallel, kPerspective}));
  }
  c.settings().isPerspective = isPerspective;
  return true;
}

bool twist(Context& c) {
  const std::optional<int> tenths = c.lexer.integer();
  if (tenths) {
    c.settings().twistDegrees = *tenths / 10.0;
  }
  return tenths.has_value();
}

/// `box: x: a,b y: a,b z: a,b` on one line.
bool box(Context& c) {
  const core::SourceRange range = c.lexer.commandRange();
  files::TextCursor line = c.lexer.line();
  std::array<double, 6> bounds{};
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    line.skipBlanks();
    if (i % 2 == 0) {
      const char axis = "xyz"[i / 2];
      if (!line.take(axis) || (line.skipBlanks(), !line.take(':'))) {
        c.report.warn(range, std::string("the box is ignored: expected '") + axis + ":', found " + line.found(),
                      "write it as 'box: x: -1,1 y: 0,2 z: -1,1'");
        return true;
      }
      line.skipBlanks();
    }
    const std::optional<double> number = line.number();
    if (!number || (i % 2 == 0 && !line.take(','))) {
      c.report.warn(range,
                    "the box is ignored: expected a number" + std::string(i % 2 == 0 ? " and a comma" : "") +
                        ", found " + line.found(),
                    "write it as 'box: x: -1,1 y: 0,2 z: -1,1'");
      return true;
    }
    bounds[i] = *number;
  }
  c.settings().box = files::Box{{bounds[0], bounds[2], bounds[4]}, {bounds[1], bounds[3], bounds[5]}};
  return true;
}

constexpr std::array<std::string_view, 7> kRenderModes{"wireframe", "filled", "flat",   "interpolated",
                                                       "shaded",    "fast",   "shadows"};

bool renderMode(Context& c) {
  const std::optional<std::string_view> word = c.lexer.word();
  if (!word) {
    return false;
  }
  for (std::size_t i = 0; i < kRenderModes.size(); ++i) {
    if (*word == kRenderModes[i] || *word == std::to_string(i + 1)) {
      c.settings().renderMode = static_cast<files::RenderMode>(i);
      return true;
    }
  }
  c.warn("unknown render mode '" + std::string(word->substr(0, 40)) + "'; the command is ignored",
         core::suggestName(*word, {kRenderModes.begin(), kRenderModes.end()}));
  return true;
}

/// The older form, by number.
bool shadeMode(Context& c) {
  const std::optional<int> mode = c.lexer.integer();
  if (mode) {
    const bool isWireframe = *mode == 4 || *mode == 5 || *mode == 7;
    c.settings().renderMode = *mode == 2                 ? files::RenderMode::Interpolated
                              : *mode == 3 || *mode == 6 ? files::RenderMode::Shaded
                              : isWireframe              ? files::RenderMode::Wireframe
                                                         : files::RenderMode::Filled;
  }
  return mode.has_value();
}

bool light(Context& c) {
  readLight(c);
  return true;
}

bool lightDirection(Context& c) {
  const std::optional<core::Vec3> direction = c.lexer.triple();
  if (!direction) {
    return false;
  }
  if (!(core::length(*direction) > 0.0)) {
    c.warn("the light direction has no length and is ignored");
    return true;
  }
  c.settings().lightDirection = core::normalised(*direction);
  return true;
}

bool lineCap(Context& c) {
  const std::optional<int> cap = c.lexer.integer();
  if (cap && *cap >= 0 && *cap <= 2) {
    c.settings().postScriptLineCap = *cap;
  } else if (cap) {
    c.warn("a line cap is 0 (butt), 1 (round) or 2 (square); it stays " +
           std::to_string(c.settings().postScriptLineCap));
  }
  return cap.has_value();
}

// commands for pictures of other programs: the arguments are read to find the next command on the same line

bool passNumber(Context& c) {
  return c.lexer.number().has_value();
}
bool passWord(Context& c) {
  return c.lexer.word().has_value();
}
bool passTriple(Context& c) {
  return c.lexer.triple().has_value();
}
bool passFlag(Context& c) {
  return readFlag(c, true).has_value();
}
bool passLine(Context& c) {
  c.lexer.skipLine();
  return true;
}
bool rayshadeObjects(Context& c) {
  c.report.note(c.lexer.commandRange(), "the objects are not used: no scene for Rayshade is written");
  return passLine(c);
}

constexpr std::array kValueCommands = {
    ViewCommand{"angle increment:", setNumber<&files::ViewSettings::angleIncrementDegrees>},
    ViewCommand{"angle factor:", angleFactor},
    ViewCommand{"initial line width:", initialLineWidth},
    ViewCommand{"line width increment:", setNumber<&files::ViewSettings::lineWidthIncrement>},
    ViewCommand{"initial color:", initialColour},
    ViewCommand{"color increment:", colourIncrement},
    ViewCommand{"initial scale:", setFactor<&files::ViewSettings::initialScale>},
    ViewCommand{"initial position:", setTriple<&files::ViewSettings::initialPosition>},
    ViewCommand{"initial heading:", initialHeading},
    ViewCommand{"displacement:", setTriple<&files::ViewSettings::displacement>},
    ViewCommand{"color map entry:", colourMapEntry},
    ViewCommand{"scale multiplier:", setFactor<&files::ViewSettings::scaleMultiplier>},
    ViewCommand{"line style:", lineStyle},
    ViewCommand{"tapered lines:", setFlag<&files::ViewSettings::hasTaperedLines>},
    ViewCommand{"contour sides:", contourSides},
    ViewCommand{"polygonization level:", polygonizationLevel},
    ViewCommand{"twist of cylinders:", setFlag<&files::ViewSettings::hasTwistOfCylinders>},
    ViewCommand{"tropism:", tropism},
    ViewCommand{"torque:", torque},
    ViewCommand{"tropism direction:", tropismDirection},
    ViewCommand{"initial elasticity:", setOldTropism<&files::OldTropism::initialElasticity>},
    ViewCommand{"elasticity increment:", setOldTropism<&files::OldTropism::elasticityIncrement>},
    ViewCommand{"interpretation past %:", interpretationPastCut},
    ViewCommand{"environment display:", environmentDisplay},
    ViewCommand{"interpretation step:", passNumber},
    ViewCommand{"generate on view change:", passWord},
    ViewCommand{"projection:", projection},
    ViewCommand{"viewpoint:", setTriple<&files::ViewSettings::viewpoint>},
    ViewCommand{"view reference point:", setTriple<&files::ViewSettings::viewReferencePoint>},
    ViewCommand{"twist:", twist},
    ViewCommand{"viewing angle:", setNumber<&files::ViewSettings::viewingAngleDegrees>},
    ViewCommand{"front distance:", passNumber},
    ViewCommand{"back distance:", passNumber},
    ViewCommand{"scale factor:", setFactor<&files::ViewSettings::scaleFactor>},
    ViewCommand{"box:", box},
    ViewCommand{"min zoom:", passNumber},
    ViewCommand{"max zoom:", passNumber},
    ViewCommand{"render mode:", renderMode},
    ViewCommand{"shade mode:", shadeMode},
    ViewCommand{"z buffer:", passFlag},
    ViewCommand{"antialiasing:", passFlag},
    ViewCommand{"concave polygons:", passFlag},
    ViewCommand{"cue range:", passNumber},
    ViewCommand{"light:", light},
    ViewCommand{"light direction:", lightDirection},
    ViewCommand{"diffuse reflection:", passNumber},
    ViewCommand{"surface ambient:", passNumber},
    ViewCommand{"surface diffuse:", passNumber},
    ViewCommand{"shadow map:", passLine},
    ViewCommand{"font:", passLine},
    ViewCommand{"winfont:", passLine},
    ViewCommand{"PS linecap:", lineCap},
    ViewCommand{"rayshade objects:", rayshadeObjects},
    ViewCommand{"rayshade scale:", passNumber},
    ViewCommand{"background color:", passTriple},
    ViewCommand{"ambient light:", passTriple},
};

}  // namespace

std::span<const ViewCommand> valueCommands() {
  return kValueCommands;
}

}  // namespace espalier::language
