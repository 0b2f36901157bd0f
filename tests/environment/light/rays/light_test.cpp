#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/core/work_meter.h"
#include "engine/turtle/field.h"
#include "engine/turtle/scene/geometry.h"
#include "environment/light/sun_position.h"
#include "tests/environment/query_builder.h"
#include "tests/environment/stops_after.h"

namespace espalier::environment::light_test {
namespace {

/// Geometry of leaves, each a triangle with half of the area of a square of a given side, drawn by the modules 1, 3, 5
/// …
class LeafScene {
 public:
  /// A horizontal one at a height, its front side up.
  LeafScene& leaf(const core::Vec3& corner, double side, std::uint8_t colour = 0) {
    const auto base = static_cast<std::uint32_t>(geometry_.vertices.size());
    geometry_.vertices.insert(geometry_.vertices.end(),
                              {corner, corner + core::Vec3{0, 0, side}, corner + core::Vec3{side, 0, 0}});
    geometry_.triangles.push_back({base, base + 1, base + 2});
    geometry_.vertexOffset.push_back(geometry_.vertices.size());
    geometry_.triangleOffset.push_back(geometry_.triangles.size());
    geometry_.kind.push_back(turtle::GeometryKind::Polygon);
    geometry_.organs.plant.push_back(0);
    geometry_.organs.module.push_back(2 * geometry_.kind.size() - 1);
    geometry_.organs.symbol.push_back(1);
    geometry_.organs.colour.push_back(colour);
    geometry_.organs.branchOrder.push_back(0);
    return *this;
  }
  /// The same as a line.
  LeafScene& segment(const core::Vec3& from, const core::Vec3& to, double width, std::uint64_t module) {
    geometry_.start.push_back(from);
    geometry_.end.push_back(to);
    geometry_.startWidth.push_back(width);
    geometry_.endWidth.push_back(width);
    geometry_.segments.plant.push_back(0);
    geometry_.segments.module.push_back(module);
    geometry_.segments.symbol.push_back(1);
    geometry_.segments.colour.push_back(0);
    geometry_.segments.branchOrder.push_back(0);
    return *this;
  }
  /// A query before each leaf, and before the module `more` when it is given.
  [[nodiscard]] ReplyTable answers(turtle::EnvironmentProcess& process, std::size_t parameterCount = 4,
                                   std::optional<std::uint64_t> more = std::nullopt) const {
    return answersOf(process, queries(parameterCount, more));
  }
  [[nodiscard]] turtle::QueryBatch queries(std::size_t parameterCount = 4,
                                           std::optional<std::uint64_t> more = std::nullopt) const {
    QueryBuilder builder;
    for (std::size_t leaf = 0; leaf < geometry_.kind.size(); ++leaf) {
      builder.add({0, 50, 0}, std::vector<double>(parameterCount, 0.0));
      builder.batch().module.back() = 2 * leaf;
    }
    if (more) {
      builder.add({0, 50, 0}, std::vector<double>(parameterCount, 0.0));
      builder.batch().module.back() = *more - 1;
    }
    builder.batch().geometry = std::make_shared<turtle::Geometry>(geometry_);
    return builder.batch();
  }

