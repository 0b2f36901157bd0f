#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/turtle/field.h"
#include "engine/turtle/weather.h"
#include "environment/base/air.h"
#include "environment/soil/soil_body.h"
#include "tests/environment/query_builder.h"
#include "tests/environment/stops_after.h"

namespace espalier::environment {

extern const ProcessEntry kSoilWaterProcess;

}  // namespace espalier::environment

namespace espalier::environment::soil_water_test {
namespace {

/// A column of a square metre with cells of 10 cm from −1 m to 0, in the default loam.
const std::string kColumn = R"("gridSize":[1,10,1],"cellSize":[1,0.1,1],"position":[-0.5,-1,-0.5])";

std::vector<std::optional<double>> answerAt(turtle::EnvironmentProcess& process, const core::Vec3& place,
                                            std::vector<double> parameters = std::vector<double>(9, 0.0)) {
  return answersOf(process, QueryBuilder().add(place, parameters).batch())[0];
}

TEST(SoilWater, AQuerySeesHeadContentGradientAndSolutes) {
  const auto process = openProcess(
      "soil-water",
      "{" + kColumn +
          R"(,"initially":"waterTable","waterTableDepth":1,"bottom":"closed","acidity":true,"initialPh":6,)" +
          R"("solutes":[[0.25,0,0,0,0,0]]})");
  // hydrostatic: h is the height above the table, negated; θ by van Genuchten with α = 3.6, n = 1.56 (m = 1 − 1/n)
  const auto answer = answerAt(*process, {0, -0.35, 0});
  EXPECT_EQ(answer[0], 0.0);
  EXPECT_NEAR(*answer[1], -0.65, 1e-12);
  const auto content = [](double head) {
    return 0.078 + 0.352 * std::pow(1 + std::pow(-3.6 * head, 1.56), 1 / 1.56 - 1);
  };
  EXPECT_NEAR(*answer[2], content(-0.65), 1e-12);
  EXPECT_EQ(answer[3], 0.0);
  EXPECT_NEAR(*answer[4], (content(-0.75) - content(-0.55)) / 0.2, 1e-12);
  EXPECT_NEAR(*answer[6], 6.0, 1e-4);
  EXPECT_EQ(answer[7], 0.0);
  EXPECT_NEAR(*answer[8], 0.25, 1e-12);
  // nothing has moved a day later
  EXPECT_NEAR(*answerAt(*process, {0, -0.35, 0})[1], -0.65, 1e-9);
}

TEST(SoilWater, APlaceWithoutSoilHasNoWaterAndNoHead) {
  const auto process = openProcess(
      "soil-water", "{" + kColumn + R"(,"acidity":true,"solutes":[[1,0,0,0,0,0]],"spheres":[[0,-0.5,0,0.2]]})");
  // in the air and in a stone: head and pH stay as sent, which would be those of saturated soil and of strong acid
  const std::vector<std::optional<double>> nothing{0.0, std::nullopt, 0.0, 0.0, 0.0, 0.0, std::nullopt, 0.0, 0.0};
  EXPECT_EQ(answerAt(*process, {0, 0.1, 0}), nothing);
  EXPECT_EQ(answerAt(*process, {0, -0.5, 0}), nothing);
}

TEST(SoilWater, TheBordersBelongToTheBox) {
  turtle::EnvironmentContext context;
  for (const double up : {1.0, -1.0}) {
    context.world.up = {0, up, 0};
    // cells of 0.7 m / 7 and of 1 m / 3, whose borders are rounded
    const auto process = openProcess("soil-water",
                                     R"({"gridSize":[3,7,1],"cellSize":[0.3333333333333333,0.1,1],)"
                                     R"("position":[-0.5,-0.7,-0.5],"initially":"waterTable"})",
                                     context);
    const double highest = *answerAt(*process, {0, up > 0 ? -0.01 : -0.69, 0})[1];
    for (const core::Vec3 seed : {core::Vec3{0, 0, 0}, {0.5, 0, 0.5}, {-0.5, 0, -0.5}}) {
      const core::Vec3 place = up > 0 ? seed : core::Vec3{seed.x, -0.7, seed.z};
      EXPECT_NEAR(*answerAt(*process, place)[1], highest, 0.01) << place.x << " " << up;
    }
    EXPECT_EQ(answerAt(*process, {0, 1e-9, 0})[1], std::nullopt);
    EXPECT_EQ(answerAt(*process, {0, -0.7 - 1e-9, 0})[1], std::nullopt);
    EXPECT_EQ(answerAt(*process, {0.5 + 1e-9, -0.1, 0})[1], std::nullopt);
  }
}

TEST(SoilWater, StepsThatDivideTheDayEndWithIt) {
  const auto keys = readConfiguration("soil-water", kSoilWaterProcess.keys, "{" + kColumn + "}");
  ASSERT_TRUE(keys.has_value());
  for (const double parts : {7.0, 24.0, 49.0}) {
    auto soil = makeSoilBody(*keys);
    ASSERT_TRUE(soil.has_value());
    turtle::World world;
    world.stepDurationDays = 1.0 / parts;
    ASSERT_FALSE(soil->open("soil-water", world));
    for (int step = 0; step < 3 * static_cast<int>(parts); ++step) {
      ASSERT_FALSE(soil->passTime(world.stepDurationDays));
    }
    EXPECT_EQ(soil->day(), 3.0) << parts;
  }
}

/// The answers of three days to a query in each cell of a ground of 3 by 4 by 2 cells with rain, uptake and a solute.
/// `to` moves the ground from where it is to where it is asked, `from` back; a right angle makes 2 by 4 by 3 cells.
std::vector<std::vector<std::optional<double>>> answersOfGround(
    const std::function<core::Vec3(const core::Vec3&)>& to, const std::function<core::Vec3(const core::Vec3&)>& from) {
  const auto headAt = [](const core::Vec3& place) {
    return -0.4 - 0.5 * place.x - 0.3 * place.y * place.y + 0.2 * place.z * place.x;
  };
  const core::Vec3 first = to({0, -0.8, 0});
  const core::Vec3 last = to({3, 0, 2});
  const core::Vec3 low{std::min(first.x, last.x), std::min(first.y, last.y), std::min(first.z, last.z)};
  const bool isTurned = std::abs(std::abs(last.x - first.x) - 3.0) > 0.5;
  const int width = isTurned ? 2 : 3;
  const int depth = isTurned ? 3 : 2;
  const auto text = [](double number) { return std::to_string(number); };
  std::string heads;
  for (int z = 0; z < depth; ++z) {
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < width; ++x) {
        heads += (heads.empty() ? "" : ",") + text(headAt(from(low + core::Vec3{x + 0.5, 0.2 * (y + 0.5), z + 0.5})));
      }
    }
  }
  const auto process = openProcess(
      "soil-water", R"({"gridSize":[)" + std::to_string(width) + ",4," + std::to_string(depth) +
                        R"(],"cellSize":[1,0.2,1],"position":[)" + text(low.x) + "," + text(low.y) + "," + text(low.z) +
                        R"(],"initialHeads":[)" + heads +
                        R"(],"rain":[[0,0.01],[1,0]],"evaporation":[[1,0.004]],"solutes":[[1,0.5,0.001,0.05,0,0]]})");
  QueryBuilder builder;
  for (int cell = 0; cell < 24; ++cell) {
    const core::Vec3 middle{cell % 3 + 0.5, 0.2 * (cell / 3 % 4 + 0.5) - 0.8, cell / 12 + 0.5};
    builder.add(to(middle), {0.002 * (cell % 5), 0, 0, 0, 0, 0, 0, 0.001 * (cell % 3), 0});
  }
  std::vector<std::vector<std::optional<double>>> answers;
  for (int day = 0; day < 3; ++day) {
    for (auto& row : answersOf(*process, builder.batch())) {
      answers.push_back({row[0], row[1], row[2], row[4], row[7], row[8]});  // without the gradients that turn
    }
  }
  return answers;
}

