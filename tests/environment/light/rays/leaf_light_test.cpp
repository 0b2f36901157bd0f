#include "environment/light/rays/leaf_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace espalier::environment::leaf_light_test {
namespace {

using std::numbers::pi;

void addTriangle(LightSurfaces& surfaces, const core::Vec3& a, const core::Vec3& b, const core::Vec3& c) {
  const auto base = static_cast<std::uint32_t>(surfaces.vertices.size());
  surfaces.vertices.insert(surfaces.vertices.end(), {a, b, c});
  surfaces.triangles.push_back({base, base + 1, base + 2});
  surfaces.material.push_back(0);
}

std::vector<double> skyOf(const LeafLight& light, double radiance) {
  return std::vector<double>(light.directions().all().size(), radiance);
}

/// A cube of side 2 around the origin; the front sides look in.
LightSurfaces closedBox() {
  LightSurfaces box;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const auto corner = [&](double u, double v) {
        std::array<double, 3> p{};
        p[static_cast<std::size_t>(axis)] = side;
        p[static_cast<std::size_t>((axis + 1) % 3)] = side > 0 ? v : u;
        p[static_cast<std::size_t>((axis + 2) % 3)] = side > 0 ? u : v;
        return core::Vec3{p[0], p[1], p[2]};
      };
      addTriangle(box, corner(-1, -1), corner(1, -1), corner(1, 1));
      addTriangle(box, corner(-1, -1), corner(1, 1), corner(-1, 1));
    }
  }
  return box;
}

TEST(LeafLight, AClosedBoxKeepsItsEnergy) {
  // furnace test: walls that emit M and reflect ρ see everywhere the same, so after n bounces the irradiance is
  // M (1 + ρ + … + ρⁿ) on every side, and nothing of the sky outside comes in
  const LightSurfaces box = closedBox();
  const LeafLight light(box, {}, {}, {.directions = 256});
  const std::vector<double> sky = skyOf(light, 1000.0);
  std::vector<double> emitted(2 * box.triangles.size(), 0.0);
  for (std::size_t triangle = 0; triangle < box.triangles.size(); ++triangle) {
    emitted[2 * triangle] = 7.0;
  }
  double expected = 0.0;
  for (int bounces = 0; bounces < 6; ++bounces) {
    expected += 7.0 * std::pow(0.8, bounces);
    const auto found = light.irradiances(0, sky, {{0.8, 0.0}}, emitted, bounces);
    for (std::size_t triangle = 0; triangle < box.triangles.size(); ++triangle) {
      EXPECT_NEAR(found[2 * triangle] / expected, 1.0, 1e-12);
    }
  }
}

TEST(LeafLight, AWhiteBoxConservesWhatIsScattered) {
  // walls that absorb nothing: every bounce carries the whole light on
  const LightSurfaces box = closedBox();
  const LeafLight light(box, {}, {}, {.directions = 100});
  const std::vector<double> emitted(2 * box.triangles.size(), 1.0);
  const auto found = light.irradiances(0, skyOf(light, 0.0), {{1.0, 0.0}}, emitted, 9);
  for (std::size_t triangle = 0; triangle < box.triangles.size(); ++triangle) {
    EXPECT_NEAR(found[2 * triangle], 10.0, 1e-11);
  }
}

TEST(LeafLight, ALeafAloneUnderAUniformSkyGetsPiTimesItsRadiance) {
  LightSurfaces leaf;
  addTriangle(leaf, {0, 0, 0}, {1, 0.3, 0}, {0.2, 0.5, 1});
  const LeafLight light(leaf, {}, {}, {.directions = 64});
  const auto found = light.irradiances(0, skyOf(light, 3.0), {{0, 0}}, {}, 2);
  EXPECT_NEAR(found[0], 3 * pi, 1e-12);
  EXPECT_NEAR(found[1], 3 * pi, 1e-12);
}

