// The process `takenaka` as the published program: its voxel traversal (published_voxels.h) and its light, which is ten
// times that of its own units, in 32-bit floats. y is up. O(n · sources · voxels on a ray, and the balls entered in
// them).

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "engine/core/work_meter.h"
#include "environment/base/replies.h"
#include "environment/geometry/grid_keys.h"
#include "environment/light/published_variants.h"
#include "environment/light/published_voxels.h"

namespace espalier::environment {

namespace {

constexpr float kLight = 8.64F;  // on a unit of area

struct PlacedSource {
  FloatVec place;
  float weight = 0.0F;
};

/// Parallel light from above on a disc around the axis x = z = 0.
struct DiskSource {
  float radius = 0.0F;
  float height = 0.0F;
};

class PublishedTakenaka final : public turtle::EnvironmentProcess {
 public:
  explicit PublishedTakenaka(const Configuration& configuration)
      : s_(toFloat(configuration.number("parameterS"))),
        efficiency_(toFloat(configuration.number("efficiency"))),
        beamRadius_(toFloat(configuration.number("beamRadius"))),
        cells_(cellsOf(configuration)) {
    const float gap = 1.0F - (1.0F - toFloat(configuration.number("transmittance"))) / (s_ * s_);
    passing_ = gap * gap;
    float sum = 0.0F;
    for (const auto& row : configuration.rows("sources")) {
      sources_.push_back({toFloat({row[0], row[1], row[2]}), toFloat(row[3])});
      sum += sources_.back().weight;
    }
    for (PlacedSource& source : sources_) {
      source.weight /= sum;
    }
    if (const std::vector<double>& disk = configuration.numbers("diskSource"); !disk.empty()) {
      disk_ = DiskSource{toFloat(disk[0]), toFloat(disk[2])};
    }
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return describeTakenaka(lengthUnit_); }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<FloatSphere> balls;
    std::vector<std::size_t> queryOf;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (parameters.size() > 1) {
        const double area = std::max(toFloat(parameters[0]), 0.0F);
        balls.push_back(
            {toFloat(queries.position[query]), s_ * 0.5F * static_cast<float>(std::sqrt(area / std::numbers::pi))});
        queryOf.push_back(query);
      }
    }
    PublishedVoxels voxels(balls, cells_, 1.0F);
    if (auto error = voxels.tooManyEntries()) {
      return error;
    }
    for (std::size_t ball = 0; ball < balls.size(); ++ball) {
      const auto parameters = queries.parametersOf(queryOf[ball]);
      const float area = toFloat(parameters[0]);
      const float taken = efficiency_ * area / 4.0F * s_ * s_ * (1.0F - passing_);
      replies.set(queries, queryOf[ball], 0, area);
      replies.set(queries, queryOf[ball], 1,
                  taken * arrivingLight(balls, ball, voxels) * kLight - toFloat(parameters[1]));
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  /// The part of all light that reaches a ball.
  [[nodiscard]] float arrivingLight(std::span<const FloatSphere> balls, std::size_t own,
                                    PublishedVoxels& voxels) const {
    const FloatVec& place = balls[own].centre;
    if (disk_) {
      const bool isLit =
          place.y <= disk_->height && place.x * place.x + place.z * place.z <= disk_->radius * disk_->radius;
      return isLit ? lightAlong({0.0F, 1.0F, 0.0F}, balls, own, voxels) : 0.0F;
    }
    float arriving = 0.0F;
    for (const PlacedSource& source : sources_) {
      arriving += source.weight * lightAlong(normalised(source.place - place), balls, own, voxels);
    }
    return arriving;
  }

  [[nodiscard]] float lightAlong(const FloatVec& direction, std::span<const FloatSphere> balls, std::size_t own,
                                 PublishedVoxels& voxels) const {
    core::pollWork();
    float left = 1.0F;
    voxels.visitRay(own, direction,
                    [&](std::uint32_t other) { left *= isMet(balls[own], balls[other], direction) ? passing_ : 1.0F; });
    return left;
  }

  /// Whether a ray from one ball meets another ahead of it, however far away.
  [[nodiscard]] bool isMet(const FloatSphere& own, const FloatSphere& other, const FloatVec& direction) const {
    const FloatVec between = own.centre - other.centre;
    const float radius = other.radius + beamRadius_ * own.radius;
    const float a = dot(direction, between);
    const float squared = a * a - (dot(between, between) - radius * radius);
    return squared >= 0.0F && static_cast<float>(std::sqrt(static_cast<double>(squared))) - a > 0.0F;
  }

  float s_;
  float efficiency_;
  float beamRadius_;
  float passing_ = 0.0F;  // part of the light that a ball lets pass
  std::array<std::size_t, 3> cells_;
  std::vector<PlacedSource> sources_;
  std::optional<DiskSource> disk_;
  std::string lengthUnit_ = "m";
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makePublishedTakenaka(const Configuration& configuration) {
  return std::make_unique<PublishedTakenaka>(configuration);
}

}  // namespace espalier::environment