TEST(SoilWater, AGroundThatIsTurnedMirroredOrElsewhereKeepsItsWater) {
  const auto same = [](const core::Vec3& v) { return v; };
  const auto turn = [](const core::Vec3& v) { return core::Vec3{v.z, v.y, -v.x}; };
  const auto turnBack = [](const core::Vec3& v) { return core::Vec3{-v.z, v.y, v.x}; };
  const auto mirror = [](const core::Vec3& v) { return core::Vec3{-v.x, v.y, v.z}; };
  const auto move = [](const core::Vec3& v) { return v + core::Vec3{64, -16, 32}; };
  const auto moveBack = [](const core::Vec3& v) { return v - core::Vec3{64, -16, 32}; };
  const auto expected = answersOfGround(same, same);
  double taken = 0.0;
  for (const auto& other :
       {answersOfGround(turn, turnBack), answersOfGround(mirror, mirror), answersOfGround(move, moveBack)}) {
    ASSERT_EQ(other.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      for (std::size_t k = 0; k < expected[i].size(); ++k) {
        EXPECT_NEAR(*other[i][k], *expected[i][k], 2e-5 * (1.0 + std::abs(*expected[i][k]))) << i << " " << k;
      }
      taken += *expected[i][0];
    }
  }
  EXPECT_GT(taken, 0.1) << "cells that want water get some";
}