TEST(LeafLight, TheSunShinesByTheCosineOnTheSideThatFacesIt) {
  LightSurfaces leaves;
  addTriangle(leaves, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});
  addTriangle(leaves, {-9, -1, -9}, {-9, -1, 20}, {20, -1, -9});
  const core::Vec3 towards{0.6, 0.8, 0};
  const LeafLight light(leaves, {}, {{towards, {500}}}, {.directions = 32});
  const auto found = light.irradiances(0, skyOf(light, 0.0), {{0.1, 0}}, {}, 0);
  EXPECT_NEAR(found[0], 400, 1e-12);
  EXPECT_EQ(found[1], 0.0);
}

void addDisc(LightSurfaces& surfaces, double height, double radius, bool looksUp) {
  constexpr int kSides = 256;
  for (int k = 0; k < kSides; ++k) {
    const auto rim = [&](int i) {
      const double angle = 2 * pi * i / kSides;
      return core::Vec3{radius * std::cos(angle), height, radius * std::sin(angle)};
    };
    if (looksUp) {
      addTriangle(surfaces, {0, height, 0}, rim(k + 1), rim(k));
    } else {
      addTriangle(surfaces, {0, height, 0}, rim(k), rim(k + 1));
    }
  }
}

TEST(LeafLight, ParallelDiscsSeeEachOtherByTheirFormFactor) {
  // coaxial discs of the radii r1, r2 at the distance h: F12 = ½ (X − √(X² − 4 (r2/r1)²)), X = 1 + (h² + r2²)/r1²
  // (Howell, catalogue of configuration factors, C-41). What the lower one emits arrives on the upper one with F21
  for (const auto& [r1, r2, h] : {std::array{1.0, 1.0, 1.0}, std::array{1.0, 0.5, 0.7}, std::array{0.5, 1.0, 1.5}}) {
    LightSurfaces discs;
    addDisc(discs, 0, r1, true);
    addDisc(discs, h, r2, false);
    const LeafLight light(discs, {}, {}, {.directions = 2000});
    std::vector<double> emitted(2 * discs.triangles.size(), 0.0);
    for (std::size_t triangle = 0; triangle < 256; ++triangle) {
      emitted[2 * triangle] = 1.0;
    }
    const auto found = light.irradiances(0, skyOf(light, 0.0), {{0, 0}}, emitted, 0);
    double mean = 0;
    double area = 0;
    for (std::size_t triangle = 256; triangle < 512; ++triangle) {
      mean += found[2 * triangle] * light.areaOf(triangle);
      area += light.areaOf(triangle);
    }
    // F21 with the roles changed
    const double x = 1 + (h * h + r1 * r1) / (r2 * r2);
    const double expected = 0.5 * (x - std::sqrt(x * x - 4 * r1 * r1 / (r2 * r2)));
    EXPECT_NEAR(mean / area / expected, 1.0, 0.01) << r1 << " " << r2 << " " << h;
  }
}

/// Small leaves with normals in all directions evenly, at random in a plot of 1 by 1 that repeats itself, up to
/// height 1.
LightSurfaces canopy(double leafArea, int count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> place(0.0, 1.0);
  std::normal_distribution<double> component;
  const double side = std::sqrt(2 * leafArea / count);
  LightSurfaces surfaces;
  for (int i = 0; i < count; ++i) {
    const core::Vec3 u = core::normalised({component(random), component(random), component(random)});
    const core::Vec3 w = core::normalised({component(random), component(random), component(random)});
    const core::Vec3 v = core::normalised(w - u * core::dot(u, w));
    const core::Vec3 at{place(random), place(random), place(random)};
    addTriangle(surfaces, at, at + u * side, at + v * side);
  }
  return surfaces;
}

TEST(LeafLight, AStandThatRepeatsItselfFollowsTheLawOfBeerAndLambert) {
  // random leaves are a turbid medium: of n = 20000 leaves with the index L = 2 the sun at the zenith angle θ, cos θ =
  // 0.8, lights a part ∫₀ᴸ e^(−kl) dl/L = (1 − e^(−kL))/(kL) with k = ½/0.8. Each leaf is lit or not: standard
  // deviation √(p(1−p)/n), here 0.0035, but leaves share their shade, so about 2 times that; the bound is 5 times the
  // first
  const LightSurfaces leaves = canopy(2, 20000, 1);
  LeafLight::Options options{.directions = 8, .keepsHits = false};
  options.repetition = RayCaster::Repetition{{0, 2}, {0, 0}, {1, 1}};
  const LeafLight light(leaves, {}, {{{0.48, 0.8, 0.36}, {1}}}, options);
  const auto found = light.irradiances(0, skyOf(light, 0.0), {{0, 0}}, {}, 0);
  double lit = 0;
  for (std::size_t triangle = 0; triangle < 20000; ++triangle) {
    lit += found[2 * triangle] + found[2 * triangle + 1] > 0 ? 1.0 : 0.0;
  }
  const double k = 0.5 / 0.8;
  EXPECT_NEAR(lit / 20000, (1 - std::exp(-k * 2)) / (k * 2), 5 * 0.0035);
}

