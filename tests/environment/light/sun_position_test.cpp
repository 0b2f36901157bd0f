#include "environment/light/sun_position.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace espalier::environment::sun_position_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(SunPosition, AgreesWithTheExampleOfTheSolarPositionAlgorithm) {
  // Reda & Andreas, "Solar position algorithm for solar radiation applications" (NREL/TP-560-34302, 2008), appendix
  // A.5: 17 October 2003, 12:30:30 local (UT − 7 h), 39.742476° N, 105.1786° W: topocentric elevation without
  // refraction 39.872046°, azimuth 194.340241°
  const auto day = julianDayOf("2003-10-17T19:30:30Z");
  EXPECT_NEAR(*day, 2452930.312847, 1e-6);
  const SunPosition sun = sunPosition(*day, 39.742476, -105.1786);
  EXPECT_NEAR(sun.elevationRadians / kDegree, 39.872046, 0.01);
  EXPECT_NEAR(sun.azimuthRadians / kDegree, 194.340241, 0.01);
}

TEST(SunPosition, AgreesWithTheSolarPositionAlgorithmOnBothHemispheres) {
  // Reda & Andreas 2004 as computed with a published solar library; the bar is 0.02°
  struct Case {
    const char* moment;
    double latitude, longitude, azimuth, elevation;
  };
  for (const Case& c : {Case{"2021-06-21T12:00:00Z", 52.52, 13.405, 203.72305, 59.285657},
                        Case{"2021-12-21T10:30:00+01:00", 52.52, 13.405, 157.98291, 11.293283},
                        Case{"2021-06-21T17:30:00+05:30", 28.6139, 77.209, 285.54483, 22.031291},
                        Case{"2021-12-21T09:30:00Z", -43.5321, 172.6362, 220.938, -11.620362},
                        Case{"2021-06-21T12:00:00Z", -1.2921, 36.8219, 307.29606, 46.861904}}) {
    const SunPosition sun = sunPosition(*julianDayOf(c.moment), c.latitude, c.longitude);
    EXPECT_NEAR(sun.elevationRadians / kDegree, c.elevation, 0.02) << c.moment;
    EXPECT_NEAR(sun.azimuthRadians / kDegree, c.azimuth, 0.02) << c.moment;
  }
}

TEST(SunPosition, AgreesWithMeeusAndTheAlmanac) {
  // Meeus, example 25.a and 25.b: 1992 October 13, 0h TD (59 s after UT): declination −7.78507° (accurate theory
  // −7.78441°). Seen from the pole the elevation is the declination, less the parallax of 8.8″ · cos δ
  const double day = *julianDayOf("1992-10-13") - 59.0 / 86400.0;
  EXPECT_NEAR(sunPosition(day, 90, 0).elevationRadians / kDegree, -7.78507 - 8.8 / 3600.0, 0.0005);
  // apparent right ascension 198.38083°; sidereal time at Greenwich at 0h UT is 21.8013° (his formula 12.4), so the
  // hour angle is −176.83°: on the equator the sun stands sin⁻¹(cos δ cos H) = −81.60° high, in the east
  const double hourAngle = (21.8013 - 59.0 / 86400.0 * 360.98565 - 198.38083) * kDegree;
  const SunPosition sun = sunPosition(day, 0, 0);
  EXPECT_NEAR(sun.elevationRadians, std::asin(std::cos(-7.785 * kDegree) * std::cos(hourAngle)), 0.01 * kDegree);
  EXPECT_GT(std::sin(sun.azimuthRadians), 0.0);
}

TEST(SunPosition, StandsOverTheTropicsAtTheSolstices) {
  // the June solstice of 2024 was on the 20th at 20:51 UT (Astronomical Almanac): declination 23.44°, so at the moment
  // of local noon the sun is in the zenith of the tropic of Cancer. The equation of time is −1 min 46 s then
  const SunPosition sun = sunPosition(*julianDayOf("2024-06-20T12:01:46"), 23.44, 0);
  EXPECT_GT(sun.elevationRadians / kDegree, 89.9);
  // at the equinox of 2024 (20 March, 03:06 UT) it rises in the east
  for (double hour = 0; hour < 24; hour += 0.05) {
    const SunPosition one = sunPosition(*julianDayOf("2024-03-20") + hour / 24, 51.5, 0);
    if (std::abs(one.elevationRadians) < 0.1 * kDegree) {
      EXPECT_NEAR(std::abs(std::sin(one.azimuthRadians)), 1, 0.001) << hour;
    }
  }
  // and never sets at 70° N in June
  for (int hour = 0; hour < 24; ++hour) {
    EXPECT_GT(sunPosition(*julianDayOf("2024-06-20") + hour / 24.0, 70, 0).elevationRadians, 0);
  }
}

TEST(SunPosition, DatesAreJulianDays) {
  // Meeus, chapter 7: 1957 October 4.81 is 2436116.31; 2000 January 1.5 is 2451545.0; 1987 January 27.0 is 2446822.5
  EXPECT_NEAR(*julianDayOf("1957-10-04") + 0.81, 2436116.31, 1e-8);
  EXPECT_EQ(*julianDayOf("2000-01-01T12:00"), 2451545.0);
  EXPECT_EQ(*julianDayOf("1987-01-27"), 2446822.5);
  for (const char* text : {"", "2024", "2024-13-01", "2024-00-10", "24-01-01", "2024-01-01 12", "2024-01-01T25:00",
                           "2024-01-01T12:61", "2024-01-01x", "-024-01-01"}) {
    EXPECT_FALSE(julianDayOf(text).has_value()) << text;
  }
}

TEST(SunPosition, DirectionsFollowTheWorldsAxes) {
  const core::Vec3 up{0, 1, 0};
  const core::Vec3 north{0, 0, -1};
  const auto east = sunDirection({0, std::numbers::pi / 2}, up, north);
  EXPECT_NEAR(east.x, 1, 1e-15);
  const auto high = sunDirection({30 * kDegree, std::numbers::pi}, up, north);
  EXPECT_NEAR(high.y, 0.5, 1e-15);
  EXPECT_NEAR(high.z, std::sqrt(0.75), 1e-15);
}

TEST(SunPosition, TheSunIsNearestInJanuary) {
  // perihelion 0.9833 and aphelion 1.0167 astronomical units
  EXPECT_NEAR(solarIrradiance(*julianDayOf("2024-01-03")), 1361 / (0.98331 * 0.98331), 0.1);
  EXPECT_NEAR(solarIrradiance(*julianDayOf("2024-07-05")), 1361 / (1.01673 * 1.01673), 0.1);
}

}  // namespace
}  // namespace espalier::environment::sun_position_test
