#include "environment/light/daylight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/core/elementary.h"
#include "engine/turtle/weather.h"
#include "environment/base/number_text.h"
#include "environment/light/sun_position.h"

namespace espalier::environment {

using core::Vec3;
using std::numbers::pi;

namespace {

/// Of a sun lower than this, 2.9°, measured light counts as the sky's: the quotient would be large and uncertain.
constexpr double kLowestSine = 0.05;
/// Of a longer span so many days stand for all.
constexpr std::int64_t kMostDays = 400;
constexpr double kLastDay = 5373484.5;  // Julian day of the end of the year 9999, as dates of the world

}  // namespace

Daylight::Daylight(const Configuration& configuration, double openSky)
    : configuration_(configuration), sun_(configuration.text("sun")), openSky_(openSky) {}

std::optional<std::string> Daylight::open(const turtle::World& world) {
  up_ = core::normalised(world.up);
  stepDays_ = world.stepDurationDays;
  world_ = world;
  hasMeasured_ =
      world.weather && (world.weather->has("global") || world.weather->has("direct") || world.weather->has("diffuse"));
  if (sun_ == "position") {
    const std::string& own = configuration_.text("start");
    const auto start = julianDayOf(own.empty() ? world.start : own);
    // each of the three is the process's own or the world's
    const auto placeOf = [this](const char* key, std::optional<double> ofWorld) {
      return configuration_.isGiven(key) || !ofWorld ? configuration_.number(key) : *ofWorld;
    };
    if (!start || (!configuration_.isGiven("latitude") && !world.latitudeDegrees && own.empty())) {
      return "needs to know where and when it is for the position of the sun: set 'latitude', 'longitude' and "
             "'start', here or in the world (\"2026-06-21T12:00\" in universal time, or with an offset: +02:00).";
    }
    startDay_ = *start;
    latitude_ = placeOf("latitude", world.latitudeDegrees);
    longitude_ = placeOf("longitude", world.longitudeDegrees);
    north_ = core::normalised(world.north - up_ * core::dot(world.north, up_));
  } else if (sun_ == "direction") {
    const auto& direction = configuration_.numbers("sunDirection");
    const Vec3 sun = core::normalised({direction[0], direction[1], direction[2]});
    if (!(core::length(sun) > 0.0)) {
      return "has a 'sunDirection' of length 0. Give the direction that points up to the sun.";
    }
    if (const double sine = core::dot(sun, up_); !(sine > 1e-6)) {
      return "has its sun " + std::string(sine < -1e-6 ? "below" : "at") +
             " the horizon. Give a 'sunDirection' that points up to the sun.";
    }
    // turned around the vertical
    const Vec3 along = up_ * core::dot(sun, up_);
    const auto azimuths = static_cast<int>(configuration_.integer("sunAzimuths"));
    sunDirections_ = {sun};
    for (int k = 1; k < azimuths; ++k) {
      const double angle = 2.0 * pi * k / azimuths;
      sunDirections_.push_back(along + (sun - along) * core::cos(angle) + core::cross(up_, sun) * core::sin(angle));
    }
  }
  const std::string& unit = configuration_.text("unit");
  const bool isOfPhotons = unit == "umol" || unit == "mol";
  const auto isGiven = [this](const char* key) { return configuration_.isGiven(key); };
  if (isOfPhotons && (sun_ == "position" || hasMeasured_) && !isGiven("bands") && !isGiven("bandLimits") &&
      !isGiven("photonsPerJoule")) {
    return "counts photons of the whole sunlight as if all of it were photosynthetically active; about half of its "
           "energy is. Give 'bands', such as [0.5,0.5] (visible light and the rest): the answers begin with the first.";
  }
  return std::nullopt;
}

tl::expected<Daylight::Incoming, std::string> Daylight::at(double timeDays) const {
  Incoming incoming;
  if (sun_ != "position") {
    Radiation radiation{configuration_.number("directIrradiance"),
                        sun_ == "none" ? openSky_ : configuration_.number("diffuseIrradiance")};
    const double sine = sun_ == "none" ? 0.0 : core::dot(sunDirections_.front(), up_);
    if (hasMeasured_) {
      const auto read = measured(timeDays, timeDays + stepDays_, sine);
      if (!read) {
        return tl::unexpected(read.error());
      }
      radiation = *read;
    }
    if (sun_ == "none") {
      incoming.skies.push_back({up_, radiation.diffuse});
    }
    for (const Vec3& direction : sunDirections_) {
      const auto count = static_cast<double>(sunDirections_.size());
      incoming.suns.push_back({direction, radiation.direct / count});
      incoming.skies.push_back({direction, radiation.diffuse / count});
    }
    return incoming;
  }
  if (!(startDay_ + timeDays + stepDays_ <= kLastDay)) {
    return tl::unexpected("knows the position of the sun up to the year 9999, and the step that begins on day " +
                          numberText(timeDays) +
                          " ends later. Make fewer steps, or shorter ones (the world's 'stepDuration').");
  }
  const double whole = std::floor(stepDays_);
  if (stepDays_ <= 1.0) {
    if (auto problem = addHours({timeDays, stepDays_, 1, 1.0}, incoming)) {
      return tl::unexpected(std::move(*problem));
    }
    return incoming;
  }
  // the hours of all whole days, then what is left of a day
  std::optional<std::string> problem =
      addHours({timeDays, 1.0, static_cast<std::int64_t>(whole), whole / stepDays_}, incoming);
  if (!problem && stepDays_ - whole > 1e-9) {
    problem = addHours({timeDays + whole, stepDays_ - whole, 1, 1.0 - whole / stepDays_}, incoming);
  }
  if (problem) {
    return tl::unexpected(std::move(*problem));
  }
  return incoming;
}

/// Adds the light of a span of days, a part of the step: a sun and a sky for each part of the day, those of all days
/// as one.
std::optional<std::string> Daylight::addHours(const Span& span, Incoming& incoming) const {
  const auto samples = static_cast<int>(configuration_.integer("sunSamples"));
  const auto days = std::min<std::int64_t>(span.days, kMostDays);
  for (int i = 0; i < samples; ++i) {
    Vec3 sun;  // of several days: the sum of the directions, each as long as its direct light
    Vec3 sky;  // the same with diffuse light
    double ofSky = 0.0;
    for (std::int64_t k = 0; k < days; ++k) {
      const double first =
          span.begin + (days == span.days ? static_cast<double>(k)
                                          : std::floor(static_cast<double>(span.days) * (static_cast<double>(k) + 0.5) /
                                                       static_cast<double>(days)));
      const double day = startDay_ + first + span.length * (i + 0.5) / samples;
      const SunPosition position = sunPosition(day, latitude_, longitude_);
      const double sine = core::sin(position.elevationRadians);
      const Vec3 direction = sunDirection(position, up_, north_);
      Radiation radiation;
      if (hasMeasured_) {
        const auto read = measured(first + span.length * i / samples, first + span.length * (i + 1) / samples, sine);
        if (!read) {
          return read.error();
        }
        radiation = {read->direct / samples, read->diffuse / samples};
      } else if (sine > 1e-3) {
        const double passed = core::pow(configuration_.number("atmosphere"), 1.0 / sine);
        const double outside = solarIrradiance(day) / samples;
        radiation = {outside * passed, 0.3 * (1.0 - passed) * outside * sine};
      }
      const double part = span.part / static_cast<double>(days);
      const double direct = radiation.direct * part;
      const double diffuse = radiation.diffuse * part;
      const Vec3& middle = hasMeasured_ && !(sine > kLowestSine) ? up_ : direction;
      if (days > 1) {
        sun = sun + direction * direct;
        sky = sky + middle * diffuse;
        ofSky += diffuse;
      } else {
        if (direct > 0.0) {
          incoming.suns.push_back({direction, direct});
        }
        if (diffuse > 0.0) {
          incoming.skies.push_back({middle, diffuse});
        }
      }
    }
    // the one sun gives a horizontal plane as much as all suns of this hour
    if (core::length(sun) > 0.0) {
      incoming.suns.push_back({core::normalised(sun), core::length(sun)});
    }
    if (ofSky > 0.0) {
      incoming.skies.push_back({core::normalised(sky), ofSky});
    }
  }
  return std::nullopt;
}

tl::expected<Daylight::Radiation, std::string> Daylight::measured(double from, double to, double sine) const {
  const turtle::Weather& weather = *world_.weather;
  std::array<double, 3> values{};
  constexpr std::array<std::string_view, 3> kNames{"global", "direct", "diffuse"};
  for (std::size_t k = 0; k < 3; ++k) {
    if (weather.has(kNames[k])) {
      const auto mean = weather.mean(kNames[k], from, to);
      if (!mean) {
        return tl::unexpected(turtle::missingWeather(world_, kNames[k], from, to));
      }
      values[k] = *mean;
    }
  }
  const auto& [global, direct, diffuse] = values;
  const bool isUp = sine > kLowestSine;
  if (weather.has("global") && !weather.has("direct") && !weather.has("diffuse") && sun_ == "none") {
    return Radiation{0.0, global};
  }
  if (weather.has("direct") && weather.has("diffuse")) {
    return Radiation{isUp ? direct : 0.0, diffuse};
  }
  if (!weather.has("global") || !(weather.has("direct") || weather.has("diffuse"))) {
    return tl::unexpected(std::string(
        "needs two of the weather's global, direct and diffuse radiation: one alone does not say how much comes from "
        "the sun. Add a column."));
  }
  // global = direct · sine + diffuse; of a sun at the horizon or below everything is the sky's
  if (!isUp) {
    return Radiation{0.0, global};
  }
  return weather.has("diffuse") ? Radiation{std::max(global - diffuse, 0.0) / sine, std::min(diffuse, global)}
                                : Radiation{direct, std::max(global - direct * sine, 0.0)};
}

}  // namespace espalier::environment
