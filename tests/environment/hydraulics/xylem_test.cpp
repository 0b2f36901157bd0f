#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/turtle/field.h"
#include "engine/turtle/weather.h"
#include "environment/hydraulics/leaf_gas.h"
#include "tests/environment/hydraulics/root_drawing.h"

namespace espalier::environment::xylem_test {
namespace {

const std::vector<double> kTen(10, 0.0);
constexpr std::size_t kHead = 3, kExchange = 4, kCollarHead = 5, kCollarFlow = 6, kConductance = 7, kFraction = 8,
                      kSurfaceHead = 9;

const std::string kLoamLayers = R"("layers":[[1000,0.08,0.43,0.04,1.6,50]])";

TEST(Xylem, ASingleRootIsThatOfLandsbergAndFowkes) {
  // u'' = c u for u = ψ − ψs, u = −800 at the collar and u' = 1 at the tip (gravity, no flow), c = 2πa kr/kx
  const double tau = std::sqrt(2.0 * std::numbers::pi * 0.2 * 0.000173 / 0.0432);
  const double b = (1.0 / tau + 800.0 * std::sinh(50.0 * tau)) / std::cosh(50.0 * tau);
  const auto process = openProcess(
      "xylem", R"({"collar":"head","collarHead":-1000,"soilHead":-200,"kr":0.000173,"kx":0.0432})", centimetres());
  for (const std::size_t parts : {1U, 8U}) {
    const auto rows = answersOf(*process, RootDrawing().root({3, 0, 4}, 50.0, parts, 0.4, kTen).queries());
    double uptake = 0.0;
    double fractions = 0.0;
    for (std::size_t i = 0; i < parts; ++i) {
      const double s = 50.0 * static_cast<double>(i + 1) / static_cast<double>(parts);
      EXPECT_NEAR(*rows[i][kHead], -800.0 * std::cosh(tau * s) + b * std::sinh(tau * s) - 200.0, 1e-6);
      EXPECT_EQ(*rows[i][kCollarHead], -1000.0);
      EXPECT_EQ(*rows[i][kSurfaceHead], -200.0);
      EXPECT_NEAR(*rows[i][kCollarFlow], 2.406878, 1e-6);
      EXPECT_NEAR(*rows[i][kConductance], 0.0432 * tau * std::tanh(50.0 * tau), 1e-12);
      EXPECT_FALSE(rows[i][0].has_value());  // what was sent stays
      uptake += *rows[i][kExchange];
      fractions += *rows[i][kFraction];
    }
    EXPECT_NEAR(uptake, *rows[0][kCollarFlow], 1e-10);
    EXPECT_NEAR(fractions, 1.0, 1e-12);
  }
}

TEST(Xylem, DefaultsAreConvertedFromMetres) {
  // the same root in metres and in centimetres: flows differ by 10⁶, heads by 100
  const auto small = answersOf(*openProcess("xylem", R"({"collar":"head"})", centimetres()),
                               RootDrawing().root({0, 0, 0}, 20, 2, 0.1, kTen).queries());
  const auto large = answersOf(*openProcess("xylem", R"({"collar":"head"})"),
                               RootDrawing().root({0, 0, 0}, 0.2, 2, 0.001, kTen).queries());
  EXPECT_NEAR(*small[1][kHead] / *large[1][kHead], 100.0, 1e-9);
  EXPECT_NEAR(*small[0][kCollarFlow] / *large[0][kCollarFlow], 1e6, 1e-3);
}

TEST(Xylem, LateralsJoinWhereTheyStartAndOthersAreCollars) {
  // a lateral at the middle of a root, and one that starts 0.1 cm beside it
  const auto draw = [](double beside) {
    return RootDrawing().root({0, 0, 0}, 10, 2, 0.1, kTen).segment({beside, -5, 0}, {4, -6, 0}, 0.1, kTen, 1).queries();
  };
  const std::string base = R"({"transpiration":[[0,0.01]],"kr":0.001)";
  const auto joined = answersOf(*openProcess("xylem", base + "}", centimetres()), draw(0.0));
  const auto apart = answersOf(*openProcess("xylem", base + "}", centimetres()), draw(0.1));
  const auto bridged = answersOf(*openProcess("xylem", base + R"(,"join":0.2})", centimetres()), draw(0.1));
  EXPECT_LT(*joined[2][kHead], *joined[2][kCollarHead] + 10.0);
  EXPECT_GT(std::abs(*joined[2][kHead] - *apart[2][kHead]), 0.1);
  EXPECT_NEAR(*joined[2][kHead], *bridged[2][kHead], 0.5);
  // the flow is that of the plant, whatever the number of its collars
  for (const auto& rows : {joined, apart, bridged}) {
    EXPECT_NEAR(*rows[0][kExchange] + *rows[1][kExchange] + *rows[2][kExchange], 0.01, 1e-12);
  }
}

TEST(Xylem, PlantsAreEachAsAlone) {
  const std::string configuration = R"({"transpiration":[[0,0.02]],"kr":0.001,"kx":0.05})";
  const auto process = openProcess("xylem", configuration, centimetres());
  const auto both = answersOf(
      *process, RootDrawing().root({0, 0, 0}, 20, 4, 0.1, kTen).nextPlant().root({0, 0, 0}, 7, 3, 0.2, kTen).queries());
  const auto first = answersOf(*process, RootDrawing().root({0, 0, 0}, 20, 4, 0.1, kTen).queries());
  const auto second = answersOf(*process, RootDrawing().root({0, 0, 0}, 7, 3, 0.2, kTen).queries());
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(both[i], first[i]);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(both[4 + i], second[i]);
  }
}

TEST(Xylem, ConductivitiesFollowOrderAndAge) {
  // halfway between the rows kr is 2·10⁻³; order 2 has its own rows, and order 3 those of order 2
  const auto withTable = openProcess("xylem",
                                     R"({"collar":"head","collarHead":-500,"kxTable":[[1,0,0.05]],
                                         "krTable":[[1,0,0.001],[1,10,0.003],[2,0,0.0005]]})",
                                     centimetres());
  const auto fixed = openProcess("xylem", R"({"collar":"head","collarHead":-500,"kx":0.05})", centimetres());
  const auto sent = [](double age, double order, std::optional<double> kr) {
    std::vector<double> parameters(kr ? 12 : 10, 0.0);
    parameters[0] = age;
    parameters[1] = order;
    if (kr) {
      parameters[10] = *kr;
      parameters[11] = 0.05;
    }
    return RootDrawing().segment({0, 0, 0}, {0, -10, 0}, 0.1, parameters).queries();
  };
  for (const auto& [age, order, kr] : std::vector<std::array<double, 3>>{
           {5, 0, 0.002}, {0, 1, 0.001}, {99, 1, 0.003}, {5, 2, 0.0005}, {5, 3, 0.0005}}) {
    EXPECT_EQ(*answersOf(*withTable, sent(age, order, std::nullopt))[0][kCollarFlow],
              *answersOf(*fixed, sent(0, 0, kr))[0][kCollarFlow])
        << age << " " << order;
  }
}

