// The process `density` (docs/environments.md): the tips of a plane pattern, its sources and its sinks make a density
// field.
//
// Tips act by the fast multipole method (tip_field.h), sources by a quadtree (kernel_tree.h). A step costs O(n log n)
// with an error below 1e-6 of the largest density. Up to 1024 queries, and with `exact`, all pairs are summed. The
// result does not depend on the order of queries.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#include "engine/core/elementary.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/competition/tip_field.h"
#include "environment/geometry/kernel_tree.h"
#include "environment/geometry/plane.h"

namespace espalier::environment {

namespace {

constexpr std::string_view kDensitySummary =
    "A density field made by the tips of a plane pattern, its sources and sinks.";
constexpr std::array kDensityKeys{
    ConfigurationKey{.name = "onePointValue",
                     .kind = KeyKind::Boolean,
                     .description = "the density at the tip itself instead of the smallest of 6 x 6 samples around it"},
    ConfigurationKey{.name = "returnVector",
                     .kind = KeyKind::Boolean,
                     .description = "return the vector down the gradient instead of its angle and length"},
    ConfigurationKey{.name = "plane",
                     .kind = KeyKind::Choice,
                     .description = "the plane of the pattern",
                     .defaultText = "xy",
                     .choices = kPlaneNames},
    ConfigurationKey{.name = "exact", .kind = KeyKind::Boolean, .description = "sum over all pairs: O(n^2)"},
    ConfigurationKey{
        .name = "compatible", .kind = KeyKind::Boolean, .description = "sum over all pairs, as the published program"},
};
constexpr std::array kDensityPublishedKeywords{
    PublishedKeyword{
        .keyword = "one point value", .kind = PublishedKind::Switch, .key = "onePointValue", .onWords = kOn},
    PublishedKeyword{.keyword = "return vector", .kind = PublishedKind::Switch, .key = "returnVector", .onWords = kYes},
    // of the picture that the published program can write
    PublishedKeyword{.keyword = "output image", .kind = PublishedKind::Unused, .key = {}},
    PublishedKeyword{.keyword = "frame intervals", .kind = PublishedKind::Unused, .key = {}},
    PublishedKeyword{.keyword = "quantization step", .kind = PublishedKind::Unused, .key = {}},
    PublishedKeyword{.keyword = "gamma", .kind = PublishedKind::Unused, .key = {}},
    PublishedKeyword{.keyword = "range", .kind = PublishedKind::Unused, .key = {}},
    PublishedKeyword{.keyword = "position", .kind = PublishedKind::Unused, .key = {}},
};

constexpr double kReach = 0.5;             // half the width of the samples, length units
constexpr int kSamples = 6;                // along a side
constexpr std::size_t kSmallCount = 1024;  // up to here all pairs are summed

double ofTip(double squaredDistance) {
  return 1.0 / (1.0 + squaredDistance);
}
double ofSource(double squaredDistance) {
  return 1.0 / (1.0 + std::sqrt(squaredDistance));
}

struct DensityAnswer {
  double density = 0.0;
  double x = 0.0;  // of -gradient
  double y = 0.0;
};

class Density final : public turtle::EnvironmentProcess {
 public:
  explicit Density(const Configuration& configuration)
      : isOnePoint_(configuration.flag("onePointValue")),
        returnsVector_(configuration.flag("returnVector")),
        isExact_(configuration.flag("exact") || configuration.flag("compatible")),
        plane_(planeNamed(configuration.text("plane"))) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    const std::string perLength = "1/" + lengthUnit_;
    turtle::EnvironmentDescription description{.name = "density",
                                               .summary = std::string(kDensitySummary),
                                               .needs = {.position = true, .parameters = true},
                                               .inputs = {{"sourceStrength", "1", ""}},
                                               .outputs = {{"density", "1", ""}},
                                               .isStateful = false};
    if (returnsVector_) {
      description.outputs.push_back({"descentAcross", perLength, ""});
      description.outputs.push_back({"descentAlong", perLength, ""});
    } else {
      description.outputs.push_back({"direction", "degree", ""});
      description.outputs.push_back({"slope", perLength, ""});
    }
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    lengthUnit_ = context.world.lengthUnit;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    std::vector<WeightedPoint> tips;
    std::vector<WeightedPoint> sources;
    std::vector<std::size_t> asking;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      WeightedPoint point = placeOf(queries.position[query]);
      if (parameters.size() == 1) {
        point.weight = parameters[0];
        sources.push_back(point);
      } else {
        tips.push_back(point);
      }
      if (parameters.size() == 3) {
        asking.push_back(query);
      }
    }
    const bool sumsAllPairs = isExact_ || queries.size() <= kSmallCount;
    const KernelTree sourceTree(std::move(sources), sumsAllPairs);
    if (sumsAllPairs) {
      const KernelTree tipTree(std::move(tips), true);
      for (const std::size_t query : asking) {
        setAnswer(queries, query, answerAt(placeOf(queries.position[query]), tipTree, sourceTree), replies);
      }
    } else {
      answerByField(queries, asking, tips, sourceTree, replies);
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  [[nodiscard]] WeightedPoint placeOf(const core::Vec3& p) const {
    switch (plane_) {
      case Plane::Yz:
        return {p.y, p.z, 1.0};
      case Plane::Xz:
        return {p.x, p.z, 1.0};
      case Plane::Xy:
      case Plane::Space:
        break;
    }
    return {p.x, p.y, 1.0};
  }

  [[nodiscard]] DensityAnswer answerAt(const WeightedPoint& tip, const KernelTree& tips,
                                       const KernelTree& sources) const {
    // the tip itself is in the tree and does not count
    const auto densityAt = [&](double x, double y) {
      const double own = ofTip(x * x + y * y);
      return tips.sum(tip.x + x, tip.y + y, ofTip) - own + sources.sum(tip.x + x, tip.y + y, ofSource);
    };
    if (isOnePoint_) {
      return {densityAt(0.0, 0.0), densityAt(-kReach, 0.0) - densityAt(kReach, 0.0),
              densityAt(0.0, -kReach) - densityAt(0.0, kReach)};
    }
    DensityAnswer answer;
    double squares = 0.0;
    for (int j = 0; j < kSamples; ++j) {
      for (int i = 0; i < kSamples; ++i) {
        const double x = kReach * (2.0 * i / (kSamples - 1) - 1.0);
        const double y = kReach * (2.0 * j / (kSamples - 1) - 1.0);
        const double density = densityAt(x, y);
        answer.density = i == 0 && j == 0 ? density : std::min(answer.density, density);
        answer.x -= density * x;
        answer.y -= density * y;
        squares += x * x;
      }
    }
    return {answer.density, answer.x / squares, answer.y / squares};
  }

  /// The same with one sum over the tips for all queries together.
  void answerByField(const turtle::QueryBatch& queries, const std::vector<std::size_t>& asking,
                     const std::vector<WeightedPoint>& tips, const KernelTree& sources,
                     turtle::ReplyBatch& replies) const {
    std::vector<PlanePoint> points;
    for (const WeightedPoint& tip : tips) {
      points.push_back({tip.x, tip.y});
    }
    std::vector<PlanePoint> centres;
    for (const std::size_t query : asking) {
      const WeightedPoint place = placeOf(queries.position[query]);
      centres.push_back({place.x, place.y});
    }
    std::vector<double> offsets;
    const int count = isOnePoint_ ? 3 : kSamples;
    for (int i = 0; i < count; ++i) {
      offsets.push_back(kReach * (2.0 * i / (count - 1) - 1.0));
    }
    double squares = 0.0;
    for (const double offset : offsets) {
      squares += isOnePoint_ ? 0.0 : static_cast<double>(count) * offset * offset;
    }
    std::vector<DensityAnswer> answers(asking.size(), DensityAnswer{std::numeric_limits<double>::infinity(), 0.0, 0.0});
    TipField(std::move(points))
        .sumAround(centres, offsets, [&](std::uint32_t centre, std::size_t i, std::size_t j, double sum) {
          // of the middle row and column only, when one point counts
          if (isOnePoint_ && i != 1 && j != 1) {
            return;
          }
          const double x = offsets[i];
          const double y = offsets[j];
          const double density =
              sum - ofTip(x * x + y * y) + sources.sum(centres[centre].x + x, centres[centre].y + y, ofSource);
          DensityAnswer& answer = answers[centre];
          if (!isOnePoint_ || (i == 1 && j == 1)) {
            answer.density = std::min(answer.density, density);
          }
          answer.x -= isOnePoint_ ? 2.0 * x * density : x * density / squares;
          answer.y -= isOnePoint_ ? 2.0 * y * density : y * density / squares;
        });
    for (std::size_t k = 0; k < asking.size(); ++k) {
      setAnswer(queries, asking[k], answers[k], replies);
    }
  }

  void setAnswer(const turtle::QueryBatch& queries, std::size_t query, const DensityAnswer& answer,
                 turtle::ReplyBatch& replies) const {
    replies.set(queries, query, 0, answer.density);
    if (returnsVector_) {
      replies.set(queries, query, 1, answer.x);
      replies.set(queries, query, 2, answer.y);
      return;
    }
    const double degrees = core::atan2(answer.y, answer.x) * 180.0 / std::numbers::pi;
    replies.set(queries, query, 1, degrees < 0.0 ? degrees + 360.0 : degrees);
    replies.set(queries, query, 2, core::hypot(answer.x, answer.y));
  }

  bool isOnePoint_;
  bool returnsVector_;
  bool isExact_;
  Plane plane_;
  std::string lengthUnit_ = "m";
};

}  // namespace

extern constinit const ProcessEntry kDensityProcess{
    .name = "density",
    .summary = kDensitySummary,
    .source = "Cohen 1967, Computer simulation of biological pattern generation processes",
    .keys = kDensityKeys,
    .publishedKeywords = kDensityPublishedKeywords,
    .make = [](const Configuration& configuration) -> ProcessOrErrors {
      return std::make_unique<Density>(configuration);
    }};

}  // namespace espalier::environment
