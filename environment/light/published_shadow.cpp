// The process `shadow` as the published program shadowpyramid: voxels are cut towards 0, the light outside the grid is
// that of its border, the gradient is a plain difference, and bias and randomness are in the field. In 32-bit floats.
//
// A voxel's light is its value at the beginning of the step times the factors of its shadows. Only voxels with a shadow
// are stored. The random numbers of the field are one sequence through all steps, so their count is the state.
// O(n · shadowDepth^3) for n queries.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/core/work_meter.h"
#include "environment/base/replies.h"
#include "environment/base/state_bytes.h"
#include "environment/geometry/bricked_grid.h"
#include "environment/geometry/float_vec.h"
#include "environment/geometry/world_up.h"
#include "environment/light/published_variants.h"

namespace espalier::environment {

namespace {

/// Draw number `index`, from 0, of the reference program's generator started at X = 0: X <- aX + 11 mod 2^48, value
/// X / 2^48. O(log index).
float drawAt(std::uint64_t index) {
  constexpr std::uint64_t kMask = (std::uint64_t{1} << 48U) - 1;
  // the map x -> factor·x + addend of 2^k steps, and that of the steps so far
  std::uint64_t factor = 0x5DEECE66DULL;
  std::uint64_t addend = 0xBULL;
  std::uint64_t state = 0;
  for (std::uint64_t steps = index + 1; steps > 0; steps >>= 1U) {
    if ((steps & 1U) != 0) {
      state = (factor * state + addend) & kMask;
    }
    addend = (factor * addend + addend) & kMask;
    factor = (factor * factor) & kMask;
  }
  return static_cast<float>(static_cast<double>(state) / 281474976710656.0);
}

/// Where a point lies in the grid: the low voxel of the eight around it, and the part of the way to the next.
struct Corner {
  std::int64_t voxel = 0;
  float part = 0.0F;
};

class PublishedShadow final : public turtle::EnvironmentProcess {
 public:
  explicit PublishedShadow(const Configuration& c)
      : size_(c.integer("gridSize")),
        span_(toFloat(c.number("gridSpan"))),
        voxelsPerLength_(static_cast<float>(size_ - 1) / (2.0F * span_)),
        spread_(toFloat(c.number("shadowSpread"))),
        depth_(c.integer("shadowDepth")),
        randomness_(toFloat(c.number("lightRandomness"))),
        verticalBias_(toFloat(c.number("lightVerticalBias"))),
        sampleRadius_(toFloat(c.number("sampleRadius"))),
        shadows_(size_) {
    // one factor for each squared distance in the pyramid
    const double weight = c.number("shadowWeight");
    const double dissipation = c.number("shadowDissipation");
    const std::int64_t reach = halfWidth(depth_ - 1);
    const std::int64_t last = (depth_ - 1) * (depth_ - 1) + 2 * reach * reach;
    for (std::int64_t squared = 0; squared <= last; ++squared) {
      const double exposure = weight * std::pow(dissipation, -std::sqrt(static_cast<double>(squared)));
      factorOf_.push_back(1.0F - std::min(1.0F, toFloat(exposure)));
    }
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description = describeShadow(lengthUnit_);
    description.isStateful = randomness_ != 0.0F;
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto axes = gridAxesOf("shadow", context.world);
    if (!axes) {
      return axes.error();
    }
    axes_ = *axes;
    lengthUnit_ = context.world.lengthUnit;
    passCount_ = 0;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    // all shadows first, then all answers
    shadows_.clear();
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (!parameters.empty() && parameters[0] > 0.0) {
        castShadow(toFloat(axes_.toGrid(queries.position[query])));
      }
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const std::size_t count = queries.parametersOf(query).size();
      const FloatVec point = toFloat(axes_.toGrid(queries.position[query]));
      if (count > 0) {
        replies.set(queries, query, 0, lightAt(point));
      }
      if (count > 3) {
        const core::Vec3 gradient = axes_.toWorld(toDouble(gradientAt(point)));
        replies.set(queries, query, 1, gradient.x);
        replies.set(queries, query, 2, gradient.y);
        replies.set(queries, query, 3, gradient.z);
      }
    }
    countAnswers(queries, replies);
    passCount_ += queries.size() > 0 ? 1 : 0;
    return std::nullopt;
  }

  [[nodiscard]] std::string save() const override {
    if (randomness_ == 0.0F) {
      return {};
    }
    StateWriter writer;
    writer.integer(passCount_);
    return writer.take();
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    if (randomness_ == 0.0F && state.empty()) {
      return std::nullopt;
    }
    StateReader reader(state);
    const std::uint64_t passCount = reader.integer();
    if (!reader.isComplete() || randomness_ == 0.0F) {
      return turtle::EnvironmentError{
          "The saved state of environment 'shadow' is damaged. Use a snapshot that is complete and was made with this "
          "configuration.",
          false};
    }
    passCount_ = passCount;
    return std::nullopt;
  }

 private:
  struct Product {
    float value = 1.0F;
  };