TEST(LeafLight, TheLightIsTheSameForAnyNumberOfThreadsAndForTheTrianglesThatAreWanted) {
  const LightSurfaces leaves = canopy(3, 1000, 2);
  const std::vector<double> sky(RayDirections(64).all().size(), 1.0);
  const auto one =
      LeafLight(leaves, {}, {{{0, 1, 0}, {4}}}, {.directions = 64}).irradiances(0, sky, {{0.3, 0.2}}, {}, 3);
  const auto four = LeafLight(leaves, {}, {{{0, 1, 0}, {4}}}, {.directions = 64, .threads = 4})
                        .irradiances(0, sky, {{0.3, 0.2}}, {}, 3);
  EXPECT_EQ(one, four);
  const auto direct =
      LeafLight(leaves, {}, {{{0, 1, 0}, {4}}}, {.directions = 64}).irradiances(0, sky, {{0.3, 0.2}}, {}, 0);
  const auto some = LeafLight(leaves, {5, 70, 999}, {{{0, 1, 0}, {4}}}, {.directions = 64, .keepsHits = false})
                        .irradiances(0, sky, {{0.3, 0.2}}, {}, 0);
  for (const std::size_t triangle : {5U, 70U, 999U}) {
    EXPECT_EQ(some[2 * triangle], direct[2 * triangle]);
    EXPECT_EQ(some[2 * triangle + 1], direct[2 * triangle + 1]);
  }
}

TEST(LeafLight, BouncesBringLightIntoTheShade) {
  // a leaf right below a wide one that lets half of the light through
  LightSurfaces leaves;
  addTriangle(leaves, {-1000, 0.1, -1000}, {-1000, 0.1, 2000}, {2000, 0.1, -1000});
  addTriangle(leaves, {0, 0, 0}, {0, 0, 0.1}, {0.1, 0, 0});
  const LeafLight light(leaves, {}, {}, {.directions = 500});
  std::vector<double> sky = skyOf(light, 0.0);
  for (std::size_t i = 0; i < sky.size(); ++i) {
    sky[i] = light.directions().all()[i].y > 0 ? 1 / pi : 0.0;
  }
  EXPECT_NEAR(light.irradiances(0, sky, {{0, 0.5}}, {}, 0)[2], 0.0, 1e-12);
  EXPECT_NEAR(light.irradiances(0, sky, {{0, 0.5}}, {}, 1)[2], 0.5, 0.01);
}

TEST(LeafLight, TrianglesOfOneLeafWithFewRaysEachSeeTogetherWhatOneSeesWithMany) {
  // a leaf of 16 triangles below a shade that hides part of the sky: 16 rays from each, all in other directions,
  // against one triangle with 4096
  LightSurfaces one;
  addTriangle(one, {-100, 1, 0.3}, {-100, 1, 100}, {100, 1, 0.3});
  LightSurfaces many = one;
  addTriangle(one, {0, 0, 0}, {0, 0, 0.4}, {0.4, 0, 0});
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4 - i; ++k) {
      const core::Vec3 corner{0.1 * i, 0, 0.1 * k};
      addTriangle(many, corner, corner + core::Vec3{0, 0, 0.1}, corner + core::Vec3{0.1, 0, 0});
      if (k < 3 - i) {
        addTriangle(many, corner + core::Vec3{0.1, 0, 0}, corner + core::Vec3{0, 0, 0.1},
                    corner + core::Vec3{0.1, 0, 0.1});
      }
    }
  }
  many.seed = {0};
  many.thinning = {0};
  for (std::uint32_t i = 0; i < 16; ++i) {
    many.seed.push_back(40 + i);
    many.thinning.push_back(4);
  }
  const LeafLight coarse(one, {}, {}, {.directions = 4096});
  const LeafLight fine(many, {}, {}, {.directions = 256});
  const double expected = coarse.irradiances(0, skyOf(coarse, 1.0), {{0, 0}}, {}, 0)[2];
  const auto found = fine.irradiances(0, skyOf(fine, 1.0), {{0, 0}}, {}, 0);
  double mean = 0.0;
  for (std::size_t triangle = 1; triangle < 17; ++triangle) {
    mean += found[2 * triangle] / 16;
  }
  EXPECT_GT(expected, 0.2);
  EXPECT_LT(expected, 0.8 * pi);
  // 256 rays of which half are on this side: a count of 128 with a share near a half has a deviation of 9 %, a spread
  // lattice much less
  EXPECT_NEAR(mean / expected, 1.0, 0.05);
}

