#include "environment/light/rays/ray_caster.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <new>
#include <random>
#include <vector>

#include "engine/core/work_meter.h"

namespace espalier::environment::ray_caster_test {
namespace {

using core::Vec3;

/// A mesh of unit squares with bumps, each of two triangles: rays to its vertices and edges are decided by last bits.
struct Mesh {
  std::vector<Vec3> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  explicit Mesh(std::uint32_t width) {
    std::mt19937 random(3);
    for (std::uint32_t z = 0; z < width; ++z) {
      for (std::uint32_t x = 0; x < width; ++x) {
        vertices.push_back({0.1 * x, 0.05 * static_cast<double>(random() % 8), 0.1 * z});
      }
    }
    for (std::uint32_t z = 0; z + 1 < width; ++z) {
      for (std::uint32_t x = 0; x + 1 < width; ++x) {
        const std::uint32_t corner = z * width + x;
        triangles.push_back({corner, corner + 1, corner + width});
        triangles.push_back({corner + 1, corner + width + 1, corner + width});
      }
    }
  }
};

/// Rays from above, every other one to a vertex or to the middle of an edge. Returns the hits as numbers.
std::vector<std::uint32_t> hitsOf(const Mesh& mesh, const std::string& instructions, bool isRepeated) {
  std::optional<RayCaster::Repetition> repetition;
  if (isRepeated) {
    repetition = RayCaster::Repetition{{0, 2}, {0, 0}, {5.9, 5.9}};
  }
  const RayCaster caster(mesh.vertices, mesh.triangles, repetition, {}, 1, instructions);
  std::mt19937 random(9);
  const auto uniform = [&] { return static_cast<double>(random() >> 5U) * 0x1p-27; };
  std::vector<std::uint32_t> hits;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3 origin{6.0 * uniform(), 1.0 + uniform(), 6.0 * uniform()};
    const auto& corners = mesh.triangles[random() % mesh.triangles.size()];
    const Vec3 aim = i % 4 == 0   ? mesh.vertices[corners[0]]
                     : i % 4 == 1 ? 0.5 * (mesh.vertices[corners[0]] + mesh.vertices[corners[2]])
                                  : Vec3{6.0 * uniform(), 0.0, 6.0 * uniform()};
    const Vec3 direction = core::normalised(aim - origin);
    const RayCaster::Hit hit = caster.firstHit(origin, direction, caster.margin());
    hits.push_back(hit.triangle == RayCaster::kMiss ? hit.triangle : 2 * hit.triangle + (hit.isFront ? 1 : 0));
    hits.push_back(caster.isFree(origin, direction, caster.margin()) ? 1 : 0);
  }
  return hits;
}

TEST(RayCaster, HitsDoNotDependOnVectorInstructions) {
  const Mesh mesh(60);
  for (const bool isRepeated : {false, true}) {
    const std::vector<std::uint32_t> hits = hitsOf(mesh, "avx", isRepeated);
    EXPECT_EQ(hits, hitsOf(mesh, "sse4.2", isRepeated));
    EXPECT_EQ(hits, hitsOf(mesh, "sse2", isRepeated));
  }
}

/// Counts, and refuses what goes beyond a bound.
class CountingMeter final : public core::WorkMeter {
 public:
  explicit CountingMeter(std::int64_t bound) : bound_(bound) {}
  [[nodiscard]] bool take(std::int64_t bytes) noexcept override {
    if ((held_ += bytes) > bound_ && bytes > 0) {
      held_ -= bytes;
      return false;
    }
    return true;
  }
  [[nodiscard]] bool isStopped() const noexcept override { return false; }
  [[nodiscard]] std::int64_t held() const { return held_; }

 private:
  const std::int64_t bound_;
  std::atomic<std::int64_t> held_{0};
};

TEST(RayCaster, TheMeterOfTheThreadCountsTheTreeAndMayRefuseIt) {
  const Mesh mesh(200);
  for (const unsigned threads : {1U, 2U}) {
    CountingMeter meter(INT64_MAX);
    {
      const core::WorkMeter::Scope scope(&meter);
      const RayCaster caster(mesh.vertices, mesh.triangles, {}, {}, threads);
      // a corner of a triangle takes four bytes, a place twelve
      EXPECT_GT(meter.held(), static_cast<std::int64_t>(12 * mesh.triangles.size() + 12 * mesh.vertices.size()));
    }
    EXPECT_EQ(meter.held(), 0);
    CountingMeter narrow(1'000'000);
    const core::WorkMeter::Scope scope(&narrow);
    EXPECT_THROW(RayCaster(mesh.vertices, mesh.triangles, {}, {}, threads), std::bad_alloc);
    EXPECT_EQ(narrow.held(), 0);
  }
}

TEST(RayCaster, ARayIsFreeIfItMeetsNothing) {
  const std::vector<std::uint32_t> hits = hitsOf(Mesh(60), "avx", false);
  for (std::size_t i = 0; i < hits.size(); i += 2) {
    EXPECT_EQ(hits[i] == RayCaster::kMiss, hits[i + 1] == 1) << "ray " << i / 2;
  }
}

TEST(RayCaster, OfTheTrianglesAtAVertexTheFirstIsMet) {
  // six triangles around the origin, met from above in the middle
  std::vector<Vec3> vertices{{0, 0, 0}};
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (std::uint32_t i = 0; i < 6; ++i) {
    const double angle = 3.14159265358979323846 / 3.0 * i;
    vertices.push_back({std::cos(angle), 0, std::sin(angle)});
    triangles.push_back({0, 1 + i, 1 + (i + 1) % 6});
  }
  const RayCaster caster(vertices, triangles, std::nullopt, {}, 1);
  EXPECT_EQ(caster.firstHit({0, 1, 0}, {0, -1, 0}, caster.margin()).triangle, 0U);
}

}  // namespace
}  // namespace espalier::environment::ray_caster_test