TEST(Xylem, VesselsConductByHagenAndPoiseuille) {
  // N π r⁴ ρg/8μ with water at 20 °C: 0.05305637 cm³/day of a vessel of 20 µm, 12.435087 of six of 50 µm
  const auto conductanceOf = [](const std::string& keys) {
    const auto process = openProcess("xylem", R"({"collar":"head","kr":0.01,)" + keys + "}", centimetres());
    return *answersOf(*process, RootDrawing().root({0, 0, 0}, 20, 2, 0.1, kTen).queries())[0][kConductance];
  };
  for (const auto& [vessels, kx] : {std::pair<std::string, std::string>{"[[1,0,1,20]]", "0.05305637"},
                                    {"[[1,0,6,50]]", "12.435087"},
                                    {"[[0,0,1,1],[1,0,6,50],[2,0,1,1]]", "12.435087"}}) {
    const double expected = conductanceOf("\"kx\":" + kx);
    EXPECT_NEAR(conductanceOf("\"vessels\":" + vessels) / expected, 1.0, 1e-7) << vessels;
  }
}

TEST(Xylem, NothingIsTakenUpAboveTheGround) {
  // a stem of 30 cm: its leaf draws 0.02 cm³/day through a root of 20 cm, and no water leaves at the collar
  std::vector<double> leaf(10, 0.0);
  leaf[2] = 0.02;
  auto drawing = RootDrawing().root({0, 0, 0}, 20, 4, 0.1, kTen).segment({0, 0, 0}, {0, 30, 0}, 0.4, leaf);
  const auto rows =
      answersOf(*openProcess("xylem", R"({"kr":0.001,"kx":0.05,"soilHead":-200})", centimetres()), drawing.queries());
  EXPECT_NEAR(*rows[0][kExchange] + *rows[1][kExchange] + *rows[2][kExchange] + *rows[3][kExchange], 0.02, 1e-12);
  EXPECT_NEAR(*rows[4][kExchange], -0.02, 1e-12);
  EXPECT_NEAR(*rows[4][kHead], *rows[4][kCollarHead] - 30.0 - 0.02 * 30.0 / 0.05, 1e-9);
  EXPECT_NEAR(*rows[4][kCollarFlow], 0.0, 1e-12);
}

