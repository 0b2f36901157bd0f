#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "engine/core/vec3.h"

namespace espalier::turtle {

class Weather;

/// The world of a simulation: units, directions, place, time and weather.
struct World {
  std::string lengthUnit = "m";
  core::Vec3 up{0.0, 1.0, 0.0};
  core::Vec3 north{0.0, 0.0, -1.0};
  double stepDurationDays = 1.0;
  std::optional<double> latitudeDegrees;
  std::optional<double> longitudeDegrees;  // positive to the east
  std::string start;                       // ISO 8601 date, with a time and an offset from UTC if wanted; or empty
  double baseTemperature = 0.0;            // of thermal time, degrees Celsius
  std::shared_ptr<const Weather> weather;  // null: not known

  /// The same members, and weather of the same text.
  [[nodiscard]] bool operator==(const World& other) const;
};

/// The Julian day of a moment: "2026-06-21", "2026-06-21T12:00", "...:30", then nothing or "Z" for universal time, or
/// an offset from it such as "+02:00". A fraction of a second is left out. Nothing when the text is no such date.
/// Proleptic Gregorian calendar, years 1 to 9999.
[[nodiscard]] std::optional<double> julianDayOf(std::string_view text);

/// The same moment in whole seconds, exact: the Julian day times 86400, and 43200.
[[nodiscard]] std::optional<std::int64_t> secondsOfDate(std::string_view text);

/// When a step begins, days after the start. A duration stands for the simplest fraction p/q to which it is the nearest
/// double, such as 1/24, 1/7 or 3/10, with q up to 10 million. The time is the double nearest to
/// step · p/q: steps that divide the day end exactly where days end. A duration that is no such fraction is multiplied
/// by the step.
[[nodiscard]] double beginOfStep(double stepDurationDays, std::uint64_t step);

/// When the step ends that begins at a time: beginOfStep() of the next one when a step begins then within rounding,
/// else the sum.
[[nodiscard]] double endOfStep(double beginDays, double stepDurationDays);

/// Why a world cannot be: a sentence that names the member and the remedy. Nothing: it can.
[[nodiscard]] std::optional<std::string> problemOfWorld(const World& world);

}  // namespace espalier::turtle
