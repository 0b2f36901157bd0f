#include "engine/turtle/weather.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <numbers>

#include "engine/core/elementary.h"

namespace espalier::turtle::weather_test {
namespace {

Weather weatherOf(const std::string& text, const std::string& start = {}) {
  auto read = Weather::read(text, start);
  EXPECT_TRUE(read.has_value()) << (read ? "" : read.error());
  return std::move(*read);
}

TEST(Weather, ATableGivesTheMeanOverItsIntervals) {
  const Weather weather = weatherOf("# a station\ntime,temperature,wind\n0,10,1\n0.5,20,2\n1,30,3\n");
  EXPECT_EQ(weather.mean("temperature", 0, 0.5), 10.0);
  EXPECT_EQ(weather.mean("temperature", 0, 1), 15.0);
  EXPECT_EQ(weather.mean("temperature", 0.25, 1.25), 0.25 * 10 + 0.5 * 20 + 0.25 * 30);
  EXPECT_EQ(weather.mean("temperature", 0.5, 0.5), 20.0) << "at the border the later value";
  EXPECT_EQ(weather.mean("wind", 0, 1.5), 2.0) << "the last interval is as long as the one before";
  EXPECT_EQ(weather.end(), 1.5);
  EXPECT_FALSE(weather.mean("wind", 1, 1.6).has_value());
  EXPECT_FALSE(weather.mean("wind", -0.1, 0.1).has_value());
  EXPECT_FALSE(weather.mean("rain", 0, 1).has_value());
}

TEST(Weather, DatesCountFromTheStart) {
  const Weather weather =
      weatherOf("time;temperature [degC]\n2026-06-21T06:00+02:00;10\n2026-06-21T07:00+02:00;12\n", "2026-06-21T04:00Z");
  EXPECT_EQ(weather.mean("temperature", 0, 1.0 / 24), 10.0);
  EXPECT_EQ(weather.mean("temperature", 1.0 / 24, 2.0 / 24), 12.0);
  EXPECT_EQ(Weather::read("time,wind\n2026-06-21,1\n", "").error(),
            "line 2: a date needs the 'start' of the world; set it, or give times in days");
}

/// "2026-03-01T06:00+01:00" and hours later, up to two weeks.
std::string dateOf(int hour) {
  const int ofDay = (6 + hour) % 24;
  const int day = 1 + (6 + hour) / 24;
  return "2026-03-" + std::string(day < 10 ? "0" : "") + std::to_string(day) + "T" + (ofDay < 10 ? "0" : "") +
         std::to_string(ofDay) + ":00+01:00";
}

TEST(Weather, HoursGiveTheNumbersOfTheTable) {
  // temperatures with a decimal, times as dates and as days with 6 and with all decimals
  constexpr int kHours = 300;
  const auto tenthsOf = [](int hour) { return 83 + hour * 7 % 61; };
  std::string dates = "time,temperature\n";
  std::string days = dates;
  std::string exact = dates;
  for (int hour = 0; hour < kHours; ++hour) {
    const std::string value =
        "," + std::to_string(tenthsOf(hour) / 10) + "." + std::to_string(tenthsOf(hour) % 10) + "\n";
    char text[40];
    dates += dateOf(hour) + value;
    std::snprintf(text, sizeof text, "%.6f", hour / 24.0);
    days += text + value;
    std::snprintf(text, sizeof text, "%.17g", hour / 24.0);
    exact += text + value;
  }
  for (const std::string& table : {dates, days, exact}) {
    const Weather weather = weatherOf(table, dateOf(0));
    std::int64_t tenths = 0;  // of degrees above 4.3, times hours
    for (int hour = 0; hour + 3 <= kHours; ++hour) {
      const double from = beginOfStep(1.0 / 24, static_cast<std::uint64_t>(hour));
      const double to = beginOfStep(1.0 / 24, static_cast<std::uint64_t>(hour) + 1);
      EXPECT_EQ(weather.mean("temperature", from, to), tenthsOf(hour) / 10.0) << hour;
      EXPECT_EQ(weather.mean("temperature", from, from + 1.0 / 24), tenthsOf(hour) / 10.0) << hour;
      // the nearest doubles to the exact mean and sum: of one division
      const int three = tenthsOf(hour) + tenthsOf(hour + 1) + tenthsOf(hour + 2);
      EXPECT_EQ(weather.mean("temperature", from, (hour + 3) / 24.0), three / 30.0) << hour;
      EXPECT_EQ(weather.thermalTime(from, 4.3), static_cast<double>(tenths) / 240.0) << hour;
      tenths += tenthsOf(hour) - 43;
    }
  }
}

TEST(Weather, EqualValuesHaveThatMean) {
  // 14.1 times 0.37 by 0.37 is another number
  const Weather weather = weatherOf("time,temperature,wind\n0,14.1,0.123456789\n0.21,14.1,0.123456789\n3,14.1,9\n");
  for (double from = 0; from < 2; from += 0.0371) {
    EXPECT_EQ(weather.mean("temperature", from, from + 0.37), 14.1);
    EXPECT_EQ(weather.mean("wind", from, from + 0.37), 0.123456789);
  }
  EXPECT_EQ(weather.mean("wind", 0, 0), 0.123456789);
}

TEST(Weather, AFormulaIsASumOfWaves) {
  const Weather weather =
      weatherOf("quantity,mean,amplitude,period,peak\ntemperature,15,5,1,0.6\ntemperature,0,2,365,200\n");
  EXPECT_NEAR(*weather.mean("temperature", 0.6, 0.6), 20 + 2 * core::cos(2 * std::numbers::pi * (0.6 - 200) / 365),
              1e-12);
  // over a whole period the daily wave is gone
  EXPECT_NEAR(*weather.mean("temperature", 200.1, 201.1), 17, 2e-4);
  // the mean is the integral: midpoint rule with 10,000 parts
  double sum = 0;
  for (int i = 0; i < 10'000; ++i) {
    const double time = 3.1 + 0.7 * (i + 0.5) / 10'000;
    sum += *weather.mean("temperature", time, time) / 10'000;
  }
  EXPECT_NEAR(*weather.mean("temperature", 3.1, 3.8), sum, 1e-7);
}

TEST(Weather, ThermalTimeIsTheSumAboveTheBase) {
  const Weather weather = weatherOf("time,temperature\n0,10\n0.5,20\n1,4\n2,30\n");
  EXPECT_DOUBLE_EQ(*weather.thermalTime(0, 8), 0);
  EXPECT_DOUBLE_EQ(*weather.thermalTime(0.25, 8), 0.5);
  EXPECT_DOUBLE_EQ(*weather.thermalTime(2, 8), 1 + 6 + 0);
  EXPECT_DOUBLE_EQ(*weather.thermalTime(2.5, 8), 7 + 11);
  EXPECT_FALSE(weather.thermalTime(3.5, 8).has_value());
  // a wave that is never below the base: the mean times the days
  EXPECT_NEAR(*weatherOf("quantity,mean,amplitude,period,peak\ntemperature,15,5,1,0.6\n").thermalTime(3, 5), 30, 1e-9);
}

TEST(Weather, TablesOfSpreadsheetsAreRead) {
  const Weather weather =
      weatherOf("\xEF\xBB\xBFtime;temperature [°C];global [W m-2];direct (W/m²)\r\n0;10;200;300\r\n1;20;0;0\r\n");
  EXPECT_EQ(*weather.mean("temperature", 0, 2), 15.0);
  EXPECT_EQ(*weather.mean("global", 0, 1), 200.0);
  EXPECT_EQ(*weather.mean("direct", 0, 1), 300.0);
}

TEST(Weather, WrongTextsSayLineAndRemedy) {
  const auto error = [](const std::string& text) {
    const auto read = Weather::read(text, "");
    return read ? std::string("none") : read.error();
  };
  EXPECT_EQ(error("time,temperature\n0,1\n0,2\n"), "line 3: the time '0' is not after the one before; sort the rows");
  EXPECT_EQ(error("time,wind\n0,1\n0.0000001,2\n"),
            "line 3: the time '0.0000001' is not after the one before; sort the rows");
  EXPECT_EQ(error("time,temperature\n0,warm\n"), "line 2: expected a number for 'temperature', found 'warm'");
  EXPECT_EQ(error("time;temperature\n0;1,5\n"),
            "line 2: expected a number for 'temperature', found '1,5'; write a decimal point");
  for (const std::string gap : {"", "NA", "nan", "NaN"}) {
    EXPECT_EQ(error("time,temperature\n0," + gap + "\n"),
              "line 2: expected a number for 'temperature', found '" + gap +
                  "'; fill the gap, or leave the row out: its interval is then part of the one before");
  }
  EXPECT_EQ(error("time,temperature\n\n0,1,2\n"), "line 3: expected 2 cells, found 3");
  EXPECT_EQ(error("time,temperature\n0,293.15\n"),
            "line 2: 'temperature' is 293.15 and must be at most 100; the unit is degC");
  for (const std::string radiation : {"global", "direct", "diffuse"}) {  // kJ m^-2 h^-1
    EXPECT_EQ(error("time," + radiation + "\n0,2900\n"),
              "line 2: '" + radiation + "' is 2900 and must be at most 2000; the unit is W/m^2");
  }
  EXPECT_EQ(error("time,humidity\n0,1000\n"), "line 2: 'humidity' is 1000 and must be at most 110; the unit is %");
  EXPECT_EQ(error("time,rain (inch)\n0,1\n"), "line 1: 'rain' has the unit inch; convert it to mm/h");
  EXPECT_EQ(error("time,temp\n0,1\n"),
            "line 1: the quantity 'temp' is not known; there are global, direct, diffuse, temperature, humidity, wind, "
            "rain, co2");
  EXPECT_EQ(error("time,wind,wind\n0,1,1\n"), "line 1: 'wind' has two columns");
  EXPECT_EQ(error("time,global,direct,diffuse\n0,400,500,150\n1,100,200,300\n"),
            "line 3: 'diffuse' is 300 and 'global' 100; the sky alone cannot give more than sun and sky together");
  EXPECT_EQ(error("time,global,direct,diffuse\n0,400,300,150\n1,600,0,100\n"),
            "line 3: 'global' is 600, and 'direct' and 'diffuse' only 0 and 100; on a horizontal plane sun and sky "
            "give at most their sum. Remove the column that was not measured");
  EXPECT_EQ(error("time,global,diffuse\n0,0,15\n"), "none");  // at dawn
  EXPECT_EQ(error("time,global,direct,diffuse\n0,35,0,15\n1,100,800,20\n"), "none");
  EXPECT_EQ(error("time,wind\n0,-1\n"), "line 2: 'wind' is -1 and must be at least 0");
  EXPECT_EQ(error("time,wind\nnoon,1\n"), "line 2: expected a date or a number of days, found 'noon'");
  EXPECT_EQ(error("day,wind\n0,1\n"), "line 1: expected a head that begins with time or quantity, found 'day'");
  EXPECT_EQ(error("time,wind\n"), "it has no rows; write a head such as time,temperature and a row below");
  EXPECT_EQ(error("quantity,mean,amplitude,period,peak\nwind,1,2,1,0\n"), "'wind' falls to -1 and must be at least 0");
  EXPECT_EQ(error("quantity,mean,amplitude,period,peak\nwind,1,0,0,0\n"),
            "line 2: 'period' must be greater than 0 days");
}

TEST(Weather, AMissingValueSaysWhichAndWhen) {
  World world;
  EXPECT_EQ(missingWeather(world, "wind", 0, 1),
            "needs the weather's 'wind', and the world has no 'weather'. Give the world a table of it.");
  world.weather = std::make_shared<const Weather>(weatherOf("time,wind\n0,1\n1,1\n"));
  EXPECT_EQ(missingWeather(world, "rain", 0, 1),
            "needs the weather's 'rain', and the table has no such column. Add it.");
  EXPECT_EQ(
      missingWeather(world, "wind", 2, 3),
      "needs the weather from day 2 to day 3, and the table covers the time from day 0 to day 2 after the start. Add "
      "rows to the table, or make fewer steps.");
  world.weather = std::make_shared<const Weather>(weatherOf("time,wind\n0.5,1\n1,1\n"));
  EXPECT_EQ(missingWeather(world, "wind", 0, 1),
            "needs the weather from day 0 to day 1, and the table covers the time from day 0.5 to day 1.5 after the "
            "start. Add rows to the table, or let the world start later.");
  world.weather = std::make_shared<const Weather>(weatherOf("time,wind\n0.5,1\n"));
  EXPECT_EQ(missingWeather(world, "wind", 0, 1),
            "needs the weather from day 0 to day 1, and the table covers the time from day 0.5 on after the start. Add "
            "rows to the table, or let the world start later.");
}

}  // namespace
}  // namespace espalier::turtle::weather_test
