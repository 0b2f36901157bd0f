// The process `chiba` as the published program: its voxel traversal (published_voxels.h), its sky and its areas, all in
// 32-bit floats, operation by operation. y is up. O(n · directions · voxels on a ray, and the spheres entered in them).

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/work_meter.h"
#include "environment/base/replies.h"
#include "environment/geometry/grid_keys.h"
#include "environment/light/published_variants.h"
#include "environment/light/published_voxels.h"

namespace espalier::environment {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;

// functions of the mathematics library run in double precision, and their result is rounded
float sqrtOf(float x) {
  return static_cast<float>(std::sqrt(static_cast<double>(x)));
}
float acosOf(float x) {
  return static_cast<float>(std::acos(static_cast<double>(x)));
}

struct FloatLight {
  FloatVec direction;  // a unit vector towards the light
  float weight = 0.0F;
};

std::vector<FloatLight> sourcesOf(const ConfigurationRows& rows) {
  std::vector<FloatLight> lights;
  float sum = 0.0F;
  for (const std::vector<double>& row : rows) {
    lights.push_back({normalised(toFloat({row[0], row[1], row[2]})), toFloat(row[3])});
    sum += lights.back().weight;
  }
  for (FloatLight& light : lights) {
    light.weight /= sum;
  }
  return lights;
}

/// The share of each direction: a uniform sky whose lower half has `ratio` of the upper half's light.
void weighUniformly(std::vector<FloatLight>& lights, float ratio) {
  const auto upper = std::count_if(lights.begin(), lights.end(), [](const auto& l) { return l.direction.y >= 0.0F; });
  const auto lower = static_cast<float>(static_cast<std::ptrdiff_t>(lights.size()) - upper);
  for (FloatLight& light : lights) {
    light.weight = light.direction.y >= 0.0F ? 1.0F / (static_cast<float>(upper) * (1.0F + ratio))
                                             : ratio / (lower * (1.0F + ratio));
  }
}

/// The overcast sky of the published program: nothing from below, and z is left out of the cosine.
void weighOvercast(std::vector<FloatLight>& lights) {
  float sum = 0.0F;
  for (FloatLight& light : lights) {
    const auto [x, y, z] = light.direction;
    if (y > 0.0F) {
      const float cosine = y / sqrtOf(x * x + y * y);
      light.weight = (1.0F + cosine) / 3.0F * (8.6F * cosine + 0.123F) / 0.203F;
    }
    sum += light.weight;
  }
  for (FloatLight& light : lights) {
    light.weight /= sum;
  }
}

struct FloatTriangle {
  FloatVec a, b, c;
};

/// The middles of the triangles of an octahedron that is subdivided until there are `least`, as unit vectors. The order
/// of the octants and the division by 3 give the rounding errors of a recorded run.
std::vector<FloatLight> skyDirections(std::size_t least) {
  std::vector<FloatTriangle> triangles;
  for (const float z : {1.0F, -1.0F}) {
    for (const float y : {1.0F, -1.0F}) {
      for (const float x : {1.0F, -1.0F}) {
        triangles.push_back({{x, 0.0F, 0.0F}, {0.0F, y, 0.0F}, {0.0F, 0.0F, z}});
      }
    }
  }
  while (triangles.size() < least) {
    std::vector<FloatTriangle> finer;
    for (const auto& [a, b, c] : triangles) {
      const FloatVec ab = normalised(a + b);
      const FloatVec bc = normalised(b + c);
      const FloatVec ca = normalised(c + a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    triangles = std::move(finer);
  }
  std::vector<FloatLight> lights;
  for (const auto& [a, b, c] : triangles) {
    const FloatVec sum = a + b + c;
    lights.push_back({normalised({sum.x / 3.0F, sum.y / 3.0F, sum.z / 3.0F}), 0.0F});
  }
  return lights;
}

std::vector<FloatLight> skyOf(const Configuration& configuration) {
  std::vector<FloatLight> lights = skyDirections(static_cast<std::size_t>(configuration.integer("sampleCount")));
  if (configuration.flag("overcastSky")) {
    weighOvercast(lights);
  } else {
    weighUniformly(lights, toFloat(configuration.number("lowerToUpperRatio")));
  }
  return lights;
}

/// Area that two discs have in common whose middles are √`squared` apart; no number where rounding made a square
/// negative, as in the published program.
float publishedArea(float a, float b, float squared) {
  const float r1 = std::max(a, b);
  const float r2 = std::min(a, b);
  const float distance = sqrtOf(squared);
  if (distance + r2 <= r1) {
    return kPi * r2 * r2;
  }
  const float q = distance * distance;
  const float x1 = (r1 * r1 + q - r2 * r2) / (2.0F * distance);
  const float x2 = (r2 * r2 + q - r1 * r1) / (2.0F * distance);
  const float y = sqrtOf(r2 * r2 - x2 * x2);
  return r1 * r1 * acosOf(x1 / r1) + r2 * r2 * acosOf(x2 / r2) - y * distance;
}

class PublishedChiba final : public turtle::EnvironmentProcess {
 public:
  explicit PublishedChiba(const Configuration& configuration)
      : lights_(configuration.rows("sources").empty() ? skyOf(configuration)
                                                      : sourcesOf(configuration.rows("sources"))),
        transmittance_(toFloat(configuration.number("transmittance"))),
        radius_(toFloat(configuration.number("radius"))),
        beamRadius_(toFloat(configuration.number("beamRadius"))),
        estimatesArea_(configuration.flag("estimateIntersectionArea")),
        cells_(cellsOf(configuration)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return describeChiba(lengthUnit_); }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<FloatSphere> spheres;
    std::vector<std::size_t> queryOf;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (parameters.size() == 1 || parameters.size() > 3) {
        const float radius = toFloat(parameters[0]);
        spheres.push_back({toFloat(queries.position[query]), radius > 0.0F ? radius : radius_});
        queryOf.push_back(query);
      }
    }
    PublishedVoxels voxels(spheres, cells_, estimatesArea_ ? 1.0F : beamRadius_);
    if (auto error = voxels.tooManyEntries()) {
      return error;
    }
    for (std::size_t own = 0; own < spheres.size(); ++own) {
      answer(queries, queryOf[own], spheres, own, voxels, replies);
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  void answer(const turtle::QueryBatch& queries, std::size_t query, std::span<const FloatSphere> spheres,
              std::size_t own, PublishedVoxels& voxels, turtle::ReplyBatch& replies) const {
    float light = 0.0F;
    FloatVec brightest;
    for (const FloatLight& source : lights_) {
      core::pollWork();
      float left = 1.0F;
      voxels.visitRay(own, source.direction, [&](std::uint32_t other) {
        left *= estimatesArea_ ? passingByArea(spheres[own], spheres[other], source.direction)
                               : passingByChord(spheres[own], spheres[other], source.direction);
      });
      const float arriving = source.weight * left;
      light += arriving;
      brightest = brightest + source.direction * arriving;
    }
    const FloatVec unit = normalised(brightest);
    const std::array<float, 4> answers{light, unit.x, unit.y, unit.z};
    for (std::size_t k = 0; k < std::min<std::size_t>(queries.parametersOf(query).size(), 4); ++k) {
      replies.set(queries, query, k, answers[k]);
    }
  }

  /// The part of the light that another sphere lets pass along a ray.
  [[nodiscard]] float passingByChord(const FloatSphere& own, const FloatSphere& other,
                                     const FloatVec& direction) const {
    const FloatVec between = own.centre - other.centre;
    const float radius = other.radius + beamRadius_ * own.radius;
    const float a = dot(direction, between);
    const float squared = a * a - (dot(between, between) - radius * radius);
    if (!(squared > 0.0F)) {
      return 1.0F;
    }
    const float half = sqrtOf(squared);
    const float end = half - a;
    if (!(end > 0.0F)) {
      return 1.0F;
    }
    const float chord = -a - half > 0.0F ? 2.0F * half : end;
    return static_cast<float>(
        std::pow(static_cast<double>(transmittance_), static_cast<double>(chord / (2.0F * radius))));
  }

  [[nodiscard]] float passingByArea(const FloatSphere& own, const FloatSphere& other, const FloatVec& direction) const {
    const FloatVec between = own.centre - other.centre;
    const float a = dot(direction, between);
    if (a > 0.0F) {
      return 1.0F;
    }
    const float squared = dot(between, between) - a * a;
    const float sum = other.radius + own.radius;
    if (!(squared < sum * sum)) {
      return 1.0F;
    }
    const float area = publishedArea(own.radius, other.radius, squared);
    return std::isnan(area) ? 1.0F : 1.0F - (1.0F - transmittance_) * area / (kPi * own.radius * own.radius);
  }

  std::vector<FloatLight> lights_;
  float transmittance_;
  float radius_;
  float beamRadius_;
  bool estimatesArea_;
  std::array<std::size_t, 3> cells_;
  std::string lengthUnit_ = "m";
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makePublishedChiba(const Configuration& configuration) {
  return std::make_unique<PublishedChiba>(configuration);
}

}  // namespace espalier::environment