  [[nodiscard]] std::int64_t halfWidth(std::int64_t tier) const {
    return static_cast<std::int64_t>(static_cast<float>(tier) * spread_);
  }

  /// A place in voxels cut towards 0 and kept within 0 … last.
  [[nodiscard]] static std::int64_t cut(float place, std::int64_t last) {
    return place > 0.0F ? static_cast<std::int64_t>(std::min(place, static_cast<float>(last))) : 0;
  }

  void castShadow(const FloatVec& point) {
    const float half = static_cast<float>(size_) / 2.0F;
    const std::int64_t last = size_ - 1;
    const std::int64_t x = cut(point.x * voxelsPerLength_ + half, last);
    const std::int64_t y = cut(point.y * voxelsPerLength_, last);
    const std::int64_t z = cut(point.z * voxelsPerLength_ + half, last);
    for (std::int64_t tier = 0; tier < depth_ && tier <= y; ++tier) {
      core::pollWork();
      const std::int64_t width = halfWidth(tier);
      for (std::int64_t i = std::max(x - width, std::int64_t{0}); i <= std::min(x + width, last); ++i) {
        for (std::int64_t k = std::max(z - width, std::int64_t{0}); k <= std::min(z + width, last); ++k) {
          const std::int64_t squared = tier * tier + (i - x) * (i - x) + (k - z) * (k - z);
          shadows_.at(i, y - tier, k).value *= factorOf_[static_cast<std::size_t>(squared)];
        }
      }
    }
  }

  /// The light of a voxel before any shadow of the step.
  [[nodiscard]] float fieldOf(std::int64_t x, std::int64_t y, std::int64_t z) const {
    if (y < 1 || y > size_ - 2) {
      return 1.0F;
    }
    float light = 1.0F - (randomness_ + verticalBias_);
    if (randomness_ != 0.0F) {
      // drawn with z outermost, then x, then y
      const auto n = static_cast<std::uint64_t>(size_);
      const std::uint64_t column = (passCount_ * n + static_cast<std::uint64_t>(z)) * n + static_cast<std::uint64_t>(x);
      light += randomness_ * drawAt(column * (n - 2) + static_cast<std::uint64_t>(y - 1));
    }
    return light + verticalBias_ * static_cast<float>(y) / static_cast<float>(size_);
  }

  [[nodiscard]] float lightOfVoxel(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return fieldOf(x, y, z) * shadows_.get(x, y, z).value;
  }

  /// The part is that of the place without the offset, as in the published program: half a voxel off in an even grid.
  [[nodiscard]] Corner cornerOf(float coordinate, float offset) const {
    const float place = coordinate * voxelsPerLength_;
    return {cut(place + offset, size_ - 2), place - std::floor(place)};
  }

  [[nodiscard]] float lightAt(const FloatVec& point) const {
    const float middle = static_cast<float>(size_ - 1) / 2.0F;
    const std::array corners{cornerOf(point.x, middle), cornerOf(point.y, 0.0F), cornerOf(point.z, middle)};
    float light = 0.0F;
    for (unsigned corner = 0; corner < 8; ++corner) {
      std::array<std::int64_t, 3> voxel{};
      float weight = 1.0F;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool isNext = (corner >> axis & 1U) != 0;
        voxel[axis] = corners[axis].voxel + (isNext ? 1 : 0);
        weight *= isNext ? corners[axis].part : 1.0F - corners[axis].part;
      }
      if (weight != 0.0F) {
        light += weight * lightOfVoxel(voxel[0], voxel[1], voxel[2]);
      }
    }
    return light;
  }

  /// A point moved into the grid.
  [[nodiscard]] FloatVec inside(const FloatVec& p) const {
    const float most = 0.9999F * span_;
    return {std::clamp(p.x, -most, most), std::min(std::max(p.y, 0.0001F), 1.9999F * span_),
            std::clamp(p.z, -most, most)};
  }

  [[nodiscard]] FloatVec gradientAt(const FloatVec& point) const {
    const FloatVec p = inside(point);
    const float r = sampleRadius_;
    const auto difference = [&](const FloatVec& way) { return lightAt(inside(p + way)) - lightAt(inside(p - way)); };
    return {difference({r, 0.0F, 0.0F}), difference({0.0F, r, 0.0F}), difference({0.0F, 0.0F, r})};
  }

  std::int64_t size_;
  float span_;
  float voxelsPerLength_;
  float spread_;
  std::int64_t depth_;
  float randomness_;
  float verticalBias_;
  float sampleRadius_;
  std::vector<float> factorOf_;   // of a shadow by squared distance in voxels
  BrickedGrid<Product> shadows_;  // of this step; x, y up, z
  std::uint64_t passCount_ = 0;   // steps with queries so far
  GridAxes axes_;
  std::string lengthUnit_ = "m";
};

}  // namespace

std::unique_ptr<turtle::EnvironmentProcess> makePublishedShadow(const Configuration& configuration) {
  return std::make_unique<PublishedShadow>(configuration);
}

}  // namespace espalier::environment
