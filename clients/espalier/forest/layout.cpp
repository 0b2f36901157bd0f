#include "clients/espalier/forest/layout.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <unordered_map>

#include "engine/core/check.h"
#include "engine/core/elementary.h"
#include "engine/core/random.h"
#include "environment/registry.h"

namespace espalier::command {
namespace {

constexpr std::uint32_t kLayoutDraws = 3;
constexpr double kJitter = 0.4;  // of a cell: a fifth of it stays between two trees

class LayoutDraws {
 public:
  explicit LayoutDraws(std::uint64_t seed) : random_(seed, 0) {}
  double uniform() { return random_.uniform(core::DrawDomain::Environment, kLayoutDraws, draw_++, 0); }
  std::size_t below(std::size_t count) { return static_cast<std::size_t>(uniform() * static_cast<double>(count)); }

 private:
  core::CounterRandom random_;
  std::uint64_t draw_ = 0;
};

TreePlace placeAt(double x, double z, LayoutDraws& draws) {
  return {.position = {x, 0.0, z}, .turnRadians = 2.0 * std::numbers::pi * draws.uniform(), .size = 1.0};
}

// anywhere in the disc that has the area of a square of that side
TreePlace somewhere(double side, LayoutDraws& draws) {
  const double radius = side * std::sqrt(draws.uniform() / std::numbers::pi);
  const double angle = 2.0 * std::numbers::pi * draws.uniform();
  return placeAt(radius * core::cos(angle), radius * core::sin(angle), draws);
}

// a half more points than trees, so that the grid has glades, the nearest to the middle; each tree up to `jitter` cells
// off its point
std::vector<TreePlace> onGrid(std::size_t count, double distance, double jitter, LayoutDraws& draws) {
  const auto most = static_cast<std::size_t>(std::ceil(1.5 * static_cast<double>(count)));
  const auto side =
      static_cast<std::size_t>(std::ceil(2.0 * std::sqrt(static_cast<double>(most) / std::numbers::pi))) + 2;
  const double middle = static_cast<double>(side - 1) / 2.0;
  std::vector<core::Vec3> points;
  for (std::size_t i = 0; i < side * side; ++i) {
    points.push_back({static_cast<double>(i % side) - middle, 0.0, static_cast<double>(i / side) - middle});
  }
  std::ranges::stable_sort(points, {}, [](const core::Vec3& point) { return core::length(point); });
  points.resize(most);
  std::vector<TreePlace> places;
  for (std::size_t i = 0; i < count; ++i) {
    // the first steps of the shuffle of Fisher and Yates
    std::swap(points[i], points[i + draws.below(points.size() - i)]);
    places.push_back(placeAt(points[i].x * distance, points[i].z * distance, draws));
    if (jitter > 0.0) {
      core::Vec3& position = places.back().position;
      position.x += (2.0 * draws.uniform() - 1.0) * jitter * distance;
      position.z += (2.0 * draws.uniform() - 1.0) * jitter * distance;
    }
  }
  return places;
}

// darts, of which those too near to another are thrown again; a tree has 2.2 squared distances on average, far from the
// densest that darts reach (about 1.45)
std::vector<TreePlace> asPoissonDisc(std::size_t count, double distance, LayoutDraws& draws) {
  const double side = distance * std::sqrt(2.2 * static_cast<double>(count));
  const double cell = distance / std::numbers::sqrt2;
  std::unordered_map<std::int64_t, std::size_t> cells;  // one place at most in each
  const auto key = [](std::int64_t i, std::int64_t j) { return i * 2'000'003 + j; };
  std::vector<TreePlace> places;
  while (places.size() < count) {
    const TreePlace dart = somewhere(side, draws);
    const auto i = static_cast<std::int64_t>(std::floor(dart.position.x / cell));
    const auto j = static_cast<std::int64_t>(std::floor(dart.position.z / cell));
    bool isFree = true;
    for (std::int64_t di = -2; di <= 2 && isFree; ++di) {
      for (std::int64_t dj = -2; dj <= 2 && isFree; ++dj) {
        const auto found = cells.find(key(i + di, j + dj));
        isFree = found == cells.end() || core::hypot(places[found->second].position.x - dart.position.x,
                                                     places[found->second].position.z - dart.position.z) >= distance;
      }
    }
    if (isFree) {
      cells[key(i, j)] = places.size();
      places.push_back(dart);
    }
  }
  return places;
}

struct Seedling {
  TreePlace place;
  double growth = 1.0;
  double radius = 0.0;
};

// the seedlings that touch and are dominated by a larger seedling
std::vector<bool> dominated(turtle::EnvironmentProcess& ecosystem, const std::vector<Seedling>& seedlings,
                            std::uint64_t step) {
  turtle::QueryBatch queries;
  queries.step = step;
  queries.parameterOffset.push_back(0);
  for (std::size_t i = 0; i < seedlings.size(); ++i) {
    queries.plant.push_back(static_cast<std::uint32_t>(i));
    queries.module.push_back(0);
    queries.symbol.push_back(0);
    queries.isTransient.push_back(0);
    queries.position.push_back(seedlings[i].place.position);
    queries.parameters.push_back(seedlings[i].radius);
    queries.parameterOffset.push_back(queries.parameters.size());
  }
  turtle::ReplyBatch replies;
  replies.prepare(queries);
  const auto failure = ecosystem.step(queries, replies);
  ESPALIER_CHECK(!failure);
  std::vector<bool> result;
  for (std::size_t i = 0; i < seedlings.size(); ++i) {
    result.push_back(replies.isSet[i] != 0 && replies.values[i] == 0.0);
  }
  return result;
}

// four seedlings for each tree grow until as many are left as trees are wanted
std::vector<TreePlace> byCompetition(std::size_t count, double distance, LayoutDraws& draws) {
  auto made = environment::makeProcess("ecosystem", "");
  ESPALIER_CHECK(made.has_value());
  turtle::EnvironmentProcess& ecosystem = **made;
  turtle::EnvironmentContext context;
  context.simulation = "forest";
  context.symbols = {"E"};
  const auto failure = ecosystem.open(context);
  ESPALIER_CHECK(!failure);

  const double side = distance * std::sqrt(static_cast<double>(count));
  std::vector<Seedling> alive;
  for (std::size_t i = 0; i < 4 * count; ++i) {
    const TreePlace place = somewhere(side, draws);
    alive.push_back({place, 0.7 + 0.6 * draws.uniform(), 0.0});
  }
  for (std::uint64_t step = 0; alive.size() > count; ++step) {
    for (Seedling& seedling : alive) {
      seedling.radius += 0.02 * distance * seedling.growth;
    }
    const std::vector<bool> dies = dominated(ecosystem, alive, step);
    std::vector<Seedling> next;
    std::vector<Seedling> dead;
    for (std::size_t i = 0; i < alive.size(); ++i) {
      (dies[i] ? dead : next).push_back(alive[i]);
    }
    // too many at once: the largest of them live on
    std::stable_sort(dead.begin(), dead.end(),
                     [](const Seedling& a, const Seedling& b) { return a.radius > b.radius; });
    for (std::size_t i = 0; next.size() < count; ++i) {
      next.push_back(dead[i]);
    }
    alive = std::move(next);
  }
  double largest = 0.0;
  for (const Seedling& seedling : alive) {
    largest = std::max(largest, seedling.radius);
  }
  std::vector<TreePlace> places;
  for (const Seedling& seedling : alive) {
    places.push_back(seedling.place);
    places.back().size = largest > 0.0 ? seedling.radius / largest : 1.0;
  }
  return places;
}

}  // namespace

std::vector<TreePlace> layoutForest(Spacing spacing, std::size_t count, double distance, std::uint64_t seed) {
  LayoutDraws draws(seed);
  switch (spacing) {
    case Spacing::Grid:
      return onGrid(count, distance, 0.0, draws);
    case Spacing::Jittered:
      return onGrid(count, distance, kJitter, draws);
    case Spacing::Poisson:
      return asPoissonDisc(count, distance, draws);
    case Spacing::Competition:
      return byCompetition(count, distance, draws);
  }
  return {};
}

}  // namespace espalier::command
