#include "engine/turtle/weather.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <utility>

#include "engine/core/elementary.h"
#include "engine/core/number_text.h"

namespace espalier::turtle {

namespace {

using Rows = std::vector<std::vector<std::string_view>>;
constexpr double kSecondsPerDay = 86400.0;
constexpr double kSlack = 1e-4;       // seconds: times that others computed differ by rounding
constexpr double kTableSlack = 0.05;  // seconds: days with 6 decimals
constexpr double kMostScale = 1e6;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \r\"";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  return begin == std::string_view::npos ? std::string_view()
                                         : text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::vector<std::string_view> cellsOf(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(separator, begin), line.size());
    cells.push_back(trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

std::optional<std::size_t> quantityOf(std::string_view name) {
  for (std::size_t i = 0; i < kWeatherQuantities.size(); ++i) {
    if (kWeatherQuantities[i].name == name) {
      return i;
    }
  }
  return std::nullopt;
}

std::string at(std::size_t line) {
  return "line " + std::to_string(line) + ": ";
}

std::string textOf(double number) {
  std::string text;
  core::appendNumber(text, number, core::NumberStyle::Shortest);
  return text;
}

/// A unit without its ways of writing: [°C], [W m-2] and [W/m²] are [degC] and [W/m2].
std::string plainUnit(std::string_view unit) {
  std::string plain(unit);
  for (const auto& [written, meant] : {std::pair<std::string_view, std::string_view>{"°C", "degC"},
                                       {"µ", "u"},
                                       {"^", ""},
                                       {"⁻", "-"},
                                       {"²", "2"},
                                       {"³", "3"},
                                       {"¹", "1"},
                                       {" m-2", "/m2"},
                                       {" s-1", "/s"},
                                       {" h-1", "/h"}}) {
    for (std::size_t at = plain.find(written); at != std::string::npos; at = plain.find(written, at + meant.size())) {
      plain.replace(at, written.size(), meant);
    }
  }
  return plain == "C" ? "degC" : plain;
}

/// The quantity of a head such as `temperature [degC]`, or the sentence that refuses it.
tl::expected<std::size_t, std::string> readQuantity(std::string_view cell) {
  const std::size_t bracket = cell.find_first_of("[(");
  const auto quantity = quantityOf(trimmed(cell.substr(0, bracket)));
  if (!quantity) {
    std::string names;
    for (const WeatherQuantity& known : kWeatherQuantities) {
      names += ", " + std::string(known.name);
    }
    return tl::unexpected("the quantity '" + std::string(cell) + "' is not known; there are " + names.substr(2));
  }
  if (bracket != std::string_view::npos) {
    const std::string_view unit = trimmed(cell.substr(bracket + 1, cell.find_last_of("])") - bracket - 1));
    const WeatherQuantity& known = kWeatherQuantities[*quantity];
    if (plainUnit(unit) != plainUnit(known.unit)) {
      return tl::unexpected("'" + std::string(known.name) + "' has the unit " + std::string(unit) + "; convert it to " +
                            std::string(known.unit));
    }
  }
  return *quantity;
}

tl::expected<double, std::string> readNumber(std::string_view cell, std::string_view name) {
  const auto number = core::parseNumber(cell);
  if (!number || !std::isfinite(*number)) {
    const std::string problem = "expected a number for '" + std::string(name) + "', found '" + std::string(cell) + "'";
    const bool isGap = cell.empty() || cell == "NA" || cell == "nan" || cell == "NaN";
    return tl::unexpected(problem +
                          (isGap ? "; fill the gap, or leave the row out: its interval is then part of the one before"
                           : cell.find(',') != std::string_view::npos ? "; write a decimal point"
                                                                      : ""));
  }
  return *number;
}

/// Seconds of a time in days: the nearest whole number when that is as near as the slack.
double secondsOf(double days, double slack) {
  const double seconds = days * kSecondsPerDay;
  const double whole = std::round(seconds);
  return std::abs(seconds - whole) <= slack ? whole : seconds;
}

/// A number as a multiple of 1/scale; with scale 0 the number.
double partsOf(double number, double scale) {
  return scale > 0.0 ? std::round(number * scale) : number;
}

/// The smallest power of 10, at least `scale`, of which a number is the nearest double to a whole multiple of 1/scale.
/// 0: none up to kMostScale, or `scale` is 0.
double scaleFor(double number, double scale) {
  while (scale > 0.0 && partsOf(number, scale) / scale != number) {
    scale = scale < kMostScale ? 10.0 * scale : 0.0;
  }
  return scale;
}

/// Why the last values of the radiation of the sky, of the sun and of both together cannot all be, or nothing. Two
/// instruments may differ by 10 % and 20 W/m².
template <typename Column>
std::optional<std::string> problemOfRadiation(const std::array<Column, kWeatherQuantities.size()>& columns) {
  const auto lastOf = [&columns](std::string_view name) {
    const std::vector<double>& column = columns[*quantityOf(name)].values;
    return column.empty() ? std::nullopt : std::optional(column.back());
  };
  const std::optional<double> global = lastOf("global");
  const std::optional<double> direct = lastOf("direct");
  const std::optional<double> diffuse = lastOf("diffuse");
  const auto isClearlyAbove = [](double larger, double smaller) { return larger > 1.1 * smaller + 20.0; };
  if (global && diffuse && isClearlyAbove(*diffuse, *global)) {
    return "'diffuse' is " + textOf(*diffuse) + " and 'global' " + textOf(*global) +
           "; the sky alone cannot give more than sun and sky together";
  }
  // on a horizontal plane the sun gives at most 'direct'
  if (global && direct && diffuse && isClearlyAbove(*global, *direct + *diffuse)) {
    return "'global' is " + textOf(*global) + ", and 'direct' and 'diffuse' only " + textOf(*direct) + " and " +
           textOf(*diffuse) +
           "; on a horizontal plane sun and sky give at most their sum. Remove the column that was not measured";
  }
  return std::nullopt;
}

}  // namespace

tl::expected<Weather, std::string> Weather::read(std::string text, const std::string& start) {
  Weather weather;
  weather.text_ = std::move(text);
  std::string_view whole = weather.text_;
  if (whole.starts_with("\xEF\xBB\xBF")) {
    whole.remove_prefix(3);  // the byte order mark of spreadsheet programs
  }
  Rows rows;
  std::vector<std::size_t> lines;
  char separator = ',';
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < whole.size();) {
    const std::size_t end = std::min(whole.find('\n', begin), whole.size());
    const std::string_view line = trimmed(whole.substr(begin, end - begin));
    begin = end + 1;
    ++number;
    if (line.empty() || line.front() == '#') {
      continue;
    }
    if (rows.empty()) {
      separator = line.find('\t') != std::string_view::npos  ? '\t'
                  : line.find(';') != std::string_view::npos ? ';'
                                                             : ',';
    }
    rows.push_back(cellsOf(line, separator));
    lines.push_back(number);
    if (rows.back().size() != rows.front().size()) {
      return tl::unexpected(at(number) + "expected " + std::to_string(rows.front().size()) + " cells, found " +
                            std::to_string(rows.back().size()));
    }
  }
  if (rows.size() < 2) {
    return tl::unexpected(std::string("it has no rows; write a head such as time,temperature and a row below"));
  }
  weather.isFormula_ = rows.front().front() == "quantity";
  auto problem = weather.isFormula_ ? weather.readFormula(rows, lines) : weather.readTable(rows, lines, start);
  if (problem) {
    return tl::unexpected(std::move(*problem));
  }
  return weather;
}

std::optional<std::string> Weather::readTable(const Rows& rows, const std::vector<std::size_t>& lines,
                                              const std::string& start) {
  const std::vector<std::string_view>& head = rows.front();
  if (head.front() != "time") {
    return at(lines.front()) + "expected a head that begins with time or quantity, found '" +
           std::string(head.front()) + "'";
  }
  std::vector<std::size_t> columns;
  for (std::size_t column = 1; column < head.size(); ++column) {
    const auto quantity = readQuantity(head[column]);
    if (!quantity) {
      return at(lines.front()) + quantity.error();
    }
    if (std::find(columns.begin(), columns.end(), *quantity) != columns.end()) {
      return at(lines.front()) + "'" + std::string(kWeatherQuantities[*quantity].name) + "' has two columns";
    }
    columns.push_back(*quantity);
  }
  const std::optional<std::int64_t> startSeconds = start.empty() ? std::nullopt : secondsOfDate(start);
  for (std::size_t row = 1; row < rows.size(); ++row) {
    const std::string_view cell = rows[row].front();
    double time = 0.0;
    if (const auto number = core::parseNumber(cell)) {
      time = secondsOf(*number, kTableSlack);
    } else if (const auto seconds = secondsOfDate(cell)) {
      if (!startSeconds) {
        return at(lines[row]) + "a date needs the 'start' of the world; set it, or give times in days";
      }
      time = static_cast<double>(*seconds - *startSeconds);
    } else {
      return at(lines[row]) + "expected a date or a number of days, found '" + std::string(cell) + "'";
    }
    if (!times_.empty() && !(time > times_.back())) {
      return at(lines[row]) + "the time '" + std::string(cell) + "' is not after the one before; sort the rows";
    }
    times_.push_back(time);
    for (std::size_t column = 0; column < columns.size(); ++column) {
      const WeatherQuantity& quantity = kWeatherQuantities[columns[column]];
      const auto value = readNumber(rows[row][column + 1], quantity.name);
      if (!value) {
        return at(lines[row]) + value.error();
      }
      if (*value < quantity.least) {
        return at(lines[row]) + "'" + std::string(quantity.name) + "' is " + textOf(*value) + " and must be at least " +
               textOf(quantity.least);
      }
      if (*value > quantity.most) {
        return at(lines[row]) + "'" + std::string(quantity.name) + "' is " + textOf(*value) + " and must be at most " +
               textOf(quantity.most) + "; the unit is " + std::string(quantity.unit);
      }
      Column& to = columns_[columns[column]];
      to.values.push_back(*value);
      to.scale = scaleFor(*value, to.scale);
    }
    if (auto problem = problemOfRadiation(columns_)) {
      return at(lines[row]) + *problem;
    }
  }
  return std::nullopt;
}

std::optional<std::string> Weather::readFormula(const Rows& rows, const std::vector<std::size_t>& lines) {
  constexpr std::array<std::string_view, 5> kHead{"quantity", "mean", "amplitude", "period", "peak"};
  if (!std::equal(kHead.begin(), kHead.end(), rows.front().begin(), rows.front().end())) {
    return at(lines.front()) + "expected the head quantity,mean,amplitude,period,peak";
  }
  for (std::size_t row = 1; row < rows.size(); ++row) {
    const auto quantity = readQuantity(rows[row][0]);
    if (!quantity) {
      return at(lines[row]) + quantity.error();
    }
    std::array<double, 4> numbers{};
    for (std::size_t k = 0; k < 4; ++k) {
      const auto number = readNumber(rows[row][k + 1], kHead[k + 1]);
      if (!number) {
        return at(lines[row]) + number.error();
      }
      numbers[k] = *number;
    }
    if (!(numbers[2] > 0.0)) {
      return at(lines[row]) + "'period' must be greater than 0 days";
    }
    waves_[*quantity].push_back({numbers[0], numbers[1], numbers[2], numbers[3]});
  }
  for (std::size_t quantity = 0; quantity < waves_.size(); ++quantity) {
    double least = 0.0;
    double most = 0.0;
    for (const Wave& wave : waves_[quantity]) {
      least += wave.mean - std::abs(wave.amplitude);
      most += wave.mean + std::abs(wave.amplitude);
    }
    if (most > kWeatherQuantities[quantity].most) {
      return "'" + std::string(kWeatherQuantities[quantity].name) + "' rises to " + textOf(most) +
             " and must be at most " + textOf(kWeatherQuantities[quantity].most);
    }
    if (!waves_[quantity].empty() && least < kWeatherQuantities[quantity].least) {
      return "'" + std::string(kWeatherQuantities[quantity].name) + "' falls to " + textOf(least) +
             " and must be at least " + textOf(kWeatherQuantities[quantity].least);
    }
  }
  return std::nullopt;
}

bool Weather::has(std::string_view name) const {
  const auto quantity = quantityOf(name);
  return quantity && (isFormula_ ? !waves_[*quantity].empty() : !columns_[*quantity].values.empty());
}

double Weather::beginSeconds() const {
  return isFormula_ ? -kInfinity : times_.front();
}

double Weather::endSeconds() const {
  return isFormula_ || times_.size() < 2 ? kInfinity : 2.0 * times_.back() - times_[times_.size() - 2];
}

double Weather::begin() const {
  return beginSeconds() / kSecondsPerDay;
}

double Weather::end() const {
  return endSeconds() / kSecondsPerDay;
}

std::size_t Weather::intervalAt(double seconds) const {
  const auto next = std::upper_bound(times_.begin(), times_.end(), seconds + kSlack);
  return next == times_.begin() ? std::size_t{0} : static_cast<std::size_t>(next - times_.begin()) - 1;
}

double Weather::meanOfWaves(std::size_t quantity, double from, double to) const {
  double sum = 0.0;
  for (const Wave& wave : waves_[quantity]) {
    const double turns = 2.0 * std::numbers::pi / wave.period;
    const double half = 0.5 * turns * (to - from);
    const double flattened = half == 0.0 ? 1.0 : core::sin(half) / half;
    sum += wave.mean + wave.amplitude * flattened * core::cos(turns * (0.5 * (from + to) - wave.peak));
  }
  return sum;
}

std::optional<double> Weather::mean(std::string_view name, double from, double to) const {
  const double begin = secondsOf(from, kSlack);
  const double end = secondsOf(to, kSlack);
  if (!has(name) || begin < beginSeconds() - kSlack || end > endSeconds() + kSlack) {
    return std::nullopt;
  }
  const std::size_t quantity = *quantityOf(name);
  if (isFormula_) {
    return meanOfWaves(quantity, from, to);
  }
  const auto& [values, scale] = columns_[quantity];
  std::size_t interval = intervalAt(begin);
  const double first = values[interval];
  // the difference from the sum with the first value all the time
  double sum = 0.0;
  for (double time = begin; interval < times_.size() && time < end; ++interval) {
    const double until = interval + 1 < times_.size() ? std::min(times_[interval + 1], end) : end;
    sum += (partsOf(values[interval], scale) - partsOf(first, scale)) * (until - time);
    time = until;
  }
  if (sum == 0.0) {
    return first;
  }
  return scale > 0.0 ? (partsOf(first, scale) * (end - begin) + sum) / (scale * (end - begin))
                     : first + sum / (end - begin);
}

std::optional<double> Weather::thermalTime(double untilDays, double base) const {
  const double until = secondsOf(untilDays, kSlack);
  if (!has("temperature") || until > endSeconds() + kSlack || beginSeconds() > kSlack) {
    return std::nullopt;
  }
  const std::size_t quantity = *quantityOf("temperature");
  double sum = 0.0;
  double time = 0.0;
  if (isFormula_) {
    constexpr double kSecondsPerHour = 3600.0;
    for (std::uint64_t hour = 1; time < until; ++hour) {
      const double later = std::min(until, static_cast<double>(hour) * kSecondsPerHour);
      const double mean = meanOfWaves(quantity, time / kSecondsPerDay, later / kSecondsPerDay);
      sum += std::max(mean - base, 0.0) * (later - time);
      time = later;
    }
    return sum / kSecondsPerDay;
  }
  const std::vector<double>& values = columns_[quantity].values;
  const double scale = scaleFor(base, columns_[quantity].scale);
  for (std::size_t interval = intervalAt(0.0); interval < times_.size() && time < until; ++interval) {
    const double later = interval + 1 < times_.size() ? std::min(times_[interval + 1], until) : until;
    sum += std::max(partsOf(values[interval], scale) - partsOf(base, scale), 0.0) * (later - time);
    time = later;
  }
  return sum / (std::max(scale, 1.0) * kSecondsPerDay);
}

std::string missingWeather(const World& world, std::string_view quantity, double from, double to) {
  const std::string name(quantity);
  if (!world.weather) {
    return "needs the weather's '" + name + "', and the world has no 'weather'. Give the world a table of it.";
  }
  if (!world.weather->has(quantity)) {
    return "needs the weather's '" + name + "', and the table has no such column. Add it.";
  }
  const double end = world.weather->end();
  return "needs the weather from day " + textOf(from) + " to day " + textOf(to) +
         ", and the table covers the time from day " + textOf(world.weather->begin()) +
         (std::isfinite(end) ? " to day " + textOf(end) : " on") + " after the start. Add rows to the table, " +
         (from < world.weather->begin() ? "or let the world start later." : "or make fewer steps.");
}

}  // namespace espalier::turtle
