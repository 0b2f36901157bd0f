#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "engine/turtle/world.h"

namespace espalier::turtle {

/// A quantity of the weather with its unit.
struct WeatherQuantity {
  std::string_view name;
  std::string_view unit;
  double least;
  double most = std::numeric_limits<double>::infinity();
};

inline constexpr double kAbsoluteZero = -273.15;
/// W/m^2: the sun gives 1361 above the air, and bright clouds beside it add less than half; more is another unit.
inline constexpr double kMostRadiation = 2000.0;
inline constexpr std::array kWeatherQuantities{
    WeatherQuantity{"global", "W/m^2", 0.0, kMostRadiation},   // sun and sky on a horizontal plane
    WeatherQuantity{"direct", "W/m^2", 0.0, kMostRadiation},   // the sun on a plane that faces it
    WeatherQuantity{"diffuse", "W/m^2", 0.0, kMostRadiation},  // the sky on a horizontal plane
    WeatherQuantity{"temperature", "degC", kAbsoluteZero, 100.0},
    WeatherQuantity{"humidity", "%", 0.0, 110.0},  // relative; sensors in fog show a little more than 100
    WeatherQuantity{"wind", "m/s", 0.0},
    WeatherQuantity{"rain", "mm/h", 0.0},
    WeatherQuantity{"co2", "umol/mol", 0.0},
};

/// The weather of a run, read from a text in one of two forms, with commas, semicolons or tabs between cells and lines
/// that begin with # left out.
///
/// A *table* has a head `time,QUANTITY,...` and a row for each interval. A time is a date (secondsOfDate) or a number
/// of days after the start of the run; within 0.05 s of a whole second it is that second. A value is the mean of its
/// interval, which ends where the next one begins. The last interval is as long as the one before it; the only one of a
/// table has no end.
///
/// A *formula* has the head `quantity,mean,amplitude,period,peak` and one row or more for a quantity, whose sum it is:
/// mean + amplitude · cos(2π (t − peak)/period), in days after the start.
///
/// The text is kept: it is the weather in snapshots and on the wire.
class Weather {
 public:
  /// The error is a sentence without its subject, with the line: `line 3: …`. `start` is World::start.
  [[nodiscard]] static tl::expected<Weather, std::string> read(std::string text, const std::string& start);

  [[nodiscard]] std::string_view table() const { return text_; }
  [[nodiscard]] bool has(std::string_view quantity) const;

  /// The mean of a quantity between two times, in days after the start; at equal times the value then. Nothing when the
  /// weather does not have the quantity, or not for all of that time. Times within 0.1 ms of a whole second are that
  /// second. In a table whose values have at most 6 decimals the mean of whole seconds is the double nearest to the
  /// exact one: within an interval the number of the table. O(intervals between + log intervals).
  [[nodiscard]] std::optional<double> mean(std::string_view quantity, double from, double to) const;

  /// Thermal time since the start of the run, degrees Celsius times days: the sum over time of what the temperature is
  /// above `base`. Of a formula by steps of 1/24 day. Rounded once, as mean() is. O(intervals before). Nothing as in
  /// mean().
  [[nodiscard]] std::optional<double> thermalTime(double until, double base) const;

  /// Beginning and end of what is known, days after the start; infinite for a formula.
  [[nodiscard]] double begin() const;
  [[nodiscard]] double end() const;

 private:
  struct Wave {
    double mean = 0.0, amplitude = 0.0, period = 1.0, peak = 0.0;
  };
  /// Numbers as whole multiples of 1/scale, of which sums are exact.
  struct Column {
    std::vector<double> values;
    double scale = 1.0;  // a power of 10; 0: the values have more than 6 decimals
  };

  /// Seconds after the start; infinite as begin() and end() are.
  [[nodiscard]] double beginSeconds() const;
  [[nodiscard]] double endSeconds() const;
  /// The number of the interval of a table at a time.
  [[nodiscard]] std::size_t intervalAt(double seconds) const;
  [[nodiscard]] double meanOfWaves(std::size_t quantity, double from, double to) const;

  [[nodiscard]] std::optional<std::string> readTable(const std::vector<std::vector<std::string_view>>& rows,
                                                     const std::vector<std::size_t>& lines, const std::string& start);
  [[nodiscard]] std::optional<std::string> readFormula(const std::vector<std::vector<std::string_view>>& rows,
                                                       const std::vector<std::size_t>& lines);

  std::string text_;
  bool isFormula_ = false;
  std::vector<double> times_;                                       // beginnings of intervals, seconds, ascending
  std::array<Column, kWeatherQuantities.size()> columns_;           // of a table (times), or empty
  std::array<std::vector<Wave>, kWeatherQuantities.size()> waves_;  // of a formula
};

/// The error of a step whose weather is not known: a sentence that names the quantity and the time.
[[nodiscard]] std::string missingWeather(const World& world, std::string_view quantity, double from, double to);

}  // namespace espalier::turtle