TEST(Xylem, LeavesCloseWhereTheRootsCannotFollow) {
  // a leaf on one root without length of stem: D (ψ − ψ₂)/(ψ₁ − ψ₂) = Krs (ψs − ψ), no gravity along x
  std::vector<double> leaf(10, 0.0);
  leaf[2] = 2.0;
  const auto rows = answersOf(
      *openProcess("xylem", R"({"kr":0.0001,"kx":50,"soilHead":-2000,"closingHeads":[-3000,-9000]})", centimetres()),
      RootDrawing().segment({0, 0, 0}, {10, 0, 0}, 0.2, leaf).queries());
  const double krs = *rows[0][kConductance];
  const double slope = 2.0 / 6000.0;
  const double head = (krs * -2000.0 - slope * 9000.0) / (krs + slope);
  EXPECT_NEAR(*rows[0][kHead] / head, 1.0, 1e-3);  // kx is large, not infinite
  EXPECT_LT(*rows[0][kHead], -3000.0);
  // wet soil: the whole demand
  const auto wet = answersOf(
      *openProcess("xylem", R"({"kr":0.01,"kx":50,"soilHead":-100,"closingHeads":[-3000,-9000]})", centimetres()),
      RootDrawing().segment({0, 0, 0}, {100, 0, 0}, 0.2, leaf).queries());
  EXPECT_GT(*wet[0][kHead], -3000.0);
  EXPECT_NEAR(*wet[0][kExchange], 0.0, 1e-9);
}

TEST(Xylem, AllLeavesOfAPlantFindTheirHeads) {
  // a stem with 40 leaves on a root in soil that gives less and less: each gives the part that belongs to its head
  std::vector<double> leaf(10, 0.0);
  leaf[2] = 0.05;
  for (const double soilHead : {-10.0, -500.0, -2000.0, -5000.0, -8900.0, -12000.0}) {
    const auto process =
        openProcess("xylem",
                    R"({"kr":0.0005,"kx":0.2,"lowestHead":-15000,"closingHeads":[-3000,-9000],"soilHead":)" +
                        std::to_string(soilHead) + "}",
                    centimetres());
    RootDrawing drawing;
    drawing.root({0, 0, 0}, 40, 4, 0.1, kTen);
    for (int i = 0; i < 40; ++i) {
      drawing.segment({0, 1.0 * i, 0}, {0, 1.0 * i + 1.0, 0}, 0.2, kTen);
      drawing.segment({0, 1.0 * i + 1.0, 0}, {5, 1.0 * i + 1.0, 0}, 0.05, leaf, 1);
    }
    const auto rows = answersOf(*process, drawing.queries());
    double uptake = 0.0;
    double given = 0.0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      (i < 4 ? uptake : given) += *rows[i][kExchange];
      if (i >= 4 && i % 2 == 1) {
        EXPECT_NEAR(*rows[i][kExchange], -0.05 * std::clamp((*rows[i][kHead] + 9000.0) / 6000.0, 0.0, 1.0), 1e-9);
      }
    }
    EXPECT_NEAR(uptake, -given, 1e-9);
    EXPECT_EQ(given<-1e-6, soilHead> - 8980.0) << soilHead;
  }
}

TEST(Xylem, VesselsLoseTheirConductanceAtLowHeads) {
  // a stem of 1 cm along x carries 0.1 cm³/day; kx/(1 + (ψ/P50)^s) at the mean head of its ends
  std::vector<double> leaf(10, 0.0);
  leaf[2] = 0.1;
  const auto rows = answersOf(
      *openProcess(
          "xylem",
          R"({"collar":"head","collarHead":-400,"kx":0.001,"kr":0,"vulnerabilityHead":-500,"vulnerabilityShape":2})",
          centimetres()),
      RootDrawing().segment({0, 0, 0}, {1, 0, 0}, 0.2, leaf).queries());
  const double head = *rows[0][kHead];
  const double mean = 0.5 * (head - 400.0);
  EXPECT_NEAR((-400.0 - head) * 0.001 / (1.0 + std::pow(mean / -500.0, 2.0)), 0.1, 1e-6);
  EXPECT_LT(head, -510.0);
}

TEST(Xylem, ACourseOfTheDayHasItsMean) {
  const auto flowOf = [](const std::string& keys, double stepDays, double time) {
    const auto process =
        openProcess("xylem", R"({"kr":0.01,"transpiration":[[0,0.5]])" + keys + "}", centimetres(stepDays));
    return *answersOf(*process, RootDrawing().root({0, 0, 0}, 30, 3, 0.1, kTen).queries(time))[0][kCollarFlow];
  };
  EXPECT_NEAR(flowOf(R"(,"dayCourse":true)", 1.0, 3.0), 0.5, 1e-9);
  // from 6 to 12: rate (1 − (sin 2π t₂ − sin 2π t₁)/(2π (t₂ − t₁))) = 0.5 (1 + 2/π)
  EXPECT_NEAR(flowOf(R"(,"dayCourse":true)", 0.25, 0.25), 0.5 * (1.0 + 2.0 / std::numbers::pi), 1e-9);
  // the lowest head limits what leaves at noon, and so the mean
  EXPECT_LT(flowOf(R"(,"dayCourse":true,"lowestHead":-150)", 1.0, 0.0), 0.499);
}

