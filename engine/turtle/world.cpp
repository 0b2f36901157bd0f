#include "engine/turtle/world.h"

#include <charconv>
#include <cmath>

#include "engine/turtle/weather.h"

namespace espalier::turtle {

namespace {

/// A whole number of a fixed number of digits at the front of a text, which is removed.
std::optional<int> takeNumber(std::string_view& text, std::size_t digits) {
  int value = 0;
  if (text.size() < digits) {
    return std::nullopt;
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + digits, value);
  if (error != std::errc() || end != text.data() + digits || text.front() == '-') {
    return std::nullopt;
  }
  text.remove_prefix(digits);
  return value;
}

bool takeCharacter(std::string_view& text, char character) {
  if (text.empty() || text.front() != character) {
    return false;
  }
  text.remove_prefix(1);
  return true;
}

/// Meeus, Astronomical Algorithms (1998), chapter 7.
double julianDay(int year, int month, double day) {
  if (month <= 2) {
    year -= 1;
    month += 12;
  }
  const double century = std::floor(year / 100.0);
  return std::floor(365.25 * (year + 4716)) + std::floor(30.6001 * (month + 1)) + day + 2.0 - century +
         std::floor(century / 4.0) - 1524.5;
}

/// The hours of "12:30:15" at the front of a text, which is removed.
std::optional<double> takeTime(std::string_view& text) {
  const auto hour = takeNumber(text, 2);
  const auto minute = hour && takeCharacter(text, ':') ? takeNumber(text, 2) : std::nullopt;
  if (!minute || *hour > 24 || *minute > 59) {
    return std::nullopt;
  }
  double hours = *hour + *minute / 60.0;
  if (takeCharacter(text, ':')) {
    const auto second = takeNumber(text, 2);
    if (!second || *second > 60) {
      return std::nullopt;
    }
    hours += *second / 3600.0;
  }
  return hours;
}

/// The hours by which "Z", "+02:00" or nothing is ahead of universal time.
std::optional<double> takeOffset(std::string_view& text) {
  if (text.empty() || takeCharacter(text, 'Z')) {
    return 0.0;
  }
  const double sign = text.front() == '-' ? -1.0 : 1.0;
  if (!takeCharacter(text, '+') && !takeCharacter(text, '-')) {
    return std::nullopt;
  }
  const auto hour = takeNumber(text, 2);
  const auto minute = hour && takeCharacter(text, ':') ? takeNumber(text, 2) : std::nullopt;
  if (!minute || *hour > 15 || *minute > 59) {
    return std::nullopt;
  }
  return sign * (*hour + *minute / 60.0);
}

}  // namespace

std::optional<double> julianDayOf(std::string_view text) {
  const auto year = takeNumber(text, 4);
  const auto month = year && takeCharacter(text, '-') ? takeNumber(text, 2) : std::nullopt;
  const auto day = month && takeCharacter(text, '-') ? takeNumber(text, 2) : std::nullopt;
  if (!day || *year < 1 || *month < 1 || *month > 12 || *day < 1) {
    return std::nullopt;
  }
  const bool isLast = *month == 12;
  if (!(julianDay(*year, *month, *day) < julianDay(isLast ? *year + 1 : *year, isLast ? 1 : *month + 1, 1))) {
    return std::nullopt;  // no day of that month
  }
  double hours = 0.0;
  if (takeCharacter(text, 'T') || takeCharacter(text, ' ')) {
    const auto time = takeTime(text);
    const auto offset = time ? takeOffset(text) : std::nullopt;
    if (!offset) {
      return std::nullopt;
    }
    hours = *time - *offset;
  }
  if (!text.empty()) {
    return std::nullopt;
  }
  return julianDay(*year, *month, *day + hours / 24.0);
}

bool World::operator==(const World& other) const {
  const auto tableOf = [](const World& world) { return world.weather ? world.weather->table() : std::string_view(); };
  return lengthUnit == other.lengthUnit && up == other.up && north == other.north &&
         stepDurationDays == other.stepDurationDays && latitudeDegrees == other.latitudeDegrees &&
         longitudeDegrees == other.longitudeDegrees && start == other.start &&
         baseTemperature == other.baseTemperature && tableOf(*this) == tableOf(other);
}

std::optional<std::string> problemOfWorld(const World& world) {
  const auto isFinite = [](const core::Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
  };
  if (!isFinite(world.up) || !(core::length(world.up) > 0.0)) {
    return "'up' has no direction; give a vector such as [0, 1, 0]";
  }
  if (!isFinite(world.north) || !(core::length(core::cross(core::normalised(world.up), world.north)) > 0.0)) {
    return "'north' is along 'up' or has no direction; give a horizontal vector such as [0, 0, -1]";
  }
  if (!(world.stepDurationDays > 0.0) || !std::isfinite(world.stepDurationDays)) {
    return "'stepDuration' must be greater than 0; give a number of days, or a text such as \"1 h\"";
  }
  if (world.latitudeDegrees && !(std::abs(*world.latitudeDegrees) <= 90.0)) {
    return "'latitude' must lie between -90 and 90 degrees, north positive";
  }
  if (world.longitudeDegrees && !(std::abs(*world.longitudeDegrees) <= 360.0)) {
    return "'longitude' must lie between -360 and 360 degrees, east positive";
  }
  if (!world.start.empty() && !julianDayOf(world.start)) {
    return "'start' is no date: '" + world.start + "'; write for example 2026-06-21T06:00+02:00";
  }
  if (!std::isfinite(world.baseTemperature)) {
    return "'baseTemperature' must be a number of degrees Celsius";
  }
  return std::nullopt;
}

}  // namespace espalier::turtle
