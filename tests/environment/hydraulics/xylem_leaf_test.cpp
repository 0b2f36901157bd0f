#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "engine/turtle/weather.h"
#include "environment/hydraulics/leaf_gas.h"
#include "tests/environment/hydraulics/root_drawing.h"

// Plants whose leaves close their stomata.

namespace espalier::environment::xylem_leaf_test {
namespace {

const std::vector<double> kTen(10, 0.0);
constexpr std::size_t kHead = 3, kExchange = 4;

const std::string kLoamLayers = R"("layers":[[1000,0.08,0.43,0.04,1.6,50]])";
const std::string kBox =
    R"("soil":[{"type":"soil-water","gridSize":[4,8,4],"cellSize":[1,1,1],"position":[-2,-8,-2],)" + kLoamLayers +
    R"(,"initialHead":-300,"bottom":"closed"}])";

constexpr std::size_t kStomata = 5, kLeafTemperature = 6, kWaterPart = 7, kGrowth = 8, kLatent = 9;

/// A query of a leaf: its area, net radiation and light.
std::vector<double> leafOf(double area, double netRadiation, double par) {
  std::vector<double> leaf(10, 0.0);
  leaf[2] = area;
  leaf[3] = netRadiation;
  leaf[4] = par;
  return leaf;
}

RootDrawing plantWithLeaf(const std::vector<double>& leaf) {
  RootDrawing drawing;
  drawing.root({0, 0, 0}, 20, 4, 0.1, kTen).segment({0, 0, 0}, {0, 10, 0}, 0.3, leaf);
  return drawing;
}

TEST(Xylem, ALeafOnWetSoilGivesWhatPenmanAndMonteithSay) {
  // roots of so large a conductance leave the stomata as light and air have them
  const auto process =
      openProcess("xylem",
                  R"({"leaves":"stomata","kr":10,"kx":1e6,"soilHead":-1,"halfPar":200,"halfDeficit":1.5,)"
                  R"("temperature":25,"humidity":50,"boundaryConductance":0.02})",
                  centimetres());
  const auto rows = answersOf(*process, plantWithLeaf(leafOf(50.0, 350.0, 600.0)).queries());
  const Air air{25.0, 0.5 * saturationPressure(25.0), 101.3};
  const double open = 0.01 * 0.75 / (1.0 + 0.5 * saturationPressure(25.0) / 1.5);
  const LeafExchange expected = leafExchange(air, 350.0, 0.02, open, false);
  EXPECT_NEAR(*rows[4][kStomata] / open, 1.0, 1e-3);
  EXPECT_NEAR(*rows[4][kExchange] / (-expected.water * 50.0 * 8640.0), 1.0, 1e-3);
  EXPECT_NEAR(*rows[4][kLeafTemperature], expected.temperature, 1e-2);
  EXPECT_NEAR(*rows[4][kLatent] / expected.latent, 1.0, 1e-3);
  EXPECT_GT(*rows[4][kGrowth], 0.99);
  // the leaf gives off as much as the roots take up
  EXPECT_NEAR(*rows[0][kExchange] + *rows[1][kExchange] + *rows[2][kExchange] + *rows[3][kExchange],
              -*rows[4][kExchange], 1e-8);
}

TEST(Xylem, StomataCloseInDryingSoilBeforeTheLeafWilts) {
  // a pot of loam: the leaf gives less each quarter of a day, its head stays above −15,000 cm, growth ends
  const auto process = openProcess(
      "xylem",
      R"({"leaves":"stomata","kr":0.005,"kx":5,"stomataHead":-6000,"stomataShape":4,"growthHead":-7000,)" + kBox + "}",
      centimetres(0.25));
  double before = HUGE_VAL;
  std::vector<double> last;
  for (int step = 0; step < 24; ++step) {
    const auto rows = answersOf(*process, plantWithLeaf(leafOf(2.0, 250.0, 0.0)).queries(0.25 * step));
    const double given = -*rows[4][kExchange];
    EXPECT_LT(given, before * (1.0 + 1e-9));
    EXPECT_GT(*rows[4][kHead], -15000.0);
    EXPECT_NEAR(*rows[4][kGrowth], std::clamp(1.0 + *rows[4][kHead] / 7000.0, 0.0, 1.0), 1e-9);
    before = given;
    last = {*rows[4][kWaterPart], *rows[4][kGrowth], *rows[4][kLeafTemperature]};
    if (step == 0) {
      EXPECT_GT(*rows[4][kWaterPart], 0.9);
      EXPECT_GT(*rows[4][kGrowth], 0.4);
    }
  }
  EXPECT_LT(last[0], 0.2);
  EXPECT_EQ(last[1], 0.0);
  EXPECT_GT(last[2], 22.0);  // a leaf that gives little water is warmer than the air of 20 °C
}

TEST(Xylem, LeavesReadTheAirOfTheWeather) {
  auto world = centimetres(1.0 / 24.0);
  world.world.weather = std::make_shared<const turtle::Weather>(
      turtle::Weather::read("time,temperature,humidity,wind\n0,30,40,2\n0.5,10,90,1\n", "").value());
  const auto process = openProcess("xylem", R"({"leaves":"stomata","kr":10,"kx":1e6,"soilHead":-1})", world);
  const auto warm = answersOf(*process, plantWithLeaf(leafOf(10.0, 100.0, 0.0)).queries(0.25));
  const auto cool = answersOf(*process, plantWithLeaf(leafOf(10.0, 100.0, 0.0)).queries(0.75));
  const Air air{30.0, 0.4 * saturationPressure(30.0), 101.3};
  EXPECT_NEAR(*warm[4][kLatent] / leafExchange(air, 100.0, boundaryConductance(0.03, 2.0), 0.01, false).latent, 1.0,
              1e-3);
  EXPECT_LT(*cool[4][kLatent], 0.5 * *warm[4][kLatent]);
  EXPECT_EQ(errorOf(*process, plantWithLeaf(leafOf(10.0, 100.0, 0.0)).queries(1.5)),
            "Environment 'xylem' needs the weather from day 1.5 to day 1.5416666666666667, and the table covers the "
            "time from day 0 to day 1 after the start. Add rows to the table, or make fewer steps.");
}

TEST(Xylem, RefusesLeavesThatCannotBe) {
  const auto process = openProcess("xylem", R"({"leaves":"stomata"})", centimetres());
  EXPECT_EQ(errorOf(*process, plantWithLeaf(leafOf(-2.0, 1.0, 1.0)).queries()),
            "Environment 'xylem' got the leaf area -2 in parameter 3 of module 9 of plant 0. Send a number of at least "
            "0.");
  EXPECT_EQ(
      errorOf(*process, plantWithLeaf(leafOf(2.0, 1.0, -5.0)).queries()),
      "Environment 'xylem' got the light -5 in parameter 5 of module 9 of plant 0. Send a number of at least 0, in "
      "each step again: the answer to a leaf takes the place of what it sent.");
}

}  // namespace
}  // namespace espalier::environment::xylem_leaf_test