TEST(Xylem, RowsThatChangeWithinAStepCountForTheirPartOfIt) {
  const auto flowOf = [](const std::string& keys, double stepDays, double time) {
    const auto process = openProcess("xylem", R"({"kr":0.01)" + keys + "}", centimetres(stepDays));
    return *answersOf(*process, RootDrawing().root({0, 0, 0}, 30, 3, 0.1, kTen).queries(time))[0][kCollarFlow];
  };
  // a quarter of the day with 0.4, and what begins behind the middle
  EXPECT_NEAR(flowOf(R"(,"transpiration":[[0,0],[0.75,0.4]])", 1.0, 0.0), 0.1, 1e-9);
  EXPECT_NEAR(flowOf(R"(,"transpiration":[[0,0.4],[0.125,0]],"transpirationPeriod":0.25)", 1.0, 2.0), 0.2, 1e-9);
  // and before the first row nothing
  EXPECT_NEAR(flowOf(R"(,"transpiration":[[0.25,0.4]])", 1.0, 0.0), 0.3, 1e-9);
  // from 18 to 24 h of the course of the day: 0.25 (1 − 2/π)
  EXPECT_NEAR(flowOf(R"(,"dayCourse":true,"transpiration":[[0,0],[0.75,0.4]])", 1.0, 0.0),
              0.1 * (1.0 - 2.0 / std::numbers::pi), 1e-9);
}

TEST(Xylem, RefusesWhatCannotBe) {
  const auto process = openProcess("xylem", "", centimetres());
  std::vector<double> wrong(12, 1.0);
  wrong[10] = -1.0;
  EXPECT_EQ(errorOf(*process, RootDrawing().root({0, 0, 0}, 5, 1, 0.1, wrong).queries()),
            "Environment 'xylem' got the radial conductivity kr -1 in parameter 11 of module 1 of plant 0. Send a "
            "number of at least 0.");
  wrong[10] = 1.0;
  wrong[11] = 0.0;
  EXPECT_EQ(errorOf(*process, RootDrawing().root({0, 0, 0}, 5, 1, 0.1, wrong).queries()),
            "Environment 'xylem' got the axial conductance kx 0 in parameter 12 of module 1 of plant 0. Send a number "
            "above 0.");
  EXPECT_EQ(errorOf(*process, RootDrawing().root({0, 0, 0}, 5, 1, 0.1, kTen).pixels().queries()),
            "Environment 'xylem' needs the radius of segments, and the model draws lines of so many pixels. Give the "
            "key 'radius', or 'line style: cylinder' in the view file.");
  // a line that is given no width is drawn with the smallest one
  for (const double width : {0.0, 1e-7}) {
    const auto roots = RootDrawing().root({0, 0, 0}, 5, 1, width, kTen).queries();
    EXPECT_EQ(
        errorOf(*process, roots),
        "Environment 'xylem' needs the radius of segments, and one of plant 0 in the soil, drawn by module 0, has "
        "no width. Give the key 'radius', draw roots with a width, or give a file of roots their diameters.");
    EXPECT_EQ(errorOf(*openProcess("xylem", R"({"radius":0.05})", centimetres()), roots), "");
    EXPECT_EQ(errorOf(*openProcess("xylem", R"({"kr":0})", centimetres()), roots), "");
  }
  std::vector<double> leaf(12, 0.0);
  leaf[2] = 1e-3;
  leaf[10] = 0.0;
  leaf[11] = 0.1;
  EXPECT_EQ(errorOf(*process, RootDrawing().root({0, 0, 0}, 5, 1, 0.1, leaf).queries()),
            "Environment 'xylem' is asked for water that leaves of plant 0 give off, and no segment of that plant "
            "takes any up: all are above 'groundHeight', or 'kr' is 0. Put roots into the ground, give a 'kr', or "
            "'closingHeads', at which leaves close.");
  auto world = centimetres();
  world.world.up = {0, 0, 0};
  EXPECT_NE(std::move(makeProcess("xylem", "").value())->open(world), std::nullopt);
  world = centimetres();
  world.world.lengthUnit = "furlong";
  EXPECT_NE(std::move(makeProcess("xylem", "").value())->open(world), std::nullopt);
}

// -- together with the water of the soil

double storedIn(turtle::EnvironmentProcess& process, double cellVolume) {
  double sum = 0.0;
  for (const turtle::Field& field : process.fields()) {
    if (field.name == "waterContent") {
      for (const double value : field.values) {
        sum += value * cellVolume;
      }
    }
  }
  return sum;
}

const std::string kBox =
    R"("soil":[{"type":"soil-water","gridSize":[4,8,4],"cellSize":[1,1,1],"position":[-2,-8,-2],)" + kLoamLayers +
    R"(,"initialHead":-300,"bottom":"closed"}])";