TEST(SoilWater, ScarceWaterIsSharedByWhatEachWants) {
  // a cell of 0.1 m³ holds θ(−1 m) − θ(−150 m) of available water; roots want 0.03 and 0.06 m³, more than there is
  const auto process = openProcess("soil-water", "{" + kColumn + R"(,"bottom":"closed","initialHead":-1})");
  const auto table = answersOf(
      *process,
      QueryBuilder().add({0, -0.05, 0}, {0.03}).add({0.2, -0.02, 0}, {0.06, 0, 0}).add({0, -0.55, 0}, {0.001}).batch());
  const double first = *table[0][0];
  const double second = *table[1][0];
  EXPECT_NEAR(second / first, 2.0, 1e-12);
  const auto content = [](double head) {
    return 0.078 + 0.352 * std::pow(1 + std::pow(-3.6 * head, 1.56), 1 / 1.56 - 1);
  };
  EXPECT_NEAR(first + second, 0.1 * (content(-1) - content(-150)), 1e-12);
  EXPECT_EQ(*table[2][0], 0.001);
  // and it is gone: all the water there is now, read cell by cell
  QueryBuilder builder;
  for (int cell = 0; cell < 10; ++cell) {
    builder.add({0, -0.95 + 0.1 * cell, 0}, {0, 0, 0});
  }
  double left = 0;
  for (const auto& row : answersOf(*process, builder.batch())) {
    left += 0.1 * *row[2];
  }
  EXPECT_NEAR(left + first + second + 0.001, content(-1), 1e-10);
}

TEST(SoilWater, SolutesAreTakenUpAndGivenOff) {
  const auto process = openProcess("soil-water", "{" + kColumn + R"(,"bottom":"closed","solutes":[[1,0,0,0,0.5,0]]})");
  const core::Vec3 place{0, -0.05, 0};
  const auto before = answerAt(*process, place, {0, 0, 0, 0, 0, 0, 0, 0.02, 0});
  EXPECT_EQ(before[7], 0.02);
  EXPECT_NEAR(*before[8], 1.0, 1e-12);
  const double content = *before[2];
  // 0.1 m³ of soil lose 0.02: the concentration falls by 0.2/(θ + sorption), except for the inflow from below
  const auto after = answerAt(*process, place, {0, 0, 0, 0, 0, 0, 0, 99, 0});
  EXPECT_NEAR(*after[8], 1 - 0.2 / (content + 0.5), 0.01);
  EXPECT_LT(*after[7], 0.1 * (content + 0.5) - 0.02 + 0.01);
  EXPECT_NEAR(*answerAt(*process, place, {0, 0, 0, 0, 0, 0, 0, -0.05, 0})[8], 0.0, 0.05);
  EXPECT_GT(*answerAt(*process, place)[8], 0.3);
}

