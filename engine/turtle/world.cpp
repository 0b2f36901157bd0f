#include "engine/turtle/world.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "engine/turtle/weather.h"

namespace espalier::turtle {

namespace {

constexpr int kSecondsPerDay = 86400;
constexpr double kMostStepDays = 1e6;              // 2738 years: what is longer has no seasons, no sun and no weather
constexpr double kMostWhole = 9007199254740992.0;  // 2^53: up to here all whole numbers are doubles

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

/// The Julian day at noon of a date, a whole number. Meeus, Astronomical Algorithms (1998), chapter 7.
std::int64_t julianNoon(int year, int month, int day) {
  if (month <= 2) {
    year -= 1;
    month += 12;
  }
  const int century = year / 100;
  return static_cast<std::int64_t>(std::floor(365.25 * (year + 4716))) +
         static_cast<std::int64_t>(std::floor(30.6001 * (month + 1))) + day + 2 - century + century / 4 - 1524;
}

/// The seconds of "12:30:15" or "12:30:15.25" at the front of a text, which is removed.
std::optional<int> takeTime(std::string_view& text) {
  const auto hour = takeNumber(text, 2);
  const auto minute = hour && takeCharacter(text, ':') ? takeNumber(text, 2) : std::nullopt;
  if (!minute || *hour > 24 || *minute > 59) {
    return std::nullopt;
  }
  int seconds = 3600 * *hour + 60 * *minute;
  if (takeCharacter(text, ':')) {
    const auto second = takeNumber(text, 2);
    if (!second || *second > 60) {
      return std::nullopt;
    }
    seconds += *second;
    // a fraction is left out
    if (takeCharacter(text, '.')) {
      const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
      if (digits == 0) {
        return std::nullopt;
      }
      text.remove_prefix(digits);
    }
  }
  return *hour < 24 || seconds == kSecondsPerDay ? std::optional(seconds) : std::nullopt;
}

/// The seconds by which "Z", "+02:00" or nothing is ahead of universal time.
std::optional<int> takeOffset(std::string_view& text) {
  if (text.empty() || takeCharacter(text, 'Z')) {
    return 0;
  }
  const int sign = text.front() == '-' ? -1 : 1;
  if (!takeCharacter(text, '+') && !takeCharacter(text, '-')) {
    return std::nullopt;
  }
  const auto hour = takeNumber(text, 2);
  const auto minute = hour && takeCharacter(text, ':') ? takeNumber(text, 2) : std::nullopt;
  if (!minute || *hour > 15 || *minute > 59) {
    return std::nullopt;
  }
  return sign * (3600 * *hour + 60 * *minute);
}

/// Whole numbers of which one by the other is a duration in days.
struct Fraction {
  double above, below;
};

/// The fraction with the smallest whole numbers to which a number is the nearest double: a convergent of its continued
/// fraction, as the numbers are small (Legendre).
std::optional<Fraction> fractionOf(double number) {
  constexpr double kMostBelow = 1e7;
  Fraction before{1.0, 0.0};
  Fraction now{std::floor(number), 1.0};
  for (double rest = number - now.above; now.above <= kMostWhole && now.below <= kMostBelow;) {
    if (now.above / now.below == number) {
      return now;
    }
    if (!(rest > 0.0)) {
      break;
    }
    const double whole = std::floor(1.0 / rest);
    rest = 1.0 / rest - whole;
    const Fraction next{whole * now.above + before.above, whole * now.below + before.below};
    before = now;
    now = next;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::int64_t> secondsOfDate(std::string_view text) {
  const auto year = takeNumber(text, 4);
  const auto month = year && takeCharacter(text, '-') ? takeNumber(text, 2) : std::nullopt;
  const auto day = month && takeCharacter(text, '-') ? takeNumber(text, 2) : std::nullopt;
  if (!day || *year < 1 || *month < 1 || *month > 12 || *day < 1) {
    return std::nullopt;
  }
  const bool isLast = *month == 12;
  const std::int64_t noon = julianNoon(*year, *month, *day);
  if (noon >= julianNoon(isLast ? *year + 1 : *year, isLast ? 1 : *month + 1, 1)) {
    return std::nullopt;  // no day of that month
  }
  std::int64_t seconds = noon * kSecondsPerDay;
  if (takeCharacter(text, 'T') || takeCharacter(text, ' ')) {
    const auto time = takeTime(text);
    const auto offset = time ? takeOffset(text) : std::nullopt;
    if (!offset) {
      return std::nullopt;
    }
    seconds += *time - *offset;
  }
  return text.empty() ? std::optional(seconds) : std::nullopt;
}

std::optional<double> julianDayOf(std::string_view text) {
  const auto seconds = secondsOfDate(text);
  return seconds ? std::optional(static_cast<double>(*seconds) / kSecondsPerDay - 0.5) : std::nullopt;
}

double beginOfStep(double stepDurationDays, std::uint64_t step) {
  const auto count = static_cast<double>(step);
  const auto fraction = fractionOf(stepDurationDays);
  // a product of whole numbers is exact as far as doubles count, and then the quotient is the nearest double
  return fraction && count * fraction->above <= kMostWhole ? count * fraction->above / fraction->below
                                                           : count * stepDurationDays;
}

double endOfStep(double beginDays, double stepDurationDays) {
  constexpr double kSlack = 1e-6;  // steps
  const double number = std::round(beginDays / stepDurationDays);
  if (number >= 0.0 && number < kMostWhole &&
      std::abs(beginDays - beginOfStep(stepDurationDays, static_cast<std::uint64_t>(number))) <=
          kSlack * stepDurationDays) {
    return beginOfStep(stepDurationDays, static_cast<std::uint64_t>(number) + 1);
  }
  return beginDays + stepDurationDays;
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
    // a world whose z is up has a north along y
    const bool isAlongDefault = std::abs(world.up.x) <= 1e-9 && std::abs(world.up.y) <= 1e-9;
    return std::string(
               "'north' is along 'up' or has no direction (left out it is [0, 0, -1]); give a horizontal vector "
               "such as ") +
           (isAlongDefault ? "[0, 1, 0]" : "[0, 0, -1]");
  }
  if (!(world.stepDurationDays > 0.0)) {
    return "'stepDuration' must be greater than 0; give a number of days, or a text such as \"1 h\"";
  }
  if (!(world.stepDurationDays <= kMostStepDays)) {
    return "'stepDuration' must be at most 1000000 days; give a number of days, or a text such as \"1 h\"";
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