TEST(Xylem, WhatRootsTakeIsWhatTheSoilLoses) {
  const auto process =
      openProcess("xylem", R"({"transpiration":[[0,2]],"dayCourse":true,"lowestHead":-15000,"kr":0.001,)" + kBox + "}",
                  centimetres());
  auto drawing = RootDrawing()
                     .root({0, 0, 0}, 7.3, 5, 0.1, kTen)
                     .segment({0, -2.92, 0}, {1.7, -4, 1.2}, 0.05, kTen, 1)
                     .nextPlant()
                     .root({0.5, 0, 0.5}, 5, 3, 0.1, kTen);
  double taken = 0.0;
  const double before = storedIn(*process, 1.0);
  for (int day = 0; day < 3; ++day) {
    const auto rows = answersOf(*process, drawing.queries(day));
    taken += *rows[0][kCollarFlow] + *rows[7][kCollarFlow];
    double uptake = 0.0;
    for (const auto& row : rows) {
      uptake += *row[kExchange];
    }
    EXPECT_NEAR(uptake / (*rows[0][kCollarFlow] + *rows[7][kCollarFlow]), 1.0, 1e-9);
    EXPECT_NEAR((before - storedIn(*process, 1.0)) / taken, 1.0, 1e-10);
  }
  EXPECT_GT(taken, 2.0);
  EXPECT_LT(taken, 11.9);  // the soil has become too dry for the whole demand
}

TEST(Xylem, ASavedSoilGoesOnWithTheSameBits) {
  const std::string configuration = R"({"transpiration":[[0,1]],"lowestHead":-15000,"kr":0.001,)" + kBox + "}";
  auto drawing = RootDrawing().root({0, 0, 0}, 7.3, 5, 0.1, kTen);
  const auto process = openProcess("xylem", configuration, centimetres());
  (void)answersOf(*process, drawing.queries(0));
  const std::string state = process->save();
  const auto expected = answersOf(*process, drawing.queries(1));
  const auto restored = openProcess("xylem", configuration, centimetres());
  ASSERT_FALSE(restored->restore(state).has_value());
  EXPECT_EQ(answersOf(*restored, drawing.queries(1)), expected);
  EXPECT_EQ(restored->save(), process->save());
}

TEST(Xylem, AStepWithoutSolutionIsAnErrorAndChangesNothing) {
  const auto process =
      openProcess("xylem",
                  R"({"transpiration":[[0,1]],"soil":[{"type":"soil-water","gridSize":[1,8,1],"cellSize":[4,1,4],)"
                  R"("position":[-2,-8,-2],"specificStorage":1e-30,"bottom":"closed","initialHead":5,)" +
                      kLoamLayers + "}]}",
                  centimetres());
  const std::string before = process->save();
  const std::string error = errorOf(*process, RootDrawing().root({0, 0, 0}, 7, 5, 0.1, kTen).queries());
  EXPECT_EQ(error.find("Environment 'xylem' finds no uptake that fits soil and plants on day "), 0U) << error;
  EXPECT_NE(error.find(": the residual is "), std::string::npos) << error;
  EXPECT_NE(error.find(" of the water content, the tolerance 1.0e-06"), std::string::npos) << error;
  EXPECT_NE(error.find(". Use shorter steps ('longestStep'), larger cells, or a higher 'lowestHead'; leaves that "),
            std::string::npos);
  EXPECT_EQ(process->save(), before);
}