TEST(SoilWater, RootsAcidifyTheSoil) {
  const auto process = openProcess(
      "soil-water", "{" + kColumn + R"(,"bottom":"closed","acidity":true,"initialPh":6.5,"bufferCapacity":20})");
  // 1 mol in 0.1 m³ that holds 20 mol/m³ per unit of pH: half a unit
  answerAt(*process, {0, -0.05, 0}, {0, 0, 0, 0, 0, 0, 1});
  EXPECT_NEAR(*answerAt(*process, {0, -0.05, 0})[6], 6.0, 0.01);
}

TEST(SoilWater, StonesHoldNoWaterAndTheWeatherChanges) {
  const auto process = openProcess(
      "soil-water",
      R"({"gridSize":[3,5,1],"cellSize":[0.1,0.1,0.1],"position":[0,-0.5,0],"boxes":[[0.1,-0.3,0,0.2,-0.1,0.1]],)"
      R"("rain":[[0,0],[3,0.02],[4,0]],"initialHead":-3})");
  const core::Vec3 top{0.05, -0.05, 0.05};
  EXPECT_EQ(answerAt(*process, {0.15, -0.25, 0.05})[2], 0.0);
  double before = *answerAt(*process, top)[2];
  before = *answerAt(*process, top)[2];
  const double dry = *answerAt(*process, top)[2];
  EXPECT_LE(dry, before);
  answerAt(*process, top);
  EXPECT_GT(*answerAt(*process, top)[2], dry + 0.05) << "after the rain of the fourth day";
}

turtle::Field fieldOf(turtle::EnvironmentProcess& process, const std::string& name) {
  for (turtle::Field& field : process.fields()) {
    if (field.name == name) {
      return std::move(field);
    }
  }
  ADD_FAILURE() << "there is no field " << name;
  return {};
}

TEST(SoilWater, FieldsOfTheWholeBoxAreItsBalanceOnAUnitOfItsBase) {
  // 0.3 m of rain on two columns with cells that grow, of which a part runs off and a part leaves at the bottom
  const auto process =
      openProcess("soil-water", R"({"gridSize":[2,10,1],"cellSize":[0.5,0.1,0.5],"growth":1.3,"position":[2,-1,3],)"
                                R"("layers":[[1,0.1,0.4,1,1.5,0.2]],"initialHead":-0.5,"rain":[[0,0.3]]})");
  const double before = fieldOf(*process, "storedWater").values.at(0);
  EXPECT_GT(before, 0.1);
  EXPECT_LT(before, 0.4);
  ASSERT_FALSE(process->tick(0).has_value());
  const turtle::Field stored = fieldOf(*process, "storedWater");
  const double infiltrated = fieldOf(*process, "infiltrated").values.at(0);
  const double drained = fieldOf(*process, "drained").values.at(0);
  const double runOff = fieldOf(*process, "runOff").values.at(0);
  EXPECT_GT(drained, 0.01);
  EXPECT_GT(runOff, 0.01);
  EXPECT_NEAR(infiltrated + runOff, 0.3, 1e-12);
  EXPECT_NEAR(stored.values[0] - before, infiltrated - drained, 1e-12);
  // one cell as large as the box
  EXPECT_EQ(stored.unit, "m");
  EXPECT_EQ(stored.cells, (std::array<std::size_t, 3>{1, 1, 1}));
  EXPECT_EQ(stored.position, (core::Vec3{2, -1, 3}));
  EXPECT_EQ(stored.cellSize, (core::Vec3{1, 1, 0.5}));
}

