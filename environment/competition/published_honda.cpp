// The process `honda` as the published program honda81: positions, radius and vigors are 32-bit floats, and the
// distance is compared in them. So a tip whose distance is the radius in decimals is within it or not, as there.

#include <memory>
#include <vector>

#include "environment/base/replies.h"
#include "environment/competition/published_variants.h"
#include "environment/competition/tip_collisions.h"
#include "environment/geometry/float_vec.h"

namespace espalier::environment {

namespace {

class PublishedHonda final : public turtle::EnvironmentProcess {
 public:
  PublishedHonda(double radius, Plane plane) : radius_(toFloat(radius)), plane_(plane) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override { return describeHonda(); }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext&) override {
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<Tip> tips;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const Tip tip = tipOf(queries, query, plane_);
      tips.push_back({toDouble(toFloat(tip.position)), toFloat(tip.vigor), toFloat(tip.group)});
    }
    const auto isNear = [&](const Tip& a, const Tip& b) {
      const FloatVec offset = toFloat(b.position) - toFloat(a.position);
      return dot(offset, offset) <= radius_ * radius_;
    };
    TipCollisions(tips, radius_, plane_).settle(isNear, [&](std::size_t tip, bool isBlocked) {
      if (!queries.parametersOf(tip).empty()) {
        replies.set(queries, tip, 0, isBlocked ? 0.0 : 1.0);
      }
    });
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  float radius_;
  Plane plane_;
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makePublishedHonda(double radius, Plane plane) {
  return std::make_unique<PublishedHonda>(radius, plane);
}

}  // namespace espalier::environment