TEST(Xylem, APlantInSoilDrierThanItsLowestHeadGivesNothingOffAndTakesNothingInFromOutside) {
  // the collar is closed at the soil's head; at 'lowestHead' water would come in
  const auto alone =
      openProcess("xylem", R"({"transpiration":[[0,0.01]],"lowestHead":-15000,"soilHead":-20000,"kr":0.001,"kx":0.05})",
                  centimetres());
  const auto rows = answersOf(*alone, RootDrawing().root({0, 0, 0}, 10, 4, 0.1, kTen).queries());
  EXPECT_NEAR(*rows[0][kCollarFlow], 0.0, 1e-9);
  EXPECT_NEAR(*rows[0][kExchange] + *rows[1][kExchange] + *rows[2][kExchange] + *rows[3][kExchange], 0.0, 1e-9);
  EXPECT_LT(*rows[0][kCollarHead], -19'900.0);
  // and with what the lowest head gives, above it
  const auto wetter =
      openProcess("xylem", R"({"transpiration":[[0,0.01]],"lowestHead":-15000,"soilHead":-14993,"kr":0.001,"kx":0.05})",
                  centimetres());
  const auto some = answersOf(*wetter, RootDrawing().root({0, 0, 0}, 10, 4, 0.1, kTen).queries());
  EXPECT_EQ(*some[0][kCollarHead], -15'000.0);
  EXPECT_GT(*some[0][kCollarFlow], 0.0);
  EXPECT_LT(*some[0][kCollarFlow], 0.01);
}

TEST(Xylem, LeavesThatAskForMoreThanTheSoilHasEndTheStep) {
  std::vector<double> leaf(10, 0.0);
  leaf[2] = 5.0;
  const auto drawing = [&] {
    return RootDrawing().root({0, 0, 0}, 8, 3, 0.1, kTen).segment({0, 0, 0}, {0, 10, 0}, 0.2, leaf).queries();
  };
  const std::string soil =
      R"("rhizosphere":true,"soil":[{"type":"soil-water","gridSize":[1,8,1],"cellSize":[4,1,4],"position":[-2,-8,-2],)" +
      kLoamLayers + R"(,"initialHead":-5000,"bottom":"closed"}])";
  const auto process = openProcess("xylem", "{" + soil + "}", centimetres(0.1));
  const std::string before = process->save();
  const std::string error = errorOf(*process, drawing());
  EXPECT_EQ(error.find("Environment 'xylem' finds no uptake that fits soil and plants on day 0: the residual is "), 0U)
      << error;
  EXPECT_NE(error.find("closingHeads"), std::string::npos);
  EXPECT_EQ(process->save(), before);
  // leaves that close are content with what there is
  const auto closing =
      answersOf(*openProcess("xylem", R"({"closingHeads":[-5000,-15000],)" + soil + "}", centimetres(0.1)), drawing());
  EXPECT_NEAR(*closing[3][kCollarFlow], 0.0, 1e-9);
}

TEST(Xylem, TheCourseOfTheDayBeginsAtTheHourOfTheStart) {
  const auto flowAt = [](const std::string& start, std::optional<double> longitude) {
    turtle::EnvironmentContext context = centimetres(1.0 / 24.0);
    context.world.start = start;
    context.world.longitudeDegrees = longitude;
    const auto process = openProcess("xylem", R"({"transpiration":[[0,0.01]],"dayCourse":true,"kr":0.001})", context);
    return *answersOf(*process, RootDrawing().root({0, 0, 0}, 10, 2, 0.1, kTen).queries())[0][kCollarFlow];
  };
  // the mean of 1 - cos 2πt over the hour
  const auto expected = [](double hour) {
    const double turn = 2.0 * std::numbers::pi / 24.0;
    return 0.01 * (1.0 - (std::sin(turn * (hour + 1.0)) - std::sin(turn * hour)) / turn);
  };
  EXPECT_NEAR(flowAt("", std::nullopt), expected(0.0), 1e-12);
  EXPECT_NEAR(flowAt("2026-06-21", std::nullopt), expected(0.0), 1e-10);
  EXPECT_NEAR(flowAt("2026-06-21T12:00", std::nullopt), expected(12.0), 1e-9);
  EXPECT_NEAR(flowAt("2026-06-21T06:00+02:00", std::nullopt), expected(6.0), 1e-9);
  // where the longitude is known, the hour of the sun
  EXPECT_NEAR(flowAt("2026-06-21T06:00+02:00", 30.0), expected(6.0), 1e-9);
  EXPECT_NEAR(flowAt("2026-06-21T06:00Z", -45.0), expected(3.0), 1e-9);
}

TEST(Xylem, ASegmentHasTheRadiusThatItsWidthSays) {
  // `!(0.1)F(5)!(0.04)F(5)` is drawn with a cone, whose start has the width of the segment before
  const auto rows = [](double startWidth) {
    auto queries =
        RootDrawing().segment({0, 0, 0}, {0, -5, 0}, 0.1, kTen).segment({0, -5, 0}, {0, -10, 0}, 0.04, kTen).queries();
    auto geometry = std::make_shared<turtle::Geometry>(*queries.geometry);
    geometry->startWidth[1] = startWidth;
    queries.geometry = geometry;
    return answersOf(*openProcess("xylem", R"({"transpiration":[[0,0.01]],"kr":0.001})", centimetres()), queries);
  };
  EXPECT_EQ(rows(0.04), rows(0.1));
}

TEST(Xylem, RootsCarryWaterFromWetToDrySoilAtNight) {
  // nothing leaves at the collar: what is taken up below leaves the root above
  const std::string soil =
      R"("soil":[{"type":"soil-water","gridSize":[1,8,1],"cellSize":[4,1,4],"position":[-2,-8,-2],)" + kLoamLayers +
      R"(,"initialHeads":[-200,-200,-200,-200,-3000,-3000,-3000,-3000],"bottom":"closed"}])";
  const auto process = openProcess("xylem", R"({"kr":0.001,"kx":0.05,)" + soil + "}", centimetres(0.1));
  const auto rows = answersOf(*process, RootDrawing().root({0, 0, 0}, 8, 8, 0.1, kTen).queries());
  EXPECT_LT(*rows[0][kExchange], 0.0);
  EXPECT_GT(*rows[7][kExchange], 0.0);
  EXPECT_NEAR(*rows[7][kCollarFlow], 0.0, 1e-12);
}

TEST(Xylem, RootsAtRestInSoilAtRestTakeUpNothing) {
  // the head falls by 1 cm on each cm upwards, in the soil and in the root, whose parts have other middles than the
  // cells; with the heads of the middles of cells a part would take up 1e-4 cm3
  const std::string soil =
      R"("soil":[{"type":"soil-water","gridSize":[1,8,1],"cellSize":[4,1,4],"position":[-2,-8,-2],)" + kLoamLayers +
      R"(,"initialHeads":[-292.5,-293.5,-294.5,-295.5,-296.5,-297.5,-298.5,-299.5],"bottom":"closed"}])";
  const auto process = openProcess("xylem", R"({"kr":0.001,"kx":0.05,)" + soil + "}", centimetres(0.1));
  const auto rows = answersOf(*process, RootDrawing().root({0, 0, 0}, 7.3, 5, 0.1, kTen).queries());
  ASSERT_EQ(rows.size(), 5U);
  for (const auto& row : rows) {
    EXPECT_NEAR(*row[kExchange], 0.0, 1e-6);
  }
}

TEST(Xylem, StressAroundOneRootBeginsWhenItsSurfaceIsDry) {
  // benchmark C1.1 (Schnepf et al. 2020): loam and clay from −100 cm between 0.02 and 0.6 cm around 1 cm of root whose
  // surface takes up q cm/day until its head is −15,000 cm; the onsets are those of a transient solution in the
  // cylinder
  struct Case {
    std::string layers;
    double q, onset;
  };
  const std::string clay = R"("layers":[[1000,0.1,0.4,0.01,1.1,10]])";
  for (const Case& one :
       {Case{kLoamLayers, 0.1, 9.98}, {kLoamLayers, 0.05, 20.935}, {clay, 0.1, 8.525}, {clay, 0.05, 17.47}}) {
    const double volume = std::numbers::pi * (0.6 * 0.6 - 0.02 * 0.02);
    const std::string side = std::to_string(std::sqrt(volume));
    const double flow = one.q * 2.0 * std::numbers::pi * 0.02;
    const auto process = openProcess(
        "xylem",
        R"({"transpiration":[[0,)" + std::to_string(flow) + R"(]],"lowestHead":-15000,"kr":1000,"kx":1000000,)" +
            R"("soil":[{"type":"soil-water","gridSize":[1,1,1],"cellSize":[)" + side + ",1," + side +
            R"(],"position":[0,-1,0],"bottom":"closed","initialHead":-100,)" + one.layers + "}]}",
        centimetres(one.onset / 200.0));
    double day = 0.0;
    auto drawing = RootDrawing().segment({0.5, 0, 0.5}, {0.5, -1, 0.5}, 0.04, kTen);
    for (double asked = flow; asked >= 0.999 * flow && day < 30.0; day += one.onset / 200.0) {
      asked = *answersOf(*process, drawing.queries(day))[0][kCollarFlow];
    }
    EXPECT_NEAR(day / one.onset, 1.0, 0.02) << one.layers << " " << one.q;
  }
}

TEST(Xylem, SoilAndPlantsFindTheirUptakeInAllSoilsAndConductances) {
  // soils from sand to clay, wet and dry, roots that conduct ten times more and less, one plant and three: the balance
  // holds, and no plant gets more than it wants
  for (const std::string layers :
       {"[[1000,0.045,0.43,0.15,3,1000]]", "[[1000,0.08,0.43,0.04,1.6,50]]", "[[1000,0.1,0.4,0.01,1.1,10]]",
        "[[3,0.08,0.43,0.04,1.6,50],[1000,0.1,0.4,0.01,1.1,10]]"}) {
    for (const double head : {-20.0, -660.0, -9000.0}) {
      for (const double factor : {0.1, 1.0, 10.0}) {
        const auto process = openProcess(
            "xylem",
            R"({"transpiration":[[0,2]],"dayCourse":true,"lowestHead":-15290,"krTable":[[1,0,)" +
                std::to_string(0.001 * factor) + "],[2,0," + std::to_string(0.004 * factor) + R"(]],"kxTable":[[1,0,)" +
                std::to_string(0.07 * factor) + "],[2,0," + std::to_string(0.0004 * factor) +
                R"(]],"soil":[{"type":"soil-water","gridSize":[4,8,4],"cellSize":[1,1,1],"position":[-2,-8,-2],"layers":)" +
                layers + R"(,"initialHead":)" + std::to_string(head) + R"(,"bottom":"closed"}]})",
            centimetres(0.25));
        const std::size_t plants = factor == 1.0 ? 3 : 1;
        RootDrawing drawing;
        for (std::size_t plant = 0; plant < plants; ++plant) {
          const double x = 0.6 * static_cast<double>(plant) - 0.5;
          drawing.root({x, 0, 0.2}, 7.3, 6, 0.1, kTen);
          drawing.segment({x, -7.3 / 6, 0.2}, {x, -4, 1.2}, 0.05, kTen, 1);
          drawing.nextPlant();
        }
        double taken = 0.0;
        const double before = storedIn(*process, 1.0);
        for (int step = 0; step < 5; ++step) {
          const auto rows = answersOf(*process, drawing.queries(0.25 * step));
          for (std::size_t plant = 0; plant < plants; ++plant) {
            taken += 0.25 * *rows[7 * plant][kCollarFlow];
            EXPECT_LT(*rows[7 * plant][kCollarFlow], 4.0 + 1e-9);
          }
        }
        EXPECT_NEAR(before - storedIn(*process, 1.0), taken, 1e-10 * before) << layers << head << " " << factor;
      }
    }
  }
}

TEST(Xylem, MirroredRootsAndOtherOrdersOfPlantsTakeUpTheSame) {
  // the box and its soil are the same mirrored in x
  const std::string configuration =
      R"({"transpiration":[[0,1.5]],"dayCourse":true,"lowestHead":-15000,"kr":0.001,)" + kBox + "}";
  const auto flowsOf = [&](double side, bool isTurned) {
    RootDrawing drawing;
    for (const bool isFirst : {!isTurned, isTurned}) {
      const double x = isFirst ? 0.4 : -1.1;
      drawing.root({side * x, 0, 0.3}, isFirst ? 7.3 : 5.1, 5, 0.1, kTen).nextPlant();
    }
    const auto process = openProcess("xylem", configuration, centimetres());
    std::vector<double> flows;
    for (int day = 0; day < 2; ++day) {
      const auto rows = answersOf(*process, drawing.queries(day));
      flows.push_back(*rows[isTurned ? 5 : 0][kExchange]);
      flows.push_back(*rows[isTurned ? 0 : 5][kExchange]);
    }
    return flows;
  };
  const std::vector<double> flows = flowsOf(1.0, false);
  for (const auto& other : {flowsOf(-1.0, false), flowsOf(1.0, true)}) {
    for (std::size_t i = 0; i < flows.size(); ++i) {
      EXPECT_NEAR(other[i], flows[i], 1e-5 * std::abs(flows[i]));
    }
  }
}

TEST(Xylem, RootsThatAreTurnedByARightAngleTakeUpTheSame) {
  // the box and its soil are the same turned by a quarter about the vertical
  const std::string configuration =
      R"({"transpiration":[[0,1.5]],"dayCourse":true,"lowestHead":-15000,"kr":0.001,)" + kBox + "}";
  const auto flowsOf = [&](bool isTurned) {
    const auto place = [isTurned](double x, double y, double z) {
      return isTurned ? core::Vec3{z, y, -x} : core::Vec3{x, y, z};
    };
    RootDrawing drawing;
    drawing.root(place(0.4, 0, -0.3), 7.3, 5, 0.1, kTen)
        .segment(place(0.4, -2.92, -0.3), place(1.7, -4, 0.2), 0.05, kTen, 1)
        .segment(place(0.4, -4.38, -0.3), place(0.3, -4.6, -1.8), 0.05, kTen, 1)
        .nextPlant()
        .root(place(-1.1, 0, 1.3), 4.9, 4, 0.08, kTen);
    const auto process = openProcess("xylem", configuration, centimetres());
    std::vector<double> flows;
    for (int day = 0; day < 2; ++day) {
      for (const auto& row : answersOf(*process, drawing.queries(day))) {
        flows.push_back(*row[kExchange]);
      }
    }
    return flows;
  };
  const std::vector<double> flows = flowsOf(false);
  const std::vector<double> turned = flowsOf(true);
  for (std::size_t i = 0; i < flows.size(); ++i) {
    EXPECT_NEAR(turned[i], flows[i], 1e-5 * std::abs(flows[i])) << i;
  }
}

TEST(Xylem, HeadsShiftTogether) {
  // without soil that resists and without gravity all heads lie higher by what the soil's and the collar's do
  const auto headOf = [](double shift) {
    const auto process = openProcess("xylem",
                                     R"({"collar":"head","collarHead":)" + std::to_string(-1000.0 + shift) +
                                         R"(,"soilHead":)" + std::to_string(-200.0 + shift) + "}",
                                     centimetres());
    return *answersOf(*process, RootDrawing().segment({0, 0, 0}, {9, 0, 0}, 0.1, kTen).queries())[0][kHead];
  };
  EXPECT_NEAR(headOf(-5000.0), headOf(0.0) - 5000.0, 1e-8);
}

// a root that is wider than its cell takes from the cells around it: how fine the grid is does not matter
TEST(Xylem, TheUptakeOfAWideRootDoesNotDependOnTheCells) {
  std::vector<double> uptakes;
  for (const auto& [cells, size] :
       {std::pair("15", "0.4"), {"25", "0.24"}, {"41", "0.146341463414634"}, {"61", "0.0983606557377049"}}) {
    const auto process = openProcess(
        "xylem",
        std::string(
            R"({"collar":"head","collarHead":-3000,"kr":0.01,"kx":100,"soil":[{"type":"soil-water","gridSize":[)") +
            cells + ",1," + cells + R"(],"cellSize":[)" + size + ",1," + size +
            R"(],"position":[-3,-1,-3],"initialHead":-100,)" + kLoamLayers + R"(,"bottom":"closed"}]})",
        centimetres(0.25));
    const auto rows = answersOf(*process, RootDrawing().segment({0, 0, 0}, {0, -1, 0}, 0.3, kTen).queries());
    uptakes.push_back(*rows[0][kExchange]);
  }
  for (const double uptake : uptakes) {
    EXPECT_NEAR(uptake / uptakes.back(), 1.0, 0.02) << uptake;
  }
}

}  // namespace
}  // namespace espalier::environment::xylem_test