TEST(SoilWater, TheWeathersRainTakesThePlaceOfItsOwn) {
  // 2 mm/h from 6 to 12 h: 12 mm in the day, on dry ground that lets all in; what the key says does not count
  turtle::EnvironmentContext context;
  context.world.weather = std::make_shared<const turtle::Weather>(
      turtle::Weather::read("time,rain\n0,0\n0.25,2\n0.5,0\n1,0\n1.5,0\n", "").value());
  const auto process =
      openProcess("soil-water", "{" + kColumn + R"(,"bottom":"closed","initialHead":-5,"rain":[[0,7]]})", context);
  const auto stored = [&] {
    const std::vector<turtle::Field> fields = process->fields();
    double sum = 0.0;
    for (const double content : fields[0].values) {
      sum += 0.1 * content;
    }
    return sum;
  };
  const double before = stored();
  ASSERT_FALSE(process->tick(0).has_value());
  EXPECT_NEAR(stored() - before, 0.012, 1e-9);
  EXPECT_NEAR(fieldOf(*process, "infiltrated").values.at(0), 0.012, 1e-12);
  ASSERT_FALSE(process->tick(1).has_value());
  EXPECT_NEAR(stored() - before, 0.012, 1e-9);
  const auto error = process->tick(2);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message,
            "Environment 'soil-water' needs the weather from day 2 to day 3, and the table covers the time "
            "from day 0 to day 2 after the start. Add rows to the table, or make fewer steps.");
  EXPECT_NEAR(stored() - before, 0.012, 1e-9);
}

/// Water that a column loses in each of so many days, length.
std::vector<double> lossesOf(turtle::EnvironmentProcess& process, std::uint64_t days) {
  const auto stored = [&] {
    const std::vector<turtle::Field> fields = process.fields();
    double sum = 0.0;
    for (const double content : fields[0].values) {
      sum += 0.1 * content;
    }
    return sum;
  };
  std::vector<double> losses;
  for (std::uint64_t day = 0; day < days; ++day) {
    const double before = stored();
    EXPECT_FALSE(process.tick(day).has_value());
    losses.push_back(before - stored());
  }
  return losses;
}

TEST(SoilWater, TheWeatherSaysHowMuchAWetSurfaceEvaporates) {
  turtle::EnvironmentContext context;
  context.world.weather = std::make_shared<const turtle::Weather>(
      turtle::Weather::read("time,global,temperature,humidity,wind\n0,300,20,50,2\n2,0,20,100,2\n3,0,20,100,2\n", "")
          .value());
  const std::string evaporates = R"(,"bottom":"closed","evaporationBy":"weather","roughness":0.01,"albedo":0.2,)"
                                 R"("longWaveLoss":40,"groundLight":[[0,1],[1,0.5]])";
  const auto wet = openProcess("soil-water", "{" + kColumn + evaporates + R"(,"initialHead":-0.3})", context);
  const Air air{20.0, 0.5 * saturationPressure(20.0), 101.3};
  const double conductance = 2.0 * 0.41 * 0.41 / (std::log(200.0) * std::log(2000.0));
  // kg m⁻² s⁻¹ as m/day: the whole light, then half of it, then a night of moist air with dew, which is left out
  const std::vector<double> losses = lossesOf(*wet, 3);
  EXPECT_NEAR(losses[0], 86.4 * wetSurfaceEvaporation(air, 0.8 * 300.0 - 40.0, conductance), 1e-9);
  EXPECT_NEAR(losses[1], 86.4 * wetSurfaceEvaporation(air, 0.8 * 150.0 - 40.0, conductance), 1e-9);
  EXPECT_NEAR(losses[2], 0.0, 1e-9);
  // dry ground gives what its surface lets out
  const auto dry = openProcess("soil-water", "{" + kColumn + evaporates + R"(,"initialHead":-100})", context);
  const double little = lossesOf(*dry, 1)[0];
  EXPECT_GT(little, 0.0);
  EXPECT_LT(little, 0.01 * losses[0]);
}