 private:
  turtle::Geometry geometry_;
};

TEST(Light, AStepThatIsGivenUpLeavesNoHalfTracedRays) {
  LeafScene scene;
  LeafScene later;
  for (int i = 0; i < 600; ++i) {
    const core::Vec3 corner{static_cast<double>(i % 7), 0.1 * i, static_cast<double>(i % 5)};
    scene.leaf(corner, 2);
    later.leaf(i % 9 == 0 ? corner + core::Vec3{0.3, 0, 0} : corner, 2);
  }
  for (const std::string threads : {"1", "2"}) {
    const std::string configuration = R"({"diffuseIrradiance":300,"directions":64,"threads":)" + threads + "}";
    const auto expected = later.answers(*openProcess("light", configuration));
    for (const int asked : {0, 1, 2}) {
      const auto process = openProcess("light", configuration);
      (void)scene.answers(*process);
      StopsAfter meter(asked);
      {
        const core::WorkMeter::Scope scope(&meter);
        const turtle::QueryBatch queries = later.queries();
        turtle::ReplyBatch replies;
        replies.prepare(queries);
        EXPECT_THROW((void)process->step(queries, replies), core::WorkStopped) << threads << asked;
      }
      EXPECT_EQ(later.answers(*process), expected) << threads << asked;
    }
  }
}

TEST(Light, AHorizontalLeafGetsTheIrradianceOfTheOpenSky) {
  const std::string configuration = R"({"diffuseIrradiance":300,"reflectance":[0.1],"transmittance":[0.2]})";
  const auto row = LeafScene().leaf({0, 1, 0}, 2).answers(*openProcess("light", configuration))[0];
  EXPECT_NEAR(*row[0], 300 * 0.7, 1e-9);
  EXPECT_NEAR(*row[1], 300 * 0.7 * 2, 1e-9);
  EXPECT_NEAR(*row[2], 300, 1e-9);
  EXPECT_NEAR(*row[3], 600, 1e-9);
  // in a world of centimetres the leaf is ten thousand times smaller, and the light on a square metre the same
  turtle::EnvironmentContext context;
  context.world.lengthUnit = "cm";
  const auto small = LeafScene().leaf({0, 1, 0}, 2).answers(*openProcess("light", configuration, context))[0];
  EXPECT_NEAR(*small[0], 300 * 0.7, 1e-9);
  EXPECT_NEAR(*small[1], 300 * 0.7 * 2e-4, 1e-12);
}

TEST(Light, PhotonsAreCountedByTheirBands) {
  const auto process = openProcess(
      "light",
      R"({"diffuseIrradiance":100,"bands":[0.45,0.55],"unit":"umol","photonsPerJoule":[4.57,7],"reflectance":[0.1,0.4],)"
      R"("transmittance":[0],"materials":[[9,0.5,0.5,0,0]]})");
  const auto table = LeafScene().leaf({0, 1, 0}, 1).leaf({50, 1, 0}, 1, 9).answers(*process, 8);
  EXPECT_NEAR(*table[0][0], 45 * 4.57 * 0.9, 1e-9);
  EXPECT_NEAR(*table[0][2], 45 * 4.57, 1e-9);
  EXPECT_NEAR(*table[0][4], 55 * 7 * 0.6, 1e-9);
  EXPECT_EQ(table[1][0], 0.0);
  EXPECT_NEAR(*table[1][4], 55 * 7, 1e-9);
}

TEST(Light, ALeafShadesTheOneBelow) {
  const auto process = openProcess(
      "light",
      R"({"sun":"direction","directIrradiance":1000,"diffuseIrradiance":0,"bounces":0,"sunDirection":[3,4,0]})");
  // the wide one is 4 above: with the sun at (3, 4) its shade lies 3 to the left
  const auto table = LeafScene().leaf({-4, 4, -1}, 8).leaf({-3, 0, 1}, 1).leaf({-12, 0, 1}, 1).answers(*process);
  EXPECT_NEAR(*table[0][2], 800, 1e-9);
  EXPECT_EQ(table[1][2], 0.0);
  EXPECT_NEAR(*table[2][2], 800, 1e-9);
}

TEST(Light, ASegmentGetsLightOnItsMantle) {
  // a thin upright stem under a uniform sky: every strip sees half of the sky, E/2 on the upright plane
  const auto process =
      openProcess("light", R"({"sky":"uniform","diffuseIrradiance":100,"directions":4096,"bounces":0})");
  const auto row = LeafScene().segment({0, 0, 0}, {0, 2, 0}, 0.1, 7).answers(*process, 4, 7)[0];
  EXPECT_NEAR(*row[2], 50, 1.5);
  EXPECT_NEAR(*row[3] / *row[2], std::numbers::pi * 0.1 * 2, 1e-6);
}

TEST(Light, WithoutAnOrganBehindItAQueryIsASensor) {
  const auto process = openProcess(
      "light",
      R"({"sun":"direction","directIrradiance":500,"diffuseIrradiance":100,"sunDirection":[0,1,0],"bounces":0})");
  LeafScene scene;
  scene.leaf({-100, 60, -100}, 200);
  const auto row = scene.answers(*process, 4, 99)[1];
  EXPECT_EQ(row[0], 0.0);
  EXPECT_LT(*row[2], 60) << "the query is at (0, 50, 0), below the edge of a wide leaf";
  // and in the open
  const auto open = answersOf(*process, QueryBuilder().add({0, 0, 0}, {0, 0, 0, 0}).batch())[0];
  EXPECT_NEAR(*open[2], 600, 1e-9);
}

TEST(Light, ASmallOrganAndASensorGetTheLightThatALargeOneScatters) {
  // under a white screen that lets half of the light through, which fills the plot; its rays hardly ever meet the leaf
  for (const char* way : {R"("remainder":1e-3)", R"("bounces":5)"}) {
    const auto process = openProcess(
        "light",
        std::string(R"({"sun":"direction","sunDirection":[0,1,0],"directIrradiance":200,"diffuseIrradiance":0,)"
                    R"("plot":[0,2,0,2],"materials":[[1,0,0.5],[2,0,0]],)") +
            way + "}");
    LeafScene scene;
    // two triangles are a square
    scene.leaf({0, 60, 0}, 4, 1).leaf({0.9, 40, 0.9}, 0.02, 2);
    const auto table = scene.answers(*process, 4, 99);
    EXPECT_NEAR(*table[1][2], 100, 0.5) << way;
    // the query is 10 below the screen
    EXPECT_NEAR(*table[2][2], 100, 0.5) << way;
  }
}

TEST(Light, TheSunOfADayIsItsMean) {
  // on the equator at the equinox, without air, a horizontal plane gets S/π in the mean of the day
  turtle::EnvironmentContext context;
  context.world.latitudeDegrees = 0;
  context.world.longitudeDegrees = 30;
  context.world.start = "2024-03-20";
  const auto process = openProcess("light", R"({"sun":"position","atmosphere":1,"sunSamples":1000})", context);
  const auto row = answersOf(*process, QueryBuilder().add({0, 0, 0}, {0, 0, 0, 0}).batch())[0];
  EXPECT_NEAR(*row[2] / (solarIrradiance(*julianDayOf("2024-03-20")) / std::numbers::pi), 1.0, 0.002);
  // far north in winter there is none, whatever the world says
  const auto winter =
      openProcess("light", R"({"sun":"position","start":"2024-12-20","latitude":80,"longitude":10})", context);
  EXPECT_EQ(answersOf(*winter, QueryBuilder().add({0, 0, 0}, {0, 0, 0}).batch())[0][2], 0.0);
}

TEST(Light, TheSunIsKnownUpToTheYear9999) {
  const auto process =
      openProcess("light", R"({"sun":"position","start":"9999-12-31","latitude":51,"longitude":7,"sunSamples":1})");
  QueryBuilder builder;
  builder.add({0, 0, 0}, {0, 0, 0});
  turtle::ReplyBatch replies;
  replies.prepare(builder.batch());
  EXPECT_FALSE(process->step(builder.batch(), replies).has_value());
  builder.batch().timeDays = 1.0;
  const auto error = process->step(builder.batch(), replies);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message,
            "Environment 'light' knows the position of the sun up to the year 9999, and the step that begins on day 1 "
            "ends later. Make fewer steps, or shorter ones (the world's 'stepDuration').");
}

TEST(Light, TheSunOfALongStepIsTheMeanOfItsDays) {
  const auto horizontal = [](double days, const std::string& start) {
    turtle::EnvironmentContext context;
    context.world.latitudeDegrees = 51;
    context.world.longitudeDegrees = 0;
    context.world.start = start;
    context.world.stepDurationDays = days;
    const auto process = openProcess("light", R"({"sun":"position"})", context);
    return *answersOf(*process, QueryBuilder().add({0, 0, 0}, {0, 0, 0, 0}).batch())[0][2];
  };
  // 24 samples of 24 days would all be at the same hour
  double sum = 0.0;
  for (int day = 1; day <= 24; ++day) {
    sum += horizontal(1.0, "2026-06-" + std::string(day < 10 ? "0" : "") + std::to_string(day));
    if (day == 8 || day == 12 || day == 24) {
      EXPECT_NEAR(horizontal(day, "2026-06-01") / (sum / day), 1.0, 1e-3) << day;
    }
  }
  // a year has all seasons, and half a day more counts as half a day
  const double year = horizontal(365.0, "2026-01-01");
  EXPECT_GT(year, 0.45 * horizontal(1.0, "2026-06-21"));
  EXPECT_LT(year, 0.6 * horizontal(1.0, "2026-06-21"));
  const double nights = horizontal(1.0, "2026-06-01") + 0.5 * horizontal(0.5, "2026-06-02");
  EXPECT_NEAR(horizontal(1.5, "2026-06-01"), nights / 1.5, 1e-6 * nights);
}

TEST(Light, PlaceAndTimeAreEachItsOwnOrTheWorlds) {
  const auto noon = [](const std::string& configuration, std::optional<double> latitude, const std::string& start) {
    turtle::EnvironmentContext context;
    context.world.latitudeDegrees = latitude;
    context.world.longitudeDegrees = 0.0;
    context.world.start = start;
    context.world.stepDurationDays = 1e-3;
    const auto process = openProcess("light", R"({"sun":"position")" + configuration + "}", context);
    return *answersOf(*process, QueryBuilder().add({0, 0, 0}, {0, 0, 0, 0}).batch())[0][2];
  };
  const double expected = noon("", 51.0, "2026-06-21T12:00Z");
  EXPECT_EQ(noon(R"(,"start":"2026-06-21T12:00Z")", 51.0, "2026-12-21"), expected);
  EXPECT_EQ(noon(R"(,"latitude":51)", -30.0, "2026-06-21T12:00Z"), expected);
  EXPECT_LT(noon("", -30.0, "2026-06-21T12:00Z"), 0.8 * expected);
}

TEST(Light, TheGroundOfAStandReflectsLightFromBelow) {
  // a leaf over a white ground without anything else: nearly the whole light comes back to its lower side
  const auto under = [](const std::string& reflectance) {
    const auto process = openProcess("light", R"({"plot":[-2,2,-2,2],"ground":true,"bounces":1,"directions":1024,)"
                                              R"("diffuseIrradiance":100,"reflectance":[0],"transmittance":[0],)"
                                              R"("groundReflectance":[)" +
                                                  reflectance + "]}");
    return *LeafScene().leaf({0, 1, 0}, 0.05).answers(*process)[0][2];
  };
  EXPECT_NEAR(under("0"), 100, 1e-9);
  EXPECT_NEAR(under("1"), 200, 4);
}

TEST(Light, TheFieldIsTheIrradianceOfTheGround) {
  const auto process = openProcess("light", R"({"plot":[-2,2,-1,1],"ground":true,"groundHeight":-3,"bounces":0,)"
                                            R"("diffuseIrradiance":100,"reflectance":[0],"transmittance":[0]})");
  EXPECT_TRUE(process->fields().empty());
  // a leaf close above the ground in the corner with the smallest coordinates
  (void)LeafScene().leaf({-1.99, -2.99, -0.99}, 1).answers(*process);
  const auto fields = process->fields();
  ASSERT_EQ(fields.size(), 1U);
  EXPECT_EQ(fields[0].cells, (std::array<std::size_t, 3>{16, 1, 16}));
  EXPECT_EQ(fields[0].position, (core::Vec3{-2, -3, -1}));
  EXPECT_EQ(fields[0].cellSize, (core::Vec3{0.25, 0.125, 0.125}));
  ASSERT_EQ(fields[0].values.size(), 256U);
  EXPECT_LT(fields[0].values[0], 20);
  EXPECT_GT(fields[0].values[255], 95);
  // x is fastest: the leaf reaches over 1 along x, four cells, and over eight along z
  EXPECT_LT(fields[0].values[2], 20);
  EXPECT_GT(fields[0].values[6], 50);
  EXPECT_LT(fields[0].values[3 * 16], 30);
}

TEST(Light, OrgansThatComeLaterLeaveTheGroundTheLightItHasWithThemFromTheFirstStep) {
  for (const std::string bounces : {"0", "1"}) {
    const std::string configuration =
        R"({"diffuseIrradiance":200,"plot":[-2,2,-2,2],"ground":true,"groundReflectance":[0.2],)"
        R"("threads":1,"directions":32,"bounces":)" +
        bounces + "}";
    const auto valuesOf = [](const turtle::EnvironmentProcess& process) { return process.fields().at(0).values; };
    // one triangle, and an organ more in each step: the ground has other numbers in each
    const auto following = openProcess("light", configuration);
    LeafScene scene;
    std::vector<std::vector<double>> kept;
    for (int step = 0; step < 4; ++step) {
      if (step == 1) {
        scene.leaf({-1, 0.5, -1}, 1.5);
      } else if (step == 2) {
        scene.segment({0.5, 0, 0.5}, {0.5, 1, 0.5}, 0.3, 11);
      } else if (step == 3) {
        scene.leaf({0, 0.3, 0}, 1);
      }
      const auto later = scene.answers(*following);
      const auto fresh = openProcess("light", configuration);
      EXPECT_EQ(scene.answers(*fresh), later) << "step " << step << " bounces " << bounces;
      EXPECT_EQ(valuesOf(*fresh), valuesOf(*following)) << "step " << step << " bounces " << bounces;
      kept.push_back(valuesOf(*following));
      ASSERT_EQ(kept.back().size(), 256U);
    }
    EXPECT_NE(kept[0], kept[1]);
    EXPECT_NE(kept[1], kept[2]);
    EXPECT_NE(kept[2], kept[3]);
  }
}

TEST(Light, AnOrganMuchWiderThanThePlotOrFarAwayIsAnError) {
  const auto messageOf = [](const core::Vec3& corner, double side) {
    const auto process = openProcess("light", R"({"plot":[-1,1,-2,2]})");
    turtle::ReplyBatch replies;
    const turtle::QueryBatch queries = LeafScene().leaf(corner, side).queries();
    replies.prepare(queries);
    const auto error = process->step(queries, replies);
    return error ? error->message : "";
  };
  EXPECT_EQ(messageOf({0, 1, 0}, 90), "");
  EXPECT_EQ(messageOf({1e6, 1, 0}, 1), "");
  EXPECT_EQ(
      messageOf({0, 1, 0}, 101),
      "Environment 'light' repeats a 'plot' that is 2 wide, and an organ is more than 50 times as wide. Use a larger "
      "'plot'.");
  EXPECT_EQ(
      messageOf({0, 1, 1e7}, 1),
      "Environment 'light' repeats a 'plot' that is 4 wide, and an organ is more than a million plots away. Bring the "
      "plants nearer.");
  EXPECT_NE(messageOf({1e300, 1, 0}, 1), "");
}

TEST(Light, WhatCannotBeIsAnError) {
  turtle::EnvironmentContext context;
  const auto openingError = [&](const std::string& configuration) {
    auto made = makeProcess("light", configuration);
    const auto error = made.value()->open(context);
    return error ? error->message : "";
  };
  EXPECT_EQ(openingError(R"({"sun":"position"})"),
            "Environment 'light' needs to know where and when it is for the position of the sun: set "
            "'latitude', 'longitude' and 'start', here or in the world (\"2026-06-21T12:00\" in universal "
            "time, or with an offset: +02:00).");
  EXPECT_EQ(openingError(R"({"sun":"direction","sunDirection":[1,-1,0]})"),
            "Environment 'light' has its sun below the horizon. Give a 'sunDirection' that points up to the sun.");
  context.world.up = {1, 1, 0};
  EXPECT_EQ(
      openingError(R"({"plot":[0,1,0,1]})"),
      "Environment 'light' repeats a 'plot' along the axes, so it needs a world whose 'up' is along x, y or z. Set it "
      "to 0 1 0.");
  context.world.lengthUnit = "ell";
  EXPECT_EQ(
      openingError(""),
      "Environment 'light' needs lengths in m, dm, cm or mm, and the world's unit is 'ell'. Set lengthUnit to one of "
      "these.");
  EXPECT_EQ(errorsOf(makeProcess("light", R"({"reflectance":[0.1,0.2],"plot":[1,0,0,1],"sky":"clear"})")),
            "error: environment process 'light': 'reflectance' has 2 numbers for 1 bands\n"
            "   hint: give one number for each band, or one for all\n"
            "error: environment process 'light': 'plot' is not a smallest and a largest number for each of the two "
            "horizontal coordinates\n"
            "   hint: write for example \"plot\": [-5, 5, -5, 5]\n"
            "error: environment process 'light': a clear 'sky' is brightest around the sun, and 'sun' is none\n"
            "   hint: set sun to direction or position");
  EXPECT_EQ(errorsOf(makeProcess("light", R"({"reflectance":[0.6],"transmittance":[0.6],"ground":true})")),
            "error: environment process 'light': 'reflectance' and 'transmittance' add up to more than 1 in band 1\n"
            "   hint: organs cannot scatter more light than they get\n"
            "error: environment process 'light': a 'ground' needs a 'plot'\n"
            "   hint: write for example \"plot\": [-5, 5, -5, 5]");
  EXPECT_EQ(errorsOf(makeProcess("light", R"({"materials":[[3,0.5,0.6]]})")),
            "error: environment process 'light': a row of 'materials' is not a colour number with reflectance and "
            "transmittance for each of 1 bands, together at most 1\n"
            "   hint: write for example \"materials\": [[3, 0.1, 0.05]]");
}

}  // namespace
}  // namespace espalier::environment::light_test
