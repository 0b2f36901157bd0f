// The process `insects` (docs/environments.md): insects that walk over plants, feed, and go where there is more food.
//
// All insects see the food that the queries offer. An insect sits on the nearest offer, and those on one offer share
// it. Then each insect walks along the gradient of the density of what is left, by the mean shift of a Gaussian kernel
// (Comaniciu & Meer 2002), at most as far as its speed allows. Offers are sorted by cells of the size of the reach, so
// those near an insect are nine runs. O((n + insects) log n + offers in the cells around each insect).

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/random.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/base/state_numbers.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kInsectsSummary = "Insects that walk over plants, feed, and go where there is more food.";
constexpr std::array kInsectsKeys{
    ConfigurationKey{.name = "count",
                     .kind = KeyKind::Integer,
                     .description = "number of insects; at first they sit at random, where there is more food in "
                                    "greater number",
                     .minimum = 1.0,
                     .maximum = 1e6,
                     .defaultNumber = 10.0},
    ConfigurationKey{
        .name = "appetite", .description = "food that an insect eats in a day", .minimum = 0.0, .defaultNumber = 1.0},
    ConfigurationKey{.name = "speed",
                     .description = "way that an insect walks in a day",
                     .unit = "length",
                     .minimum = 0.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "reach",
                     .description = "distance up to which an insect notices food",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1.0},
};