TEST(SoilWater, EvaporationByWeatherNeedsTheWeather) {
  turtle::EnvironmentContext context;
  const std::string keys = "{" + kColumn + R"(,"evaporationBy":"weather","roughness":0.01})";
  const auto openingError = [&] {
    auto process = makeProcess("soil-water", keys);
    return (*process)->open(context).value_or(turtle::EnvironmentError{}).message;
  };
  const std::string without = "Environment 'soil-water' has 'evaporationBy' weather, and the world's weather has no '";
  const std::string remedy =
      "'. Give the world a weather with global, temperature, humidity and wind, or 'evaporation' rows.";
  EXPECT_EQ(openingError(), without + "global" + remedy);
  context.world.weather = std::make_shared<const turtle::Weather>(
      turtle::Weather::read("time,global,temperature,wind\n0,300,20,2\n1,300,20,2\n", "").value());
  EXPECT_EQ(openingError(), without + "humidity" + remedy);
  EXPECT_EQ(errorsOf(makeProcess("soil-water", R"({"evaporationBy":"weather"})")),
            "error: environment process 'soil-water': 'evaporationBy' weather needs a 'roughness' above 0 and below "
            "'windHeight'\n   hint: give the aerodynamic roughness of the ground in metres");
  EXPECT_EQ(errorsOf(makeProcess("soil-water", R"({"groundLight":[[0,1.5]]})")),
            "error: environment process 'soil-water': 'groundLight' has a part above 1\n"
            "   hint: give the part of the global radiation, from 0 to 1");
}

TEST(SoilWater, ASoluteThatSpreadsTooFastIsRefusedBeforeTheWork) {
  const auto process = openProcess("soil-water", R"({"solutes":[[1,0,1e7,0,0,0]]})");
  const std::string before = process->save();
  StopsAfter meter(1000);  // followed, it asks millions of times
  const core::WorkMeter::Scope scope(&meter);
  const auto error = process->tick(1);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message.find("Environment 'soil-water' would take minutes for a step to follow its solutes"), 0U)
      << error->message;
  EXPECT_EQ(process->save(), before);
}

TEST(SoilWater, ASoluteThatIsTakenUpWholeEndsAtZero) {
  for (const auto& [concentration, wishes] :
       {std::pair{"0.94", std::vector{0.655}}, {"0.39", {1.335, 1.237, 1.472}}, {"0.677", {0.727, 0.451}}}) {
    const auto process =
        openProcess("soil-water", "{" + kColumn + R"(,"bottom":"closed","initially":"waterTable","solutes":[[)" +
                                      concentration + ",0,0,0,0,0]]}");
    QueryBuilder builder;
    for (const double wanted : wishes) {
      builder.add({0, -0.35, 0}, {0, 0, 0, 0, 0, 0, 0, wanted, 0});
    }
    answersOf(*process, builder.batch());
    // rounded shares added up to more than there was
    EXPECT_EQ(*answerAt(*process, {0, -0.35, 0})[8], 0.0) << concentration;
  }
}

