#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/environment/query_builder.h"

namespace espalier::environment::colonization_test {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// The answer to a bud that sends (1, 0, 0, 0, 0).
struct Answer {
  double quality;
  core::Vec3 direction;
  double markerCount;
};

std::vector<Answer> budAnswers(turtle::EnvironmentProcess& process, const std::vector<core::Vec3>& buds,
                               const core::Vec3& heading = {0, 1, 0}) {
  QueryBuilder builder;
  for (const core::Vec3& bud : buds) {
    builder.add(bud, {1, 0, 0, 0, 0});
    builder.batch().heading.back() = heading;
  }
  std::vector<Answer> answers;
  for (const auto& row : answersOf(process, builder.batch())) {
    answers.push_back({*row[0], {*row[1], *row[2], *row[3]}, *row[4]});
  }
  return answers;
}

TEST(Colonization, ABudPerceivesTheMarkersInItsCone) {
  // heading up, cone of 90°: markers 44° and 46° from the heading, at distances 3.9 and 4.1, and one behind
  const auto at = [](double degrees, double distance) {
    const double angle = degrees * kPi / 180;
    return "[" + std::to_string(distance * std::sin(angle)) + "," + std::to_string(distance * std::cos(angle)) + ",0]";
  };
  const auto countOf = [&](const std::string& points, const std::string& more = "") {
    const auto process = openProcess("colonization", R"({"occupancyRadius":1,"points":[)" + points + "]" + more + "}");
    return budAnswers(*process, {{0, 0, 0}})[0].markerCount;
  };
  EXPECT_EQ(countOf(at(44, 3.9)), 1);
  EXPECT_EQ(countOf(at(46, 3.9)), 0);
  EXPECT_EQ(countOf(at(-44, 4.1)), 0);
  EXPECT_EQ(countOf(at(180, 2)), 0);
  EXPECT_EQ(countOf(at(180, 2), R"(,"perceptionAngle":360)"), 1);
  EXPECT_EQ(countOf(at(44, 4.1), R"(,"perceptionRadius":4.2)"), 1);
  EXPECT_EQ(countOf(at(0, 0.9)), 0) << "in the zone of occupancy";
}

TEST(Colonization, TheDirectionIsTheUnitVectorAlongTheSumOfUnitVectors) {
  // unit vectors (0.6, 0.8, 0) and (0, 1, 0), whatever the distances: sum (0.6, 1.8, 0), length 0.6 √10
  const auto process = openProcess("colonization", R"({"points":[[1.8,2.4,0],[0,2.5,0]]})");
  const Answer answer = budAnswers(*process, {{0, 0, 0}})[0];
  EXPECT_EQ(answer.quality, 1);
  EXPECT_EQ(answer.markerCount, 2);
  EXPECT_NEAR(answer.direction.x, 1 / std::sqrt(10.0), 1e-15);
  EXPECT_NEAR(answer.direction.y, 3 / std::sqrt(10.0), 1e-15);
  EXPECT_EQ(answer.direction.z, 0);
}

TEST(Colonization, OppositeMarkersGiveNoDirection) {
  const auto process = openProcess("colonization", R"({"points":[[3,0,0],[-3,0,0]],"perceptionAngle":360})");
  const Answer answer = budAnswers(*process, {{0, 0, 0}})[0];
  EXPECT_EQ(answer.quality, 1);
  EXPECT_EQ(answer.direction, core::Vec3());
}

TEST(Colonization, AMarkerBelongsToTheNearestBudAndToAllThatAreEquallyNear) {
  const char* const configuration = R"({"points":[[0,3,0]],"perceptionAngle":180,"occupancyRadius":0.5})";
  auto answers = budAnswers(*openProcess("colonization", configuration), {{1, 0, 0}, {0, 0, 0}, {-1, 0, 0}});
  EXPECT_EQ(answers[0].quality, 0);
  EXPECT_EQ(answers[0].direction, core::Vec3());
  EXPECT_EQ(answers[1].quality, 1);
  EXPECT_EQ(answers[1].direction, (core::Vec3{0, 1, 0}));
  EXPECT_EQ(answers[2].quality, 0);
  answers = budAnswers(*openProcess("colonization", configuration), {{1, 0, 0}, {-1, 0, 0}});
  EXPECT_EQ(answers[0].quality, 1);
  EXPECT_EQ(answers[1].quality, 1);
}

TEST(Colonization, OccupiedMarkersAreGoneForGoodAndBeforeAnyoneLooks) {
  const auto process = openProcess("colonization", R"({"points":[[0,3,0],[0,3.5,0]],"occupancyRadius":0.2})");
  // a node without parameters takes one of the two markers away in the step in which the bud looks
  QueryBuilder builder;
  builder.add({0, 0, 0}, {1, 0, 0, 0, 0}).add({0, 3, 0.1}, {});
  const auto table = answersOf(*process, builder.batch());
  EXPECT_EQ(table[0][4], 1.0);
  EXPECT_TRUE(table[1].empty());
  EXPECT_EQ(budAnswers(*process, {{0, 0, 0}})[0].markerCount, 1);
  // a query with p1 = 0 occupies and perceives nothing
  EXPECT_EQ(answersOf(*process, QueryBuilder().add({0, 3.5, 0}, {0, 0}).batch())[0],
            (std::vector<std::optional<double>>{0.0, 0.0}));
  EXPECT_EQ(budAnswers(*process, {{0, 0, 0}})[0].markerCount, 0);
}

TEST(Colonization, UniformMarkersFillTheConeByItsVolume) {
  // A spherical sector of half angle θ/2 between the radii ρ and r has the volume 2π/3 (r³ − ρ³)(1 − cos θ/2). Of N
  // uniform markers in a box of volume B it holds a binomial number with p = volume/B. The test fails by chance with a
  // probability below 10⁻⁶ (5 standard deviations), and the seed is fixed. The sum of the unit vectors points along the
  // heading: the mean transverse component has the standard deviation √(⟨sin²⟩/2/n) < √(0.25/n).
  turtle::EnvironmentContext context;
  context.seed = 17;
  const auto process = openProcess(
      "colonization", R"({"markerCount":200000,"markerBox":[-5,-5,-5,5,5,5],"occupancyRadius":2})", context);
  const double sector = 2 * kPi / 3 * (64 - 8) * (1 - std::cos(kPi / 4));
  const double p = sector / 1000;
  const Answer answer = budAnswers(*process, {{0.3, -0.2, 0.1}}, {1, 0, 0})[0];
  EXPECT_NEAR(answer.markerCount, 200000 * p, 5 * std::sqrt(200000 * p * (1 - p)));
  const double error = 5 * std::sqrt(0.25 / answer.markerCount);
  EXPECT_NEAR(answer.direction.y, 0, error);
  EXPECT_NEAR(answer.direction.z, 0, error);
  EXPECT_GT(answer.direction.x, 0.99);
}

TEST(Colonization, RandomMarkersLieInTheEnvelopeAndDependOnTheSeedOnly) {
  const std::string configuration =
      R"({"markerCount":500,"markerBox":[-3,0,-3,3,6,3],"spheres":[[0,3,0,2]],"perceptionAngle":360,)"
      R"("perceptionRadius":2.0001,"occupancyRadius":0})";
  turtle::EnvironmentContext context;
  const auto process = openProcess("colonization", configuration, context);
  EXPECT_EQ(budAnswers(*process, {{0, 3, 0}})[0].markerCount, 500);
  // the markers of the same seed, and of another seed
  const core::Vec3 first = budAnswers(*process, {{0, 3.5, 0}})[0].direction;
  EXPECT_EQ(budAnswers(*openProcess("colonization", configuration, context), {{0, 3.5, 0}})[0].direction, first);
  context.seed = 1;
  EXPECT_NE(budAnswers(*openProcess("colonization", configuration, context), {{0, 3.5, 0}})[0].direction, first);
}

TEST(Colonization, AgreesWithComparingAllPairs) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> place(0.0, 10.0);
  std::vector<core::Vec3> markers;
  std::string points;
  for (int i = 0; i < 300; ++i) {
    markers.push_back({std::floor(place(random) * 8) / 8, std::floor(place(random) * 8) / 8, place(random)});
    points += (i == 0 ? "" : ",") + ("[" + std::to_string(markers.back().x)) + "," + std::to_string(markers.back().y);
    markers.back().z = std::floor(markers.back().z * 8) / 8;
    points += "," + std::to_string(markers.back().z) + "]";
  }
  std::vector<core::Vec3> buds;
  for (int i = 0; i < 60; ++i) {
    buds.push_back({place(random), place(random), place(random)});
  }
  const auto process =
      openProcess("colonization", R"({"occupancyRadius":0.75,"perceptionRadius":2.5,"points":[)" + points + "]}");
  const core::Vec3 heading = core::normalised({1, 2, -1});
  const auto answers = budAnswers(*process, buds, heading);
  const double cosine = std::cos(kPi / 4);
  std::vector<double> expected(buds.size(), 0.0);
  for (const core::Vec3& marker : markers) {
    double nearest = 1e9;
    bool isOccupied = false;
    std::size_t owner = buds.size();
    for (std::size_t bud = 0; bud < buds.size(); ++bud) {
      const core::Vec3 way = marker - buds[bud];
      const double distance = core::length(way);
      isOccupied |= distance <= 0.75;
      if (distance <= 2.5 && core::dot(way, heading) >= cosine * distance && distance < nearest) {
        nearest = distance;
        owner = bud;
      }
    }
    if (!isOccupied && owner < buds.size()) {
      expected[owner] += 1;
    }
  }
  double total = 0;
  for (std::size_t bud = 0; bud < buds.size(); ++bud) {
    EXPECT_EQ(answers[bud].markerCount, expected[bud]) << bud;
    total += expected[bud];
  }
  EXPECT_GT(total, 20);
}

TEST(Colonization, AnEmptyEnvelopeAndATurnedBoxAreErrors) {
  auto made = makeProcess("colonization", R"({"markerCount":10,"spheres":[[50,0,0,1]]})");
  EXPECT_EQ(made.value()->open({})->message,
            "Environment 'colonization' finds hardly any place for its markers: less than a thousandth of 'markerBox' "
            "lies in the envelope. Put the box close around the solids.");
  EXPECT_EQ(errorsOf(makeProcess("colonization", R"({"markerBox":[0,0,0,1,-1,1]})")),
            "error: environment process 'colonization': 'markerBox' has a first corner beyond the second\n"
            "   hint: write the smallest x, y, z, then the largest x, y, z");
}

}  // namespace
}  // namespace espalier::environment::colonization_test