class Insects final : public turtle::EnvironmentProcess {
 public:
  explicit Insects(const Configuration& configuration)
      : count_(static_cast<std::size_t>(configuration.integer("count"))),
        appetite_(configuration.number("appetite")),
        speed_(configuration.number("speed")),
        reach_(configuration.number("reach")),
        state_(1 + 3 * count_, 0.0) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "insects",
            .summary = std::string(kInsectsSummary),
            .needs = {.position = true, .parameters = true},
            .inputs = {{"food", "1", ""}},
            .outputs = {{"eaten", "1", ""}, {"insects", "1", ""}},
            .isStateful = true};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    seed_ = context.seed;
    days_ = context.world.stepDurationDays;
    std::fill(state_.begin(), state_.end(), 0.0);
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    collect(queries);
    next_ = state_;
    if (!offers_.empty() && next_.front() == 0.0) {
      settle();
    }
    takeSeats();
    for (std::size_t offer = 0; offer < offers_.size(); ++offer) {
      Offer& own = offers_[offer];
      const double eaten = std::min(own.food, appetite_ * days_ * static_cast<double>(own.insects));
      own.food -= eaten;
      replies.set(queries, own.query, 0, eaten);
      if (queries.parametersOf(own.query).size() > 1) {
        replies.set(queries, own.query, 1, static_cast<double>(own.insects));
      }
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      for (std::size_t k = 0; k < std::min<std::size_t>(parameters.size(), 2) && !(parameters[0] > 0.0); ++k) {
        replies.set(queries, query, k, 0.0);
      }
    }
    walk(queries.step);
    countAnswers(queries, replies);
    state_.swap(next_);
    return std::nullopt;
  }

  [[nodiscard]] std::string save() const override { return saveNumbers(state_); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return restoreNumbers(state, "insects", state_);
  }

 private:
  using Cell = std::array<double, 3>;  // whole numbers
  struct Offer {
    Cell cell{};
    Vec3 place;
    double food = 0.0;  // that is left
    std::size_t query = 0;
    std::uint64_t insects = 0;
  };

  [[nodiscard]] Vec3 placeOf(std::size_t insect) const {
    return {next_[1 + 3 * insect], next_[2 + 3 * insect], next_[3 + 3 * insect]};
  }
  void put(std::size_t insect, const Vec3& place) {
    next_[1 + 3 * insect] = place.x;
    next_[2 + 3 * insect] = place.y;
    next_[3 + 3 * insect] = place.z;
  }

  /// The queries that offer food, in an order that does not depend on theirs.
  void collect(const turtle::QueryBatch& queries) {
    offers_.clear();
    largest_ = 0.0;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (!parameters.empty() && parameters[0] > 0.0) {
        offers_.push_back({cellOf(queries.position[query]), queries.position[query], parameters[0], query, 0});
        largest_ = std::max(largest_, parameters[0]);
      }
    }
    const auto key = [&](const Offer& offer) {
      return std::tuple(offer.cell, offer.place.x, offer.place.y, offer.place.z, offer.food, queries.plant[offer.query],
                        queries.module[offer.query]);
    };
    std::sort(offers_.begin(), offers_.end(), [&](const Offer& a, const Offer& b) { return key(a) < key(b); });
  }

  [[nodiscard]] Cell cellOf(const Vec3& place) const {
    return {std::floor(place.x / reach_), std::floor(place.y / reach_), std::floor(place.z / reach_)};
  }

  /// Puts the insects on offers at random, with the chance of an offer its part of the food.
  void settle() {
    std::vector<double> sums;
    double sum = 0.0;
    for (const Offer& offer : offers_) {
      sum += offer.food / largest_;
      sums.push_back(sum);
    }
    for (std::size_t insect = 0; insect < count_; ++insect) {
      const double drawn = sum * draw(insect, 0, 0);
      const auto found = std::upper_bound(sums.begin(), sums.end() - 1, drawn);
      put(insect, offers_[static_cast<std::size_t>(found - sums.begin())].place);
    }
    next_.front() = 1.0;
  }

  /// Calls `visit(offer, way)` for the offers within reach of a place, ascending.
  template <typename Visit>
  void visitNear(const Vec3& place, const Visit& visit) const {
    const Cell own = cellOf(place);
    for (int i = -1; i <= 1; ++i) {
      for (int k = -1; k <= 1; ++k) {
        const Cell first{own[0] + i, own[1] + k, own[2] - 1.0};
        const Cell last{own[0] + i, own[1] + k, own[2] + 1.0};
        auto offer = std::lower_bound(offers_.begin(), offers_.end(), first,
                                      [](const Offer& one, const Cell& cell) { return one.cell < cell; });
        for (; offer != offers_.end() && offer->cell <= last; ++offer) {
          const Vec3 way = offer->place - place;
          if (core::dot(way, way) <= reach_ * reach_) {
            visit(static_cast<std::size_t>(offer - offers_.begin()), way);
          }
        }
      }
    }
  }

  /// An insect sits on the nearest offer within reach, or nowhere.
  void takeSeats() {
    for (std::size_t insect = 0; insect < count_ && next_.front() != 0.0; ++insect) {
      std::optional<std::size_t> seat;
      double nearest = HUGE_VAL;
      visitNear(placeOf(insect), [&](std::size_t offer, const Vec3& way) {
        if (core::dot(way, way) < nearest) {
          nearest = core::dot(way, way);
          seat = offer;
        }
      });
      if (seat) {
        ++offers_[*seat].insects;
      }
    }
  }

  void walk(std::uint64_t step) {
    const double furthest = speed_ * days_;
    for (std::size_t insect = 0; insect < count_ && next_.front() != 0.0; ++insect) {
      Vec3 shift;
      double weights = 0.0;
      visitNear(placeOf(insect), [&](std::size_t offer, const Vec3& way) {
        // parts of the largest offer: sums of very large numbers stay finite
        const double weight =
            offers_[offer].food / largest_ * core::exp(-2.0 * core::dot(way, way) / (reach_ * reach_));
        shift = shift + way * weight;
        weights += weight;
      });
      if (weights > 0.0) {
        shift = shift * (1.0 / weights);
        const double length = core::length(shift);
        put(insect, placeOf(insect) + (length > furthest ? shift * (furthest / length) : shift));
      } else {
        // no food in reach: somewhere
        const double height = 2.0 * draw(insect, step + 1, 1) - 1.0;
        const double angle = 2.0 * std::numbers::pi * draw(insect, step + 1, 2);
        const double width = std::sqrt(1.0 - height * height);
        put(insect, placeOf(insect) + Vec3{width * core::cos(angle), height, width * core::sin(angle)} * furthest);
      }
    }
  }

  [[nodiscard]] double draw(std::size_t insect, std::uint64_t step, std::uint32_t number) const {
    return core::CounterRandom(seed_, 0).uniform(core::DrawDomain::Environment, static_cast<std::uint32_t>(step),
                                                 insect, number);
  }

  std::size_t count_;
  double appetite_;
  double speed_;
  double reach_;
  std::uint64_t seed_ = 0;
  double days_ = 1.0;          // of a step
  std::vector<double> state_;  // whether the insects have settled, then their places (1 + 3 count)
  std::vector<double> next_;   // the same after the step
  std::vector<Offer> offers_;  // of this step, by cell and place
  double largest_ = 0.0;       // food of one of them, before insects eat
};

ProcessOrErrors makeInsects(const Configuration& configuration) {
  return std::make_unique<Insects>(configuration);
}

}  // namespace

extern constinit const ProcessEntry kInsectsProcess{
    .name = "insects",
    .summary = kInsectsSummary,
    .source = "Comaniciu & Meer 2002, Mean shift: a robust approach toward feature space analysis",
    .keys = kInsectsKeys,
    .make = makeInsects};

}  // namespace espalier::environment