TEST(SoilWater, FieldsShowWhatQueriesSee) {
  const auto process =
      openProcess("soil-water", "{" + kColumn + R"(,"initially":"waterTable","bottom":"closed","acidity":true,)" +
                                    R"("solutes":[[0.5,0,0,0,0,0]]})");
  const auto fields = process->fields();
  ASSERT_EQ(fields.size(), 8U) << "four of the cells, four of the whole box";
  EXPECT_EQ(fields[0].name, "waterContent");
  EXPECT_EQ(fields[1].unit, "m");
  EXPECT_EQ(fields[0].cells, (std::array<std::size_t, 3>{1, 10, 1}));
  EXPECT_EQ(fields[0].position, (core::Vec3{-0.5, -1, -0.5}));
  // the third cell from below is the one between -0.8 and -0.7
  const auto answer = answerAt(*process, {0, -0.75, 0});
  EXPECT_EQ(fields[0].values[2], answer[2]);
  EXPECT_EQ(fields[1].values[2], answer[1]);
  EXPECT_EQ(fields[2].values[2], answer[8]);
  EXPECT_EQ(fields[3].values[2], answer[6]);
}

TEST(SoilWater, DefaultsAreConvertedToTheWorldsUnit) {
  // the same ground by its defaults, in a rainless week of evaporation, in each unit of length
  const auto answerIn = [](const std::string& unit, double length, const std::string& evaporation) {
    turtle::EnvironmentContext context;
    context.world.lengthUnit = unit;
    context.world.stepDurationDays = 7.0;
    const auto process = openProcess(
        "soil-water", R"({"acidity":true,"bottom":"closed","evaporation":[[0,)" + evaporation + "]]}", context);
    answerAt(*process, {0, -0.02 * length, 0});
    return answerAt(*process, {0, -0.02 * length, 0}, {1e3 * length * length * length, 0, 0, 0, 0, 0, 0});
  };
  const auto metres = answerIn("m", 1.0, "0.002");
  for (const auto& [unit, length, evaporation] :
       {std::tuple{"dm", 10.0, "0.02"}, {"cm", 100.0, "0.2"}, {"mm", 1000.0, "2"}}) {
    const auto answer = answerIn(unit, length, evaporation);
    EXPECT_NEAR(*answer[0] / (length * length * length), *metres[0], 1e-9) << unit;
    EXPECT_NEAR(*answer[1] / length, *metres[1], 1e-6) << unit;
    EXPECT_NEAR(*answer[2], *metres[2], 1e-8) << unit;
    EXPECT_NEAR(*answer[6], *metres[6], 1e-8) << unit;
  }
}

TEST(SoilWater, GivenLengthsAreNotConverted) {
  turtle::EnvironmentContext context;
  context.world.lengthUnit = "cm";
  const auto process =
      openProcess("soil-water", R"({"initialHead":-1,"cellSize":[2,2,2],"position":[0,-40,0]})", context);
  EXPECT_EQ(answerAt(*process, {1, -1, 1})[1], -1.0);
  EXPECT_EQ(process->fields().front().cellSize, (core::Vec3{2, 2, 2}));
}

