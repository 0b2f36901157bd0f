// The process `ecosystem` as the published program: settled in string order, and everything is a 32-bit float, so a
// distance that is the sum of the radii in decimals is within it or not, as there.

#include <memory>
#include <string>
#include <vector>

#include "environment/base/replies.h"
#include "environment/competition/disc_contest.h"
#include "environment/competition/published_variants.h"
#include "environment/geometry/float_vec.h"

namespace espalier::environment {

namespace {

bool discsOverlapInFloats(const Disc& a, const Disc& b) {
  const FloatVec offset = toFloat(b.centre) - toFloat(a.centre);
  const float sum = toFloat(a.radius) + toFloat(b.radius);
  return sum >= 0.0F && dot(offset, offset) <= sum * sum;
}

class PublishedEcosystem final : public turtle::EnvironmentProcess {
 public:
  PublishedEcosystem(bool hasVigor, Plane plane) : rules_{hasVigor, true}, plane_(plane) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return describeEcosystem(lengthUnit_, rules_.hasVigor);
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<Contender> contenders;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const Contender one = contenderOf(queries, query, plane_);
      contenders.push_back({toDouble(toFloat(one.centre)), toFloat(one.radius), toFloat(one.second)});
    }
    answerContest(queries, dominatedOf(contenders, rules_, discsOverlapInFloats), replies);
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  ContestRules rules_;
  Plane plane_;
  std::string lengthUnit_ = "m";
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makePublishedEcosystem(bool hasVigor, Plane plane) {
  return std::make_unique<PublishedEcosystem>(hasVigor, plane);
}

}  // namespace espalier::environment
