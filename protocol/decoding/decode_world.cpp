#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "protocol/codec.h"
#include "protocol/decoding/decode_payload.h"
#include "protocol/decoding/forest_members.h"

namespace espalier::protocol {
namespace {

struct TimeUnit {
  std::string_view name;
  double parts;  // of a day
};
// a duration is a number divided by the parts, so that 1 h is the double nearest to 1/24
constexpr std::array<TimeUnit, 9> kTimeUnits{{{"s", 86400.0},
                                              {"min", 1440.0},
                                              {"h", 24.0},
                                              {"hour", 24.0},
                                              {"hours", 24.0},
                                              {"d", 1.0},
                                              {"day", 1.0},
                                              {"days", 1.0},
                                              {"week", 1.0 / 7.0}}};

double readDuration(const Member& member) {
  if (!member.isText()) {
    return member.number();
  }
  const auto days = daysOfDuration(member.text());
  if (!days) {
    member.failExpected("a number of days, or a text such as \"1 h\", \"0.25 d\" or \"30 min\"");
  }
  return *days;
}

void readDegrees(const Member& member, double most, std::optional<double>& degrees) {
  if (member.isAbsent()) {
    return;
  }
  degrees = member.number();
  if (!(std::abs(*degrees) <= most)) {
    const std::string bound = std::to_string(static_cast<int>(most));
    member.failExpected("degrees from -" + bound + " to " + bound);
  }
}

/// The vector of an axis that was given by its letter, such as "z"; else the example.
std::string exampleFor(std::string_view letter, std::string_view example) {
  const bool isSigned = letter.starts_with('-') || letter.starts_with('+');
  const std::string one = letter.starts_with('-') ? "-1" : "1";
  const std::string_view axis = letter.substr(isSigned ? 1 : 0);
  return axis == "x" || axis == "X"   ? "[" + one + ", 0, 0]"
         : axis == "y" || axis == "Y" ? "[0, " + one + ", 0]"
         : axis == "z" || axis == "Z" ? "[0, 0, " + one + "]"
                                      : std::string(example);
}

/// A direction; nothing is changed when it is absent. `example` is one, for messages.
void readDirection(const Member& member, std::string_view example, std::array<double, 3>& direction) {
  if (member.isAbsent()) {
    return;
  }
  if (!member.isArray() || member.arraySize() != 3) {
    member.failExpected("three numbers such as " +
                        (member.isText() ? exampleFor(member.text(), example) : std::string(example)));
  }
  direction = readVector(member);
  if (direction[0] == 0.0 && direction[1] == 0.0 && direction[2] == 0.0) {
    member.fail("a vector of length 0 has no direction; give a vector such as " + std::string(example));
  }
}

}  // namespace

std::optional<double> daysOfDuration(std::string_view text) {
  double number = 0.0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (problem != std::errc() || !std::isfinite(number)) {
    return std::nullopt;
  }
  std::string_view unit = text.substr(static_cast<std::size_t>(end - text.data()));
  unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
  if (unit.empty()) {
    return number;
  }
  for (const TimeUnit& known : kTimeUnits) {
    if (known.name == unit) {
      return number / known.parts;
    }
  }
  return std::nullopt;
}

WorldRecord readWorld(const Member& member) {
  member.requireObject();
  WorldRecord world;
  if (const Member unit = member["lengthUnit"]; !unit.isAbsent()) {
    world.lengthUnit = unit.text();
  }
  readDirection(member["up"], "[0, 1, 0]", world.up);
  readDirection(member["north"], "[0, 0, -1]", world.north);
  if (const Member duration = member["stepDuration"]; !duration.isAbsent()) {
    world.stepDurationDays = readDuration(duration);
    if (!(world.stepDurationDays > 0.0)) {
      duration.failExpected("a duration above 0");
    }
  }
  readDegrees(member["latitude"], 90.0, world.latitudeDegrees);
  readDegrees(member["longitude"], 360.0, world.longitudeDegrees);
  world.start = member["start"].textOrEmpty();
  if (const Member base = member["baseTemperature"]; !base.isAbsent()) {
    world.baseTemperature = base.number();
  }
  world.weather = member["weather"].textOrEmpty();
  return world;
}

WorldRecord readOwnWorld(const Member& member) {
  static constexpr std::array<std::string_view, 9> kKnown{
      "lengthUnit", "up", "north", "stepDuration", "latitude", "longitude", "start", "baseTemperature", "weather"};
  static constexpr std::array<std::string_view, 5> kUnits{"m", "dm", "cm", "mm", "1"};
  requireKnown(member, kKnown);
  WorldRecord world = readWorld(member);
  if (std::find(kUnits.begin(), kUnits.end(), world.lengthUnit) == kUnits.end()) {
    member["lengthUnit"].failExpected("m, dm, cm, mm, or 1 for lengths without a unit");
  }
  return world;
}

Expected<WorldRecord> decodeWorld(const Payload& payload) {
  return decodePayload<WorldRecord>(payload,
                                    [](const Member& params, WorldRecord& world) { world = readOwnWorld(params); });
}

}  // namespace espalier::protocol