TEST(SoilWater, WhatCannotBeIsAnError) {
  turtle::EnvironmentContext context;
  const auto openingError = [&](const std::string& configuration) {
    auto made = makeProcess("soil-water", configuration);
    const auto error = made.value()->open(context);
    return error ? error->message : "";
  };
  context.world.lengthUnit = "inch";
  EXPECT_EQ(
      openingError(""),
      "Environment 'soil-water' has a default soil in metres, and the world's unit is 'inch'. Give 'layers', or set "
      "lengthUnit to m, dm, cm or mm.");
  EXPECT_EQ(
      openingError(R"({"layers":[[1,0.05,0.4,1,1.5,1]],"acidity":true})"),
      "Environment 'soil-water' needs lengths in m, dm, cm or mm, and the world's unit is 'inch'. Set lengthUnit to "
      "one of these.");
  context.world = {};
  context.world.up = {1, 1, 0};
  EXPECT_EQ(openingError(""), "Environment 'soil-water' needs a world whose 'up' is along x, y or z. Set it to 0 1 0.");
  context.world = {};
  context.world.stepDurationDays = 0;
  EXPECT_EQ(openingError(""),
            "Environment 'soil-water' lets time pass in steps: the world's 'stepDurationDays' must be greater than 0.");
  EXPECT_EQ(errorsOf(makeProcess("soil-water", R"({"layers":[[1,0.5,0.4,1,1.5,1],[1,0.1,0.4,1,1,1]]})")),
            "error: environment process 'soil-water': layers[0] has a residual water content that is not below the "
            "saturated one, or one above 1\n"
            "   hint: a row is thickness, residual content, saturated content, α, n, conductivity\n"
            "error: environment process 'soil-water': layers[1] needs α and the conductivity above 0 and n above 1\n"
            "   hint: a row is thickness, residual content, saturated content, α, n, conductivity");
  EXPECT_EQ(errorsOf(makeProcess("soil-water", R"({"rain":[[2,1],[1,1]],"gridSize":[4096,4096,1000]})")),
            "error: environment process 'soil-water': the grid has 16777216000 cells, and the limit is 16777216\n"
            "   hint: use fewer cells along x, y or z\n"
            "error: environment process 'soil-water': 'rain' has day 1 after day 2\n"
            "   hint: write the rows in the order of their days, each day once");
  EXPECT_EQ(
      errorsOf(makeProcess("soil-water", R"({"rain":[[2,1],[9,1]],"weatherPeriod":7})")),
      "error: environment process 'soil-water': 'rain' has a day beyond the 'weatherPeriod' after which it repeats\n"
      "   hint: use days from 0 to below the period");
}

TEST(SoilWater, AnInitialHeadBeyondAllSoilsIsAnError) {
  // a column that drains from such a head took time steps without end
  EXPECT_EQ(
      errorsOf(makeProcess("soil-water", R"({"initialHead":1e12})")),
      "error: environment process 'soil-water': 'initialHead' must be between -1.0e+09 and 1.0e+09, found 1.0e+12\n"
      "   hint: initialHead: initial pressure head; the default is converted from metres");
  EXPECT_NE(errorsOf(makeProcess("soil-water", R"({"initially":"waterTable","waterTableDepth":-1e12})")), "");
  EXPECT_NE(errorsOf(makeProcess("soil-water", R"({"gridSize":[1,2,1],"initialHeads":[-1,-1e12]})")), "");
}

TEST(SoilWater, AFlowWithoutSolutionInSteepDrySoilSaysWithWhichHeadToBegin) {
  // α 2, n 8: an effective saturation of 10⁻⁶ at (10^(6/7 · 8/7) − 1)^(1/8)/2
  const auto process =
      openProcess("soil-water", R"({"layers":[[1,0.05,0.4,2,8,1]],"initialHead":-1000,"rain":[[0,0.03]]})");
  const auto error = process->tick(0);
  ASSERT_TRUE(error.has_value());
  EXPECT_NE(error->message.find("The soil at (0, "), std::string::npos) << error->message;
  EXPECT_NE(error->message.find(") has next to no water (α 2, n 8): begin with heads of -3."), std::string::npos)
      << error->message;
}

TEST(SoilWater, AFlowWithoutSolutionIsAnErrorAndChangesNothing) {
  const auto process =
      // heads that gravity should change, of water that cannot flow away and that nothing can store
      openProcess("soil-water", "{" + kColumn + R"(,"specificStorage":1e-30,"bottom":"closed","initialHead":5})");
  const std::string before = process->save();
  const auto error = process->tick(0);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->message.find("Environment 'soil-water' finds no solution of the flow of water on day "), 0U);
  EXPECT_NE(error->message.find(", where the pressure head is 5 m: the residual is "), std::string::npos)
      << error->message;
  EXPECT_NE(error->message.find(" of the water content, the tolerance 1.0e-06. Use larger cells, a larger 'tolerance', "
                                "or less extreme weather and layers."),
            std::string::npos);
  EXPECT_EQ(process->save(), before);
}

}  // namespace
}  // namespace espalier::environment::soil_water_test