/// The next of a sequence of scenes: leaves that come, go and move, some lying in each other.
LightSurfaces nextScene(const LightSurfaces& before, std::mt19937_64& random) {
  std::uniform_real_distribution<double> chance(0.0, 1.0);
  LightSurfaces next;
  const LightSurfaces more = canopy(0.2, 10, static_cast<unsigned>(random()));
  const auto addOf = [&](const LightSurfaces& from, std::size_t triangle, double lift, std::uint32_t seed) {
    const auto& corners = from.triangles[triangle];
    const core::Vec3 up{0, lift, 0};
    addTriangle(next, from.vertices[corners[0]] + up, from.vertices[corners[1]] + up, from.vertices[corners[2]] + up);
    next.seed.push_back(seed);
    next.thinning.push_back(static_cast<std::uint8_t>(seed % 3));
  };
  for (std::size_t i = 0; i < before.triangles.size(); ++i) {
    const double what = chance(random);
    if (what < 0.01) {
      continue;
    }
    addOf(before, i, what < 0.02 ? 0.001 : 0.0, before.seedOf(static_cast<std::uint32_t>(i)));
    if (what > 0.98) {
      // the same place twice
      addOf(before, i, 0.0, static_cast<std::uint32_t>(random() % 1000));
    } else if (what > 0.97) {
      addOf(more, random() % 10, 0.0, static_cast<std::uint32_t>(random() % 1000));
    }
  }
  return next;
}

TEST(LeafLight, ASceneThatFollowsAnotherHasTheLightOfANewOneBitByBit) {
  for (const bool repeats : {false, true}) {
    for (const int bounces : {0, 2}) {
      LeafLight::Options options{.directions = 64, .keepsHits = bounces > 0, .threads = 2};
      if (repeats) {
        options.repetition = RayCaster::Repetition{{0, 2}, {0, 0}, {1, 1}};
      }
      std::mt19937_64 random(7);
      LeafLight following(options);
      LightSurfaces scene = canopy(2, 500, 3);
      std::uint64_t kept = 0;
      for (int step = 0; step < 8; ++step) {
        scene = step == 3 ? scene : nextScene(scene, random);
        // the sun of one direction stands still, the other moves
        const std::vector<LeafLight::Sun> suns{{{0.48, 0.8, 0.36}, {100}},
                                               {core::normalised({0.1 * step, 1, 0}), {50}}};
        std::vector<std::uint32_t> wanted;
        for (std::uint32_t i = 0; bounces == 0 && i < scene.triangles.size(); i += i % 5 == 0 ? 1 : 2) {
          wanted.push_back(i);
        }
        following.setScene(scene, wanted, suns);
        const LeafLight fresh(scene, wanted, suns, options);
        EXPECT_EQ(fresh.keptCount(), 0U);
        const std::vector<double> sky = skyOf(fresh, 1.0);
        EXPECT_EQ(following.irradiances(0, sky, {{0.3, 0.2}}, {}, bounces),
                  fresh.irradiances(0, sky, {{0.3, 0.2}}, {}, bounces))
            << "step " << step << " bounces " << bounces << " repeats " << repeats;
        EXPECT_EQ(following.rayCount(), fresh.rayCount());
        kept += following.keptCount();
        if (step == 3) {
          // nothing changed but one sun
          EXPECT_GE(following.keptCount() + fresh.rayCount() / 20, fresh.rayCount());
        }
      }
      EXPECT_GT(kept, following.rayCount()) << "of eight scenes";
    }
  }
}

