// Sun, sky, weather and bands of the process `light-voxels`, which it shares with `light`.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "engine/core/elementary.h"
#include "engine/turtle/weather.h"
#include "environment/base/number_text.h"
#include "environment/light/sky.h"
#include "environment/light/sun_position.h"
#include "tests/environment/light/stand.h"

namespace espalier::environment::voxel_sources_test {
namespace {

/// A box of one voxel of side 1 full of leaves, with a leaf area index, that repeats itself.
std::string slab(double index, const std::string& more) {
  return R"({"gridSize":[1,1,1],"voxelSize":1,"position":[0,0,0],"periodic":true,"leafAreaDensity":[)" +
         numberText(index) + "]," + more + "}";
}

turtle::EnvironmentContext place(double latitude, const std::string& start, double stepDays = 1.0) {
  turtle::EnvironmentContext context;
  context.world.latitudeDegrees = latitude;
  context.world.longitudeDegrees = 0.0;
  context.world.start = start;
  context.world.stepDurationDays = stepDays;
  return context;
}

void addWeather(turtle::EnvironmentContext& context, const std::string& table) {
  auto weather = turtle::Weather::read(table, context.world.start);
  ASSERT_TRUE(weather.has_value()) << weather.error();
  context.world.weather = std::make_shared<const turtle::Weather>(std::move(*weather));
}

/// The answers to queries at a height, without leaves of their own, in the step at a time.
std::vector<double> answersAt(double height, const std::string& configuration,
                              const turtle::EnvironmentContext& context = {}, double timeDays = 0.0,
                              std::size_t count = 1) {
  const auto process = openProcess("light-voxels", configuration, context);
  QueryBuilder builder;
  builder.add({0.5, height, 0.5}, std::vector<double>(count, 0.0));
  builder.batch().timeDays = timeDays;
  return valuesOf(answersOf(*process, builder.batch())[0]);
}

/// 2 E₃(x), the part of a uniform sky that black leaves of the depth x let through, by the midpoint rule.
double passedUniformSky(double x) {
  double sum = 0.0;
  constexpr int kSteps = 100'000;
  for (int i = 0; i < kSteps; ++i) {
    const double cosine = (i + 0.5) / kSteps;
    sum += 2.0 * cosine * core::exp(-x / cosine) / kSteps;
  }
  return sum;
}

const std::string kManyAngles = R"("zenithAngles":24,"azimuthAngles":24)";

TEST(VoxelSources, TheSunPassesASlabByBeersLawAndTheSkyByTheExponentialIntegral) {
  // spherical leaves of index 2 under a sun at 60° from the zenith: direct · ½ · e^(−2) + diffuse · 2 E₃(1)
  const std::string sun = R"("sun":"direction","sunDirection":[0.8660254037844386,0.5,0],"directIrradiance":600,)"
                          R"("diffuseIrradiance":100,"sky":"uniform",)" +
                          kManyAngles;
  EXPECT_NEAR(answersAt(1.5, slab(2, sun))[0], 400, 1e-9);
  EXPECT_NEAR(answersAt(0.0, slab(2, sun))[0], 300 * core::exp(-2.0) + 100 * passedUniformSky(1.0), 0.01);
  // a mean over azimuths is the same in a slab
  EXPECT_NEAR(answersAt(0.0, slab(2, sun + R"(,"sunAzimuths":5)"))[0], answersAt(0.0, slab(2, sun))[0], 1e-9);
  // and a unit of leaf area in the light above absorbs G/cos θ of the irradiance: G · 600 of the sun
  EXPECT_NEAR(
      answersAt(1.5, slab(2, R"("diffuseIrradiance":0,)" + sun.substr(0, sun.find(R"("diffuse)")) + kManyAngles), {},
                0.0, 5)[4],
      300, 1e-9);
}

TEST(VoxelSources, TheSunOfAStepIsItsMean) {
  // without air there is no sky: of each hour the irradiance I sin h and e^(−½ L/sin h) of it below black leaves
  constexpr double kIndex = 1.0;
  const auto context = place(40.0, "2026-04-10");
  double open = 0.0;
  double below = 0.0;
  for (int hour = 0; hour < 24; ++hour) {
    const double day = *julianDayOf("2026-04-12") + (hour + 0.5) / 24.0;
    const double sine = core::sin(sunPosition(day, 40.0, 0.0).elevationRadians);
    if (sine > 1e-3) {
      open += solarIrradiance(day) * sine / 24.0;
      below += solarIrradiance(day) * sine * core::exp(-0.5 * kIndex / sine) / 24.0;
    }
  }
  const std::string sun = R"("sun":"position","atmosphere":1)";
  EXPECT_NEAR(answersAt(1.5, slab(kIndex, sun), context, 2.0)[0], open, 1e-9 * open);
  EXPECT_NEAR(answersAt(0.0, slab(kIndex, sun), context, 2.0)[0], below, 1e-9 * open);
  EXPECT_GT(below, 0.3 * open);
  // more parts of the day change little, and one part is the noon only
  const double fine = answersAt(0.0, slab(kIndex, sun + R"(,"sunSamples":480)"), context, 2.0)[0];
  EXPECT_NEAR(fine, below, 0.005 * below);
  EXPECT_GT(answersAt(0.0, slab(kIndex, sun + R"(,"sunSamples":1)"), context, 2.0)[0], 1.5 * fine);
}

TEST(VoxelSources, PhotonsOfSunlightNeedBands) {
  const auto context = place(51.0, "2026-06-21T11:00Z", 1.0 / 24.0);
  const std::string sun = R"("sun":"position","unit":"umol")";
  for (const std::string process : {"light", "light-voxels"}) {
    const auto keys = [&](const std::string& more) {
      return process == "light" ? "{" + sun + more + "}" : slab(0, sun + more);
    };
    const auto refused = (*makeProcess(process, keys("")))->open(context);
    ASSERT_TRUE(refused) << process;
    EXPECT_NE(refused->message.find("Give 'bands', such as [0.5,0.5]"), std::string::npos) << refused->message;
    EXPECT_FALSE((*makeProcess(process, keys(R"(,"photonsPerJoule":2.1)")))->open(context)) << process;
    // nowhere on earth has more than about 2500 umol/(m2 s) of photosynthetically active light
    const auto halves = openProcess(process, keys(R"(,"bands":[0.5,0.5])"), context);
    QueryBuilder sensor;
    sensor.add({0.5, 5, 0.5}, std::vector<double>(10, 0.0));
    const double photons = *answersOf(*halves, sensor.batch())[0][process == "light" ? 2 : 0];
    EXPECT_GT(photons, 1500.0);
    EXPECT_LT(photons, 2500.0);
  }
}

TEST(VoxelSources, InTheOpenItHasTheIrradianceOfTheProcessLight) {
  const std::string table =
      "time,global,diffuse\n2026-06-21T00:00Z,0,0\n2026-06-21T06:00Z,300,120\n2026-06-21T12:00Z,650,200\n"
      "2026-06-21T18:00Z,90,70\n2026-06-22T00:00Z,0,0\n2026-06-22T06:00Z,250,250\n2026-06-22T12:00Z,100,100\n"
      "2026-06-22T18:00Z,0,0\n2026-06-23T00:00Z,0,0\n";
  for (const std::string keys :
       {R"("sun":"position")", R"("sun":"position","sky":"clear")", R"("sun":"position","sunSamples":5)",
        R"("sun":"direction","sunDirection":[1,2,0.5],"sky":"uniform")",
        R"("sun":"position","unit":"umol","bands":[0.5,0.4],"photonsPerJoule":[4.57,0])",
        R"("sun":"position","unit":"mol","bands":[0.5,0.5],"photonsPerJoule":[4.57,0])"}) {
    for (const double step : {0.25, 1.0, 1.5}) {
      for (const bool hasWeather : {false, true}) {
        auto context = place(51.0, "2026-06-21T00:00Z", step);
        if (hasWeather) {
          addWeather(context, table);
        }
        const auto light = openProcess("light", "{" + keys + "}", context);
        QueryBuilder sensor;
        sensor.add({0, 2, 0}, {0, 0, 0, 0, 0, 0, 0});
        sensor.batch().timeDays = step >= 1.0 ? 0.0 : step;
        const auto expected = answersOf(*light, sensor.batch())[0];
        const auto found = answersAt(2.0, slab(1, keys), context, sensor.batch().timeDays, 6);
        EXPECT_NEAR(found[0], *expected[2], 1e-9 * *expected[2]) << keys << step << hasWeather;
        EXPECT_GT(found[0], 0.0);
        if (keys.find("bands") != std::string::npos) {
          EXPECT_EQ(found[5], 0.0) << "a band without photons of its own";
        }
      }
    }
  }
}

TEST(VoxelSources, TheWeatherTakesThePlaceOfConstants) {
  auto context = place(51.0, "2026-06-21T00:00Z", 0.25);
  addWeather(context, "time,global\n0,10\n0.25,40\n0.5,70\n0.75,0\n1,0\n");
  // without a sun all of it is the sky's, whatever `irradiance` says
  for (int quarter = 0; quarter < 3; ++quarter) {
    EXPECT_NEAR(answersAt(1.5, slab(1, R"("irradiance":5)"), context, 0.25 * quarter)[0], 10 + 30 * quarter, 1e-9);
  }
  EXPECT_NEAR(answersAt(0.0, slab(2, R"("sky":"uniform",)" + kManyAngles), context, 0.25)[0], 40 * passedUniformSky(1),
              0.01);
  // parts of the light do not depend on it
  EXPECT_EQ(answersAt(1.5, slab(1, R"("unit":"relative")"), context, 0.5)[0],
            answersAt(1.5, slab(1, R"("unit":"relative")"))[0]);
  // a time that the table does not cover is an error, and what was there stays
  auto made = makeProcess("light-voxels", slab(1, R"("irradiance":5)"));
  ASSERT_FALSE((*made)->open(context));
  QueryBuilder late;
  late.add({0, 2, 0}, {0});
  late.batch().timeDays = 30.0;
  turtle::ReplyBatch replies;
  replies.prepare(late.batch());
  const auto error = (*made)->step(late.batch(), replies);
  ASSERT_TRUE(error);
  EXPECT_EQ(error->message.find("Environment 'light-voxels' needs the weather from day 30 to day 30.25"), 0U)
      << error->message;
  late.batch().timeDays = 0.25;
  EXPECT_NEAR(*answersOf(**made, late.batch())[0][0], 40, 1e-9);
}

TEST(VoxelSources, AClearSkyIsBrightestAroundTheSunAndGivesAPlaneItsIrradiance) {
  // below black spherical leaves of index 1: ∫ L e^(−½/cos θ) cos θ dω over ∫ L cos θ dω, by the midpoint rule
  const core::Vec3 sun{0.866025403784, 0.5, 0};
  double level = 0.0;
  double below = 0.0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const double height = (i + 0.5) / kSteps;
    const double width = std::sqrt(1.0 - height * height);
    for (int k = 0; k < kSteps; ++k) {
      const double angle = 2.0 * std::numbers::pi * (k + 0.5) / kSteps;
      const core::Vec3 direction{width * core::cos(angle), height, width * core::sin(angle)};
      const double radiance = skyRadiance(SkyKind::Clear, height, core::dot(direction, sun), sun.y);
      level += radiance * height;
      below += radiance * height * core::exp(-0.5 / height);
    }
  }
  const std::string sky = R"("sky":"clear","sun":"direction","sunDirection":[0.866025403784,0.5,0],)"
                          R"("directIrradiance":0,"diffuseIrradiance":100,)" +
                          kManyAngles;
  EXPECT_NEAR(answersAt(1.5, slab(1, sky))[0], 100, 1e-9);
  EXPECT_NEAR(answersAt(0.0, slab(1, sky))[0], 100 * below / level, 0.05);
  // with few angles too, within 0.005 of the light
  EXPECT_NEAR(answersAt(0.0, slab(1, sky.substr(0, sky.find(R"(,"zenithAngles)"))))[0], 100 * below / level, 0.5);
  EXPECT_GT(
      std::abs(answersAt(0.0, slab(1, R"("sky":"uniform","irradiance":100,)" + kManyAngles))[0] - 100 * below / level),
      0.5)
      << "other skies are no substitute";
}

TEST(VoxelSources, LeavesDimEachBandByItsAbsorptance) {
  // Goudriaan: e^(−√α ½ L) from straight above
  const std::string sun = R"("sun":"direction","diffuseIrradiance":0,"directIrradiance":100,"bands":[0.5,0.3,0.2],)";
  const auto found = answersAt(0.0, slab(2, sun + R"("absorptance":[0.81,0.25,0.81])"), {}, 0.0, 15);
  EXPECT_NEAR(found[0], 50 * core::exp(-0.9), 1e-9);
  EXPECT_NEAR(found[5], 30 * core::exp(-0.5), 1e-9);
  EXPECT_NEAR(found[10], 20 * core::exp(-0.9), 1e-9);
  EXPECT_NEAR(found[4], 50 * 0.9 * 0.5 * core::exp(-0.9), 1e-9);
  EXPECT_NEAR(found[9], 30 * 0.5 * 0.5 * core::exp(-0.5), 1e-9);
  // from spectra: leaves take what they do not scatter
  const std::string spectra = R"("bandLimits":[[400,500],[500,600]],"lightSpectrum":[[400,1],[600,1]],)"
                              R"("leafSpectrum":[[400,0.1,0.09],[500,0.1,0.09],[500.001,0.5,0.25],[600,0.5,0.25]])";
  const auto fromSpectra = answersAt(0.0, slab(2, sun.substr(0, sun.find(R"("bands)")) + spectra), {}, 0.0, 10);
  EXPECT_NEAR(fromSpectra[0], 50 * core::exp(-0.9), 1e-3);
  EXPECT_NEAR(fromSpectra[5], 50 * core::exp(-0.5), 1e-3);
}

TEST(VoxelSources, EachBandScattersAsItWouldAlone) {
  const std::string leaves = R"("scattering":true,"sky":"uniform","irradiance":200,"sensor":"fluxes",)";
  const auto both = answersAt(2.0,
                              slab(2, leaves + R"("bands":[0.25,0.5],"reflectance":[0.07,0.4],"transmittance":)"
                                               R"([0.05,0.4],"groundReflectance":[0.1,0.6])"),
                              {}, 0.0, 10);
  for (const auto& [band, part, alone] :
       {std::tuple<std::size_t, double, std::string>{
            0, 0.25, R"("reflectance":0.07,"transmittance":0.05,"groundReflectance":0.1)"},
        {1, 0.5, R"("reflectance":[0.4],"transmittance":[0.4],"groundReflectance":[0.6])"}}) {
    const auto expected = answersAt(2.0, slab(2, leaves + alone), {}, 0.0, 5);
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_NEAR(both[5 * band + k], part * expected[k], 1e-12 * 200) << band << k;
    }
    // up, plants and ground are what comes in
    EXPECT_NEAR(both[5 * band] + both[5 * band + 2] + both[5 * band + 3], both[5 * band + 4], 0.02);
    EXPECT_NEAR(both[5 * band + 4], part * 200, 1e-9);
  }
  EXPECT_GT(both[5] / both[9], 3 * both[0] / both[4]) << "leaves are bright in the second band";
}

TEST(VoxelSources, FieldsAndDescriptionNameBandsAndUnits) {
  auto context = place(51.0, "2026-06-21");
  const auto process = openProcess(
      "light-voxels", slab(1, R"("sun":"position","unit":"umol","bands":[0.5,0.5],"scattering":true)"), context);
  const auto description = process->describe();
  ASSERT_EQ(description.outputs.size(), 10U);
  EXPECT_EQ(description.outputs[5].name, "light2");
  EXPECT_EQ(description.outputs[5].unit, "umol/(m^2 s)");
  EXPECT_EQ(description.outputs[6].unit, "umol/(m^2 s)/m");
  answersOf(*process, QueryBuilder().add({0.5, 0.5, 0.5}, {0}).batch());
  std::vector<std::string> names;
  for (const turtle::Field& field : process->fields()) {
    names.push_back(field.name + " " + field.unit);
  }
  EXPECT_EQ(names[0], "light1 umol/(m^2 s)");
  EXPECT_EQ(names[1], "light2 umol/(m^2 s)");
  EXPECT_EQ(names[2], "leafAreaDensity 1/m");
  EXPECT_EQ(names[3], "incoming1 umol/(m^2 s)");
  EXPECT_GT(fieldValue(*process, "incoming2"), 100.0);
  // relative light, or light in the user's own unit, has none
  EXPECT_EQ(openProcess("light-voxels", "")->describe().outputs[0].unit, "1");
  EXPECT_EQ(openProcess("light-voxels", R"({"sun":"direction"})")->describe().outputs[0].unit, "W/m^2");
  addWeather(context, "time,global\n0,100\n1,200\n");
  EXPECT_EQ(openProcess("light-voxels", "", context)->describe().outputs[0].unit, "W/m^2");
  EXPECT_EQ(openProcess("light-voxels", R"({"unit":"relative"})", context)->describe().outputs[0].unit, "1");
}

TEST(VoxelSources, UnitsFollowFromWatts) {
  const std::string sun = R"("sun":"direction","diffuseIrradiance":50,"directIrradiance":100)";
  const double watts = answersAt(0.0, slab(1, sun))[0];
  EXPECT_NEAR(answersAt(0.0, slab(1, sun + R"(,"unit":"umol")"))[0], 4.57 * watts, 1e-9);
  EXPECT_NEAR(answersAt(0.0, slab(1, sun + R"(,"unit":"mol")"))[0], 4.57 * 0.0864 * watts, 1e-9);
  EXPECT_NEAR(answersAt(0.0, slab(1, sun + R"(,"unit":"relative")"))[0], watts / 150, 1e-12);
  EXPECT_NEAR(answersAt(2.0, slab(1, sun + R"(,"unit":"relative","bands":[0.5,0.2])"), {}, 0.0, 6)[5], 1.0, 1e-12)
      << "a part of the light of its band";
  // at night there is none
  const auto night = place(51.0, "2026-06-21T00:00Z", 1.0 / 24);
  for (const std::string unit : {"W", "relative"}) {
    EXPECT_EQ(answersAt(0.0, slab(1, R"("sun":"position","scattering":true,"unit":")" + unit + "\""), night, 0.0, 5),
              std::vector<double>(5, 0.0));
  }
}

TEST(VoxelSources, AMovingSunLeavesTheLightOfANewProcessBitByBit) {
  const auto context = place(51.0, "2026-06-21T08:00Z", 1.0 / 24);
  const std::string box = R"({"gridSize":[6,6,6],"voxelSize":1,"position":[0,0,0],"periodic":true,"zenithAngles":2,)";
  for (const std::string keys :
       {R"("sun":"position","sunSamples":3})",
        R"("sun":"position","sky":"clear","bands":[0.5,0.5],"absorptance":[1,0.5]})",
        R"("sun":"direction","sunDirection":[1,2,1],"bands":[0.5,0.5],"absorptance":[1,0.5]})"}) {
    const auto following = openProcess("light-voxels", box + keys, context);
    Stand random;
    std::vector<core::Vec3> places;
    for (int i = 0; i < 60; ++i) {
      places.push_back({6 * random.random(), 6 * random.random(), 6 * random.random()});
    }
    // into the night, in which the number of suns changes, and out of it
    for (const double hour : {0.0, 1.0, 2.0, 11.5, 16.0, 23.0, 24.0}) {
      QueryBuilder builder;
      places[7] = {6 * random.random(), 6 * random.random(), 6 * random.random()};
      for (std::size_t i = 0; i < places.size(); ++i) {
        std::vector<double> parameters(i % 2 == 0 ? 10U : 1U, 0.0);
        parameters[0] = i % 3 == 0 ? 0.0 : 0.2;
        builder.add(places[i], parameters);
      }
      builder.batch().timeDays = hour / 24;
      EXPECT_EQ(answersOf(*following, builder.batch()),
                answersOf(*openProcess("light-voxels", box + keys, context), builder.batch()))
          << hour << keys;
    }
  }
}

TEST(VoxelSources, AStandThatIsTurnedWithItsNorthKeepsItsFluxes) {
  // z to x and x to −z, the compass with it
  const auto fluxes = [](bool isTurned, const std::string& keys) {
    auto context = place(51.0, "2026-06-21T09:00Z", 1.0 / 24);
    context.world.north = isTurned ? core::Vec3{-1, 0, 0} : core::Vec3{0, 0, -1};
    std::string densities;
    for (int z = 0; z < 3; ++z) {
      for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < 3; ++x) {
          const int number = isTurned ? 9 * x + 3 * y + (2 - z) : 9 * z + 3 * y + x;
          densities += (densities.empty() ? "" : ",") + std::to_string(number * number % 7);
        }
      }
    }
    const auto process = openProcess(
        "light-voxels",
        R"({"gridSize":[3,3,3],"voxelSize":1,"position":[0,0,0],"periodic":true,"scattering":true,"sensor":"fluxes",)"
        R"("reflectance":0.3,"transmittance":0.3,"leafAreaDensity":[)" +
            densities + "]," + keys + "}",
        context);
    return valuesOf(answersOf(*process, QueryBuilder().add({0, 4, 0}, {0, 0, 0, 0, 0}).batch())[0]);
  };
  for (const std::string keys : {R"("sun":"position","sky":"overcast")", R"("sun":"position","sky":"clear")"}) {
    const auto before = fluxes(false, keys);
    const auto after = fluxes(true, keys);
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_NEAR(before[k], after[k], 1e-9 * before[4]) << k << keys;
    }
  }
}

TEST(VoxelSources, WhatCannotBeIsAnError) {
  EXPECT_EQ(errorsOf(makeProcess("light-voxels", R"({"directions":[[0,1,0,1]],"sun":"direction"})")),
            "error: environment process 'light-voxels': 'directions' and 'sun' both say where light comes from\n"
            "   hint: leave one of the two out");
  EXPECT_EQ(errorsOf(makeProcess("light-voxels", R"({"sky":"clear"})")),
            "error: environment process 'light-voxels': a clear 'sky' is brightest around the sun, and 'sun' is none\n"
            "   hint: set sun to direction or position");
  EXPECT_EQ(errorsOf(makeProcess("light-voxels", R"({"bands":[0.5,0.5],"absorptance":[1,0.9,0.8]})")),
            "error: environment process 'light-voxels': 'absorptance' has 3 numbers for 2 bands\n"
            "   hint: give one number for each band, or one for all");
  EXPECT_EQ(errorsOf(makeProcess("light-voxels", R"({"reflectance":"white"})")),
            "error: environment process 'light-voxels': 'reflectance' must be a list of at least 1 numbers, or a "
            "number, found the text 'white'\n   hint: reflectance: part of the light that organs reflect, in each "
            "band, or one "
            "number for all");
  EXPECT_EQ(
      errorsOf(makeProcess("light-voxels", R"({"reflectance":1.5})")).find("'reflectance' must be between 0 and 1"),
      errorsOf(makeProcess("light-voxels", R"({"reflectance":1.5})")).find("'reflectance'"));
  auto made = makeProcess("light-voxels", R"({"sun":"position"})");
  EXPECT_EQ((*made)->open({})->message,
            "Environment 'light-voxels' needs to know where and when it is for the position of the sun: set "
            "'latitude', 'longitude' and 'start', here or in the world (\"2026-06-21T12:00\" in universal time, or "
            "with an offset: +02:00).");
  made = makeProcess("light-voxels", R"({"sun":"direction","sunDirection":[1,-1,0]})");
  EXPECT_EQ((*made)->open({})->message,
            "Environment 'light-voxels' has its sun below the horizon. Give a 'sunDirection' that points up to the "
            "sun.");
  made = makeProcess("light-voxels", R"({"sun":"direction","sunDirection":[1,0,0]})");
  EXPECT_EQ((*made)->open({})->message,
            "Environment 'light-voxels' has its sun at the horizon. Give a 'sunDirection' that points up to the sun.");
  made = makeProcess("light-voxels", R"({"sun":"direction","sunDirection":[0,0,0]})");
  EXPECT_EQ((*made)->open({})->message,
            "Environment 'light-voxels' has a 'sunDirection' of length 0. Give the direction that points up to the "
            "sun.");
}

}  // namespace
}  // namespace espalier::environment::voxel_sources_test
