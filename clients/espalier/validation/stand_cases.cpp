// Benchmarks of stands and trees: shares of the ground, saturated seeding, self-thinning, pipes. Lengths in m.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>

#include "clients/espalier/validation/closed_forms.h"
#include "clients/espalier/validation/process_run.h"
#include "clients/espalier/validation/validation.h"
#include "engine/core/check.h"
#include "engine/core/elementary.h"
#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/scene/geometry.h"
#include "environment/base/number_text.h"

namespace espalier::validation {

namespace {

using core::Vec3;
using environment::numberText;
using std::numbers::pi;

/// Numbers between 0 and 1, always the same (SplitMix64: Steele, Lea & Flood 2014).
class Dice {
 public:
  explicit Dice(std::uint64_t seed = 7) : state_(seed) {}
  double next() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t mixed = (state_ ^ (state_ >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    mixed = (mixed ^ (mixed >> 27U)) * 0x94D049BB133111EBULL;
    return static_cast<double>((mixed ^ (mixed >> 31U)) >> 11U) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

std::string extentOf(double side) {
  return R"("periodic":true,"extent":[0,)" + numberText(side) + ",0," + numberText(side) + "]";
}

/// Plants at random, in number density times area.
std::vector<Vec3> plantsAtRandom(std::size_t count, double side) {
  Dice dice;
  std::vector<Vec3> places;
  for (std::size_t i = 0; i < count; ++i) {
    places.push_back({side * dice.next(), 0.0, side * dice.next()});
  }
  return places;
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) {
    sum += value;
  }
  return sum / static_cast<double>(values.size());
}

/// The first or second answer of every plant.
std::vector<double> column(const turtle::ReplyBatch& replies, std::size_t width, std::size_t k) {
  std::vector<double> values;
  for (std::size_t i = k; i < replies.values.size(); i += width) {
    values.push_back(replies.values[i]);
  }
  return values;
}

double meanShare(double density, double radius) {
  constexpr std::size_t kPlants = 20'000;
  const double side = std::sqrt(kPlants / density);
  const auto run =
      runProcess("crowding", "{" + extentOf(side) + "}", queriesAt(plantsAtRandom(kPlants, side), {radius, 0.0}));
  return mean(column(run.replies, 2, 1));
}

/// Mean shares of plants of which these parts of all are stronger.
std::vector<double> sharesOfRanks(double density, double radius, const std::vector<double>& ranks) {
  constexpr std::size_t kPlants = 80'000;
  const double side = std::sqrt(kPlants / density);
  turtle::QueryBatch queries = queriesAt(plantsAtRandom(kPlants, side), {radius, 0.0, 0.0});
  Dice dice(11);
  for (std::size_t i = 0; i < kPlants; ++i) {
    queries.parameters[3 * i + 2] = dice.next();
  }
  const auto run = runProcess("crowding", R"({"competition":"largest",)" + extentOf(side) + "}", queries);
  std::vector<double> means;
  for (const double stronger : ranks) {
    // plants of about that rank
    std::vector<double> shares;
    for (std::size_t i = 0; i < kPlants; ++i) {
      if (std::abs(1.0 - queries.parameters[3 * i + 2] - stronger) < 0.05) {
        shares.push_back(run.replies.values[3 * i + 1]);
      }
    }
    means.push_back(mean(shares));
  }
  return means;
}

/// The part of the ground under zones: seeds that fall there do not germinate.
double coverage(double density, double radius) {
  constexpr std::size_t kPlants = 10'000;
  constexpr std::size_t kSeeds = 40'000;
  const double side = std::sqrt(kPlants / density);
  std::vector<Vec3> places = plantsAtRandom(kPlants + kSeeds, side);
  turtle::QueryBatch queries = queriesAt(places, {radius, 0.0});
  for (std::size_t i = kPlants; i < kPlants + kSeeds; ++i) {
    queries.parameters[2 * i] = 0.0;
  }
  const auto run = runProcess("crowding", R"({"samples":1,)" + extentOf(side) + "}", queries);
  double germinated = 0.0;
  for (std::size_t i = kPlants; i < kPlants + kSeeds; ++i) {
    germinated += run.replies.values[2 * i];
  }
  return 1.0 - germinated / kSeeds;
}

/// The part of plants that no other is near, by a process that blocks those that meet, away from the border.
double alone(const std::string& name, const std::string& configuration, std::size_t count, double density,
             double radius, double parameter) {
  const double side = std::sqrt(static_cast<double>(count) / density);
  const std::vector<Vec3> places = plantsAtRandom(count, side);
  const auto run = runProcess(name, configuration, queriesAt(places, {parameter}));
  std::vector<double> free;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3& place = places[i];
    if (std::min({place.x, place.z, side - place.x, side - place.z}) > radius) {
      free.push_back(run.replies.values[i]);
    }
  }
  return mean(free);
}

double lens(double first, double second, double distance) {
  const auto run = runProcess("crowding", R"({"competition":"largest","samples":4000})",
                              queriesWith({{0, 0, 0}, {distance, 0, 0}}, {{first, 0.0, 1.0}, {second, 0.0, 2.0}}));
  // the weaker one loses the area that both have
  return (1.0 - run.replies.values[1]) * pi * first * first;
}

CaseResult stands(const Data&) {
  CaseResult result;
  const auto add = [&](const std::string& what, double found, double expected, double tolerance) {
    result.rows.push_back({what + ", relative", std::abs(found / expected - 1.0), tolerance, ""});
  };
  constexpr double kZone = 5.0;
  result.across = "mean number of zones over a point";
  result.up = "part";
  Curve shareCurve{"mean share", false, {}};
  Curve coverCurve{"covered ground", false, {}};
  // m: mean number of zones over a point
  const auto meanOf = [](double density) { return density * pi * kZone * kZone; };
  for (const double density : {0.01, 0.02, 0.05}) {
    const double m = meanOf(density);
    const double share = meanShare(density, kZone);
    add("crowding, mean share of equal zones, density " + numberText(density), share, (1.0 - core::exp(-m)) / m, 0.01);
    shareCurve.points.emplace_back(m, share);
  }
  const std::vector<double> ranks{0.25, 0.75};
  const std::vector<double> shares = sharesOfRanks(0.02, kZone, ranks);
  for (std::size_t k = 0; k < ranks.size(); ++k) {
    add("crowding, the strongest takes all, " + numberText(ranks[k]) + " are stronger", shares[k],
        core::exp(-meanOf(0.02) * ranks[k]), 0.03);
  }
  for (const double density : {0.02, 0.05}) {
    const double covered = coverage(density, kZone);
    add("crowding, covered ground, density " + numberText(density), covered, 1.0 - core::exp(-meanOf(density)), 0.01);
    coverCurve.points.emplace_back(meanOf(density), covered);
  }
  // one plant in fifty stands alone in the denser stand, so more are looked at
  for (const auto& [density, count] : {std::pair{0.02, std::size_t{160'000}}, {0.05, std::size_t{400'000}}}) {
    const std::string words = ", plants that stand alone, density " + numberText(density);
    const double free = core::exp(-meanOf(density));
    add("honda" + words, alone("honda", R"({"radius":)" + numberText(kZone) + "}", count, density, kZone, 1.0), free,
        0.02);
    add("ecosystem" + words, alone("ecosystem", "{}", count, density, kZone, 0.5 * kZone), free, 0.02);
  }
  add("crowding, lens of equal discs", lens(2, 2, 1), lensArea(2, 2, 1), 0.005);
  add("crowding, lens of two discs", lens(3, 2, 2.5), lensArea(3, 2, 2.5), 0.005);
  Curve exactShare{"mean share, exact", true, {}};
  Curve exactCover{"covered ground, exact", true, {}};
  for (double m = 0.5; m <= 4.0; m += 0.1) {
    exactShare.points.emplace_back(m, (1.0 - core::exp(-m)) / m);
    exactCover.points.emplace_back(m, 1.0 - core::exp(-m));
  }
  result.curves = {std::move(shareCurve), std::move(exactShare), std::move(coverCurve), std::move(exactCover)};
  return result;
}

/// Seeds that live only where no zone of radius 1 is: random sequential adsorption of discs of diameter 1.
CaseResult saturatedSeeding(const Data&) {
  constexpr double kSide = 32.0;
  constexpr std::size_t kTries = 2500 * 1024;
  constexpr std::size_t kBatch = 1024;
  Dice dice;
  std::vector<Vec3> plants;
  auto process = openProcess("crowding", R"({"samples":1,)" + extentOf(kSide) + "}");
  Curve seeded{"crowding", false, {}};
  const auto apart = [](double a, double b) { return std::min(std::abs(a - b), kSide - std::abs(a - b)); };
  for (std::size_t tries = 0; tries < kTries; tries += kBatch) {
    std::vector<Vec3> places = plants;
    for (std::size_t i = 0; i < kBatch; ++i) {
      places.push_back({kSide * dice.next(), 0.0, kSide * dice.next()});
    }
    turtle::QueryBatch queries = queriesAt(places, {1.0, 0.0});
    for (std::size_t i = plants.size(); i < places.size(); ++i) {
      queries.parameters[2 * i] = 0.0;
    }
    const turtle::ReplyBatch replies = stepOf(*process, queries);
    // of seeds that come at once and too near each other the first lives
    const std::size_t before = plants.size();
    for (std::size_t i = before; i < places.size(); ++i) {
      const bool isFree =
          std::none_of(plants.begin() + static_cast<std::ptrdiff_t>(before), plants.end(), [&](const Vec3& other) {
            return std::hypot(apart(places[i].x, other.x), apart(places[i].z, other.z)) < 1.0;
          });
      if (replies.values[2 * i] == 1.0 && isFree) {
        plants.push_back(places[i]);
      }
    }
    const double all = static_cast<double>(tries + kBatch) / (kSide * kSide);
    seeded.points.emplace_back(core::log10(all), static_cast<double>(plants.size()) / (kSide * kSide));
  }
  const double density = static_cast<double>(plants.size()) / (kSide * kSide);
  CaseResult result;
  result.rows = {{"crowding, N R^2/area beyond 0.69 after 2500 tries per R^2", std::abs(density - 0.69), 0.01, ""}};
  result.across = "log10 of tries per R^2";
  result.up = "N R^2/area";
  Curve limit{"limit, Hinrichsen, Feder & Jossang 1986", true, {{0.0, 0.697}, {seeded.points.back().first, 0.697}}};
  result.curves = {std::move(seeded), std::move(limit)};
  return result;
}

/// The slope of y on x by reduced major axis, for a relation that falls.
double fallingSlope(const std::vector<std::pair<double, double>>& points) {
  double x = 0.0;
  double y = 0.0;
  for (const auto& [first, second] : points) {
    x += first / static_cast<double>(points.size());
    y += second / static_cast<double>(points.size());
  }
  double xx = 0.0;
  double yy = 0.0;
  for (const auto& [first, second] : points) {
    xx += (first - x) * (first - x);
    yy += (second - y) * (second - y);
  }
  return -std::sqrt(yy / xx);
}

/// The slope of log mean mass on log density by reduced major axis, of plants that keep their shape: radius grows by
/// the share, mass is a power of the radius.
CaseResult selfThinning(const Data&) {
  struct Shape {
    const char* name;
    double power;
    std::vector<std::pair<double, double>> points;  // log density, log mean mass
  };
  std::array<Shape, 3> shapes{Shape{"3", 3.0, {}}, Shape{"8/3", 8.0 / 3.0, {}}, Shape{"2", 2.0, {}}};
  constexpr double kSide = 100.0;
  Dice dice;
  std::vector<Vec3> places = plantsAtRandom(12'000, kSide);
  std::vector<double> radii;
  for (std::size_t i = 0; i < places.size(); ++i) {
    radii.push_back(0.3 + 0.3 * dice.next());
  }
  auto process = openProcess("crowding", R"({"samples":48,"leastShare":0.35,"asymmetry":2,)" + extentOf(kSide) + "}");
  for (int step = 0; step < 200 && places.size() > 150; ++step) {
    turtle::QueryBatch queries = queriesAt(places, {0.0, 0.35});
    double covered = 0.0;
    for (std::size_t i = 0; i < radii.size(); ++i) {
      queries.parameters[2 * i] = radii[i];
      covered += pi * radii[i] * radii[i] / (kSide * kSide);
    }
    const turtle::ReplyBatch replies = stepOf(*process, queries);
    std::vector<Vec3> living;
    std::vector<double> larger;
    for (std::size_t i = 0; i < radii.size(); ++i) {
      if (replies.values[2 * i] == 1.0) {
        living.push_back(places[i]);
        larger.push_back(radii[i] * (1.0 + 0.05 * replies.values[2 * i + 1]));
      }
    }
    places = std::move(living);
    radii = std::move(larger);
    // the canopy is closed once zones overlap a good deal, and less than a quarter of the plants is left
    if (covered > 1.0 && places.size() < 3000) {
      const auto count = static_cast<double>(places.size());
      for (Shape& shape : shapes) {
        double mass = 0.0;
        for (const double radius : radii) {
          mass += core::pow(radius, shape.power);
        }
        shape.points.emplace_back(core::log(count), core::log(mass / count));
      }
    }
  }
  CaseResult result;
  for (Shape& shape : shapes) {
    const double slope = fallingSlope(shape.points);
    const std::string name = std::string("mass as R^") + shape.name;
    result.rows.push_back({"crowding, " + name + ", slope " + numberText(std::round(slope * 1e3) / 1e3) + " from " +
                               numberText(-0.5 * shape.power).substr(0, 6),
                           std::abs(slope + 0.5 * shape.power), 0.1, ""});
    result.across = "ln density";
    result.up = "ln mean mass";
    // the line of that slope through the middle of the points
    const auto& from = shape.points.front();
    const auto& to = shape.points.back();
    const auto lineAt = [&](double x) {
      return 0.5 * (from.second + to.second) - 0.5 * shape.power * (x - 0.5 * (from.first + to.first));
    };
    Curve law{name + ", slope " + numberText(-0.5 * shape.power).substr(0, 6),
              true,
              {{from.first, lineAt(from.first)}, {to.first, lineAt(to.first)}}};
    result.curves.push_back({name, false, std::move(shape.points)});
    result.curves.push_back(std::move(law));
  }
  return result;
}

// ---- pipes

/// Conductance of a straight root of 0.5 m by the process `xylem`, whose xylem is so many vessels of a radius in
/// micrometres.
double rootOfVessels(double count, double radius, double rootRadius, double kr) {
  auto geometry = std::make_shared<turtle::Geometry>();
  geometry->start.push_back({0, 0, 0});
  geometry->end.push_back({0, -0.5, 0});
  geometry->startWidth.push_back(2.0 * rootRadius);
  geometry->endWidth.push_back(2.0 * rootRadius);
  geometry->segments.plant.push_back(0);
  geometry->segments.module.push_back(0);
  geometry->segments.symbol.push_back(1);
  geometry->segments.colour.push_back(0);
  geometry->segments.branchOrder.push_back(0);
  turtle::QueryBatch queries = queriesAt({{0, -0.5, 0}}, std::vector<double>(10, 0.0));
  queries.module.front() = 1;
  queries.geometry = geometry;
  const std::string keys = R"({"collar":"head","collarHead":-5,"soilHead":-1,"kr":)" + numberText(kr) +
                           R"(,"vessels":[[1,0,)" + numberText(count) + "," + numberText(radius) + "]]}";
  return runProcess("xylem", keys, queries).replies.values[7];
}

/// A mother branch whose width^p is the sum of those of its daughters, which have the width 1: the ratio of the widths
/// by a model that adds them from the tips.
double ratioOfModel(int daughters, double exponent) {
  std::string tips;
  std::string context;
  std::string sum;
  for (int k = 0; k < daughters; ++k) {
    const std::string name = "w" + std::to_string(k);
    tips += "[T(1)]";
    context += "[T(" + name + ")]";
    sum += (k == 0 ? "" : "+") + name + "^p";
  }
  core::MemoryFileProvider files;
  files.add("pipes.l", "#define p " + numberText(exponent) + "\nLsystem: 1\nderivation length: 1\nAxiom: M(0)" + tips +
                           "\nM(w) > " + context + " --> M((" + sum + ")^(1/p))\nendlsystem\n");
  language::CompileInput input;
  input.modelFile = "pipes.l";
  const language::CompileResult compiled = language::compile(input, files);
  ESPALIER_CHECK(compiled.program != nullptr);
  simulation::Simulation plant(compiled.program, {turtle::PlantPlacement{}}, nullptr, {});
  ESPALIER_CHECK(!plant.rewind() && !plant.step());
  const std::string text = plant.stringText();
  return 1.0 / std::stod(text.substr(text.find('(') + 1));
}

CaseResult pipes(const Data&) {
  // Hagen and Poiseuille: N pi r^4 rho g/(8 mu) in cm3/day, with water at 20 degrees
  constexpr double kRootRadius = 0.002;
  constexpr double kRadial = 0.017;
  LargestError vessels;
  for (const auto& [radius, count, conductance] : {std::tuple{20.0, 1.0, 0.05305637}, {50.0, 6.0, 12.435087}}) {
    const double kx = conductance * 1e-6;
    const double perLength = 2.0 * pi * kRootRadius * kRadial;
    const double decay = core::exp(-2.0 * std::sqrt(perLength / kx) * 0.5);
    const double expected = std::sqrt(perLength * kx) * (1.0 - decay) / (1.0 + decay);  // the hyperbolic tangent
    vessels.add(std::abs(rootOfVessels(count, radius, kRootRadius, kRadial) / expected - 1.0));
  }
  LargestError ratios;
  for (const auto& [daughters, exponent, ratio] :
       {std::tuple{2, 2.0, 0.70710678}, {2, 3.0, 0.79370053}, {3, 2.5, 0.64439401}}) {
    ratios.add(std::abs(ratioOfModel(daughters, exponent) / ratio - 1.0));
  }
  CaseResult result;
  result.rows = {{"xylem, a root of 1 vessel of 20 um or 6 of 50 um, relative", vessels.value(), 1e-7, ""},
                 {"widths by the pipe model, exponents 2, 2.5 and 3, relative", ratios.value(), 1e-7, ""}};
  return result;
}

}  // namespace

std::span<const Case> standCases() {
  static constexpr std::array<Case, 4> kCases{
      {{"stands", "Shares of the ground between plants at random: closed forms", true, stands},
       {"seeding", "Seeds that live only where no zone is: Hinrichsen, Feder & Jossang 1986", false, saturatedSeeding},
       {"self-thinning", "Mean mass on density in a closed stand: Yoda et al. 1963", true, selfThinning},
       {"pipes", "Vessels (Hagen 1839, Poiseuille 1846) and widths of branches by the pipe model: closed forms", true,
        pipes}}};
  return kCases;
}

}  // namespace espalier::validation