TEST(LeafLight, ASceneFarAwayThatFollowsAnotherSettlesAsANewOneBitByBit) {
  LeafLight::Options options{.directions = 64, .settles = true, .threads = 2};
  std::mt19937_64 random(7);
  LeafLight following(options);
  LightSurfaces scene = canopy(2, 200, 3);
  for (core::Vec3& vertex : scene.vertices) {
    vertex = vertex + core::Vec3{500'000, 0, -5'300'000};
  }
  std::uint64_t kept = 0;
  for (int step = 0; step < 4; ++step) {
    scene = step == 0 ? scene : nextScene(scene, random);
    const std::vector<LeafLight::Sun> suns{{{0.48, 0.8, 0.36}, {100}}};
    following.setScene(scene, {}, suns);
    const LeafLight fresh(scene, {}, suns, options);
    const std::vector<double> sky = skyOf(fresh, 1.0);
    const auto one = following.settle(0, sky, {{0.5, 0.3}}, 1e-3, {0, 1, 0}, std::nullopt);
    const auto other = fresh.settle(0, sky, {{0.5, 0.3}}, 1e-3, {0, 1, 0}, std::nullopt);
    EXPECT_EQ(one.gathered, other.gathered) << step;
    EXPECT_EQ(one.irradiances, other.irradiances) << step;
    kept += following.keptCount();
  }
  EXPECT_GT(kept, following.rayCount());
}

TEST(LeafLight, ALeafShadesAnotherWhereverTheyAreAndWhateverIsFarAway) {
  // two leaves 1 cm apart, and a third one that is far from both
  for (const double x : {0.0, 1'000.0, 500'000.0}) {
    for (const double away : {10.0, 10'000.0, 1e6}) {
      if (x > 0.0 && away > 10.0) {
        continue;
      }
      LightSurfaces leaves;
      for (const double height : {1.0, 1.01}) {
        addTriangle(leaves, {x, height, 0}, {x, height, 1}, {x + 1, height, 0});
      }
      addTriangle(leaves, {x + away, 1, 0}, {x + away, 1, 1}, {x + away + 1, 1, 0});
      const LeafLight light(leaves, {}, {{{0, 1, 0}, {100}}}, {.directions = 16});
      const auto found = light.irradiances(0, skyOf(light, 0.0), {{0, 0}}, {}, 0);
      EXPECT_EQ(found[0] + found[1], 0.0) << x << " " << away;
      EXPECT_NEAR(found[2] + found[3], 100.0, 1e-9) << x << " " << away;
      EXPECT_NEAR(found[4] + found[5], 100.0, 1e-9) << x << " " << away;
    }
  }
}

TEST(LeafLight, OfTrianglesThatLieInEachOtherTheFirstIsMet) {
  // whatever else there is: the tree over the triangles is another one with every number of leaves around
  for (const int others : {0, 3, 50, 400}) {
    LightSurfaces leaves = canopy(0.01, std::max(others, 1), 5);
    for (core::Vec3& vertex : leaves.vertices) {
      vertex = vertex + core::Vec3{3, 0, 3};
    }
    for (int k = 0; k < 5; ++k) {
      addTriangle(leaves, {0, 1, 0}, {0, 1, 1}, {1, 1, 0});
    }
    const RayCaster caster(leaves.vertices, leaves.triangles, std::nullopt, {}, 1);
    const RayCaster::Hit below = caster.firstHit({0.2, 0, 0.2}, {0, 1, 0}, caster.margin());
    const RayCaster::Hit above = caster.firstHit({0.2, 2, 0.2}, {0, -1, 0}, caster.margin());
    EXPECT_EQ(below.triangle, leaves.triangles.size() - 5);
    EXPECT_FALSE(below.isFront);
    EXPECT_EQ(above.triangle, leaves.triangles.size() - 5);
    EXPECT_TRUE(above.isFront);
  }
}

}  // namespace
}  // namespace espalier::environment::leaf_light_test
