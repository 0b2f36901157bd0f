// The process `crowding` (docs/environments.md): plants share the ground by zones of influence, thin themselves out and
// sow.
//
// A plant's share is the mean over sample points that are spread evenly in its zone. Random numbers depend on seed,
// step, plant and module only. Nothing outlasts a step. O(n · samples · zones near a point).

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/random.h"
#include "engine/core/work_meter.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/competition/zone_grid.h"
#include "environment/geometry/world_up.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kCrowdingSummary =
    "Plants that share the ground by zones of influence, thin themselves out and sow.";
constexpr std::array<std::string_view, 2> kModes{"weighted", "largest"};
constexpr std::array kCrowdingKeys{
    ConfigurationKey{.name = "competition",
                     .kind = KeyKind::Choice,
                     .description =
                         "how zones share a point: by strength to the power of the asymmetry, or all for the "
                         "strongest",
                     .defaultText = "weighted",
                     .choices = kModes},
    ConfigurationKey{
        .name = "asymmetry",
        .description = "exponent a of the strengths: 0 shares equally, 1 by strength, more favours the strong",
        .minimum = 0.0,
        .maximum = 100.0,
        .defaultNumber = 1.0},
    ConfigurationKey{.name = "leastShare",
                     .description = "share of its zone that a plant needs to live, unless its query sends another",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumber = 0.3},
    ConfigurationKey{.name = "deathProbability",
                     .description = "probability that a plant with less than its least share dies in a day",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "germination",
                     .description = "probability that a seed germinates on free ground of site quality 1",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "samples",
                     .kind = KeyKind::Integer,
                     .description = "number of sample points in a zone",
                     .minimum = 1.0,
                     .maximum = 100000.0,
                     .defaultNumber = 128.0},
    ConfigurationKey{.name = "extent",
                     .kind = KeyKind::Numbers,
                     .description =
                         "the plot: smallest and largest of the first, then of the second horizontal coordinate "
                         "(x and z when y is up); none: no borders",
                     .unit = "length",
                     .maximumCount = 4},
    ConfigurationKey{
        .name = "periodic", .kind = KeyKind::Boolean, .description = "the plot repeats itself without end"},
    ConfigurationKey{.name = "siteQuality",
                     .kind = KeyKind::Rows,
                     .description =
                         "map of the plot, rows along the first horizontal coordinate, the row with the smallest "
                         "second one first; none: 1 everywhere, and 0 beyond a plot with borders",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .minimumCount = 1},
};

/// A place on the ground.
struct Place {
  double x = 0.0;
  double z = 0.0;
};

/// A plant with its zone, or one of its repetitions.
struct Zone {
  Place middle;
  double radius;
  double strength;
};

/// A power that was computed lately.
struct Weight {
  std::uint64_t bits;  // of the ratio
  double weight;
};

class Crowding final : public turtle::EnvironmentProcess {
 public:
  explicit Crowding(const Configuration& configuration)
      : takesAll_(configuration.text("competition") == "largest"),
        asymmetry_(configuration.number("asymmetry")),
        leastShare_(configuration.number("leastShare")),
        deathProbability_(configuration.number("deathProbability")),
        germination_(configuration.number("germination")),
        isPeriodic_(configuration.flag("periodic")),
        extent_(configuration.numbers("extent")),
        quality_(configuration.rows("siteQuality")) {
    // points of equal area: a spiral with the golden angle (Vogel 1979)
    const auto count = static_cast<std::size_t>(configuration.integer("samples"));
    for (std::size_t i = 0; i < count; ++i) {
      const double radius = std::sqrt((static_cast<double>(i) + 0.5) / static_cast<double>(count));
      const double angle = static_cast<double>(i) * std::numbers::pi * (3.0 - std::sqrt(5.0));
      samples_.push_back({radius * core::cos(angle), radius * core::sin(angle)});
    }
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "crowding",
            .summary = std::string(kCrowdingSummary),
            .needs = {.position = true, .parameters = true},
            .inputs = {{"radius", lengthUnit_, ""},
                       {"leastShareOrFlight", "1 or " + lengthUnit_, ""},
                       {"strength", "1", ""}},
            .outputs = {{"lives", "1", ""},
                        {"shareOrX", "1 or " + lengthUnit_, ""},
                        {"qualityOrY", "1 or " + lengthUnit_, ""},
                        {"z", lengthUnit_, ""},
                        {"quality", "1", ""}},
            .isStateful = false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto axes = gridAxesOf("crowding", context.world);
    if (!axes) {
      return axes.error();
    }
    axes_ = *axes;
    seed_ = context.seed;
    lengthUnit_ = context.world.lengthUnit;
    // of a day that is cut into steps the probabilities to live multiply
    const double days = context.world.stepDurationDays;
    deathOfStep_ = days == 1.0 ? deathProbability_ : 1.0 - core::pow(1.0 - deathProbability_, days);
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (const auto tooLarge = tooLargeZone(queries)) {
      return tooLarge;
    }
    collect(queries);
    std::vector<ZoneGrid::Disc> discs;
    discs.reserve(zones_.size());
    for (const Zone& zone : zones_) {
      discs.push_back({zone.middle.x, zone.middle.z, zone.radius});
    }
    const ZoneGrid zoneGrid(discs);
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (!parameters.empty() && parameters[0] > 0.0) {
        answerPlant(queries, query, zoneGrid, replies);
      } else if (!parameters.empty()) {
        core::pollWork();
        answerSeed(queries, query, zoneGrid, replies);
      }
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

 private:
  /// A plot that repeats itself holds all repetitions of a zone that reach into it; of a sensible zone these are few.
  [[nodiscard]] std::optional<turtle::EnvironmentError> tooLargeZone(const turtle::QueryBatch& queries) const {
    constexpr double kMost = 50.0;  // plots that a radius may span
    const double most = isPeriodic_ ? kMost * std::min(width(), depth()) : std::numeric_limits<double>::infinity();
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (!parameters.empty() && parameters[0] > most) {
        return turtle::EnvironmentError{
            "Environment 'crowding': module " + std::to_string(queries.module[query]) + " of plant " +
                std::to_string(queries.plant[query]) +
                " sends a zone whose radius is more than 50 times the side of the periodic plot. Parameter 1 is the "
                "radius, in the world's length unit: check it, or take a larger 'extent'.",
            false};
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] double width() const { return extent_[1] - extent_[0]; }
  [[nodiscard]] double depth() const { return extent_[3] - extent_[2]; }

  [[nodiscard]] Place placeOf(const Vec3& position) const {
    const Vec3 grid = axes_.toGrid(position);
    return wrapped({grid.x, grid.z});
  }

  [[nodiscard]] Place wrapped(const Place& place) const {
    if (!isPeriodic_) {
      return place;
    }
    return {place.x - width() * std::floor((place.x - extent_[0]) / width()),
            place.z - depth() * std::floor((place.z - extent_[2]) / depth())};
  }

  /// All zones, and their repetitions that reach into the plot.
  void collect(const turtle::QueryBatch& queries) {
    zones_.clear();
    for (std::size_t query = 0; query < queries.size(); ++query) {
      core::pollWork();
      const auto parameters = queries.parametersOf(query);
      if (parameters.empty() || !(parameters[0] > 0.0)) {
        continue;
      }
      const double radius = parameters[0];
      const Zone zone{placeOf(queries.position[query]), radius,
                      parameters.size() > 2 ? std::max(parameters[2], 0.0) : radius};
      if (!isPeriodic_) {
        zones_.push_back(zone);
        continue;
      }
      const auto copiesX = static_cast<int>(std::ceil(2.0 * radius / width()));
      const auto copiesZ = static_cast<int>(std::ceil(2.0 * radius / depth()));
      for (int i = -copiesX - 1; i <= copiesX + 1; ++i) {
        for (int k = -copiesZ - 1; k <= copiesZ + 1; ++k) {
          const Place middle{zone.middle.x + i * width(), zone.middle.z + k * depth()};
          // sample points of zones reach one radius beyond the plot: they are wrapped, so the plot itself is enough
          if (middle.x + radius >= extent_[0] && middle.x - radius <= extent_[1] && middle.z + radius >= extent_[2] &&
              middle.z - radius <= extent_[3]) {
            zones_.push_back({middle, radius, zone.strength});
          }
        }
      }
    }
  }

  /// The strengths of all zones over a point, ascending.
  void strengthsAt(const Place& point, const ZoneGrid& zoneGrid, std::vector<double>& strengths) const {
    strengths.clear();
    for (const std::uint32_t index : zoneGrid.near(point.x, point.z)) {
      const Zone& zone = zones_[index];
      const double dx = zone.middle.x - point.x;
      const double dz = zone.middle.z - point.z;
      if (dx * dx + dz * dz <= zone.radius * zone.radius) {
        strengths.push_back(zone.strength);
      }
    }
    std::sort(strengths.begin(), strengths.end());
  }

  /// The power of a ratio of strengths. The sample points of a plant lie under the same few zones.
  [[nodiscard]] double weightOf(double ratio) {
    const auto bits = std::bit_cast<std::uint64_t>(ratio);
    Weight& known = weights_[(bits * 0x9E3779B97F4A7C15) >> 54U];
    if (known.bits != bits) {
      known = {bits, core::pow(ratio, asymmetry_)};
    }
    return known.weight;
  }

  /// The share of a point that a zone of this strength gets.
  [[nodiscard]] double shareOf(double strength, const std::vector<double>& strengths) {
    if (takesAll_) {
      const auto equals = std::equal_range(strengths.begin(), strengths.end(), strength);
      return equals.second == strengths.end() && equals.first != equals.second
                 ? 1.0 / static_cast<double>(equals.second - equals.first)
                 : 0.0;
    }
    double sum = 0.0;
    for (const double other : strengths) {
      // relative to the strongest, so that no power is too large
      sum += strengths.back() > 0.0 ? weightOf(other / strengths.back()) : 1.0;
    }
    const double own = strengths.back() > 0.0 ? weightOf(strength / strengths.back()) : 1.0;
    return sum > 0.0 ? own / sum : 0.0;
  }

  void answerPlant(const turtle::QueryBatch& queries, std::size_t query, const ZoneGrid& zoneGrid,
                   turtle::ReplyBatch& replies) {
    const auto parameters = queries.parametersOf(query);
    const Place middle = placeOf(queries.position[query]);
    const double radius = parameters[0];
    const double strength = parameters.size() > 2 ? std::max(parameters[2], 0.0) : radius;
    double sum = 0.0;
    for (const Place& sample : samples_) {
      core::pollWork();  // many zones may lie over it
      strengthsAt(wrapped({middle.x + radius * sample.x, middle.z + radius * sample.z}), zoneGrid, strengths_);
      // rounding at the border of the own zone must not leave the point without a zone
      sum += strengths_.empty() ? 1.0 : shareOf(strength, strengths_);
    }
    const double share = sum / static_cast<double>(samples_.size());
    bool lives = share >= (parameters.size() > 1 ? parameters[1] : leastShare_);
    if (!lives && deathOfStep_ < 1.0) {
      lives = draw(queries, query, 0) >= deathOfStep_;
    }
    const std::array<double, 3> values{lives ? 1.0 : 0.0, share, qualityAt(middle)};
    for (std::size_t k = 0; k < std::min<std::size_t>(parameters.size(), values.size()); ++k) {
      replies.set(queries, query, k, values[k]);
    }
  }

  void answerSeed(const turtle::QueryBatch& queries, std::size_t query, const ZoneGrid& zoneGrid,
                  turtle::ReplyBatch& replies) const {
    const auto parameters = queries.parametersOf(query);
    const double mean = parameters.size() > 1 ? std::max(parameters[1], 0.0) : 0.0;
    // the sum of two exponential flights of half the mean has this density over the distance
    const double distance = -0.5 * mean * core::log((1.0 - draw(queries, query, 0)) * (1.0 - draw(queries, query, 1)));
    const double angle = 2.0 * std::numbers::pi * draw(queries, query, 2);
    Vec3 grid = axes_.toGrid(queries.position[query]);
    const Place place = wrapped({grid.x + distance * core::cos(angle), grid.z + distance * core::sin(angle)});
    grid.x = place.x;
    grid.z = place.z;
    const Vec3 world = axes_.toWorld(grid);
    const double quality = qualityAt(place);
    bool germinates = draw(queries, query, 3) < quality * germination_;
    if (germinates) {
      std::vector<double> strengths;
      strengthsAt(place, zoneGrid, strengths);
      germinates = strengths.empty();
    }
    const std::array<double, 5> values{germinates ? 1.0 : 0.0, world.x, world.y, world.z, quality};
    for (std::size_t k = 0; k < std::min(parameters.size(), values.size()); ++k) {
      replies.set(queries, query, k, values[k]);
    }
  }

  [[nodiscard]] double draw(const turtle::QueryBatch& queries, std::size_t query, std::uint32_t number) const {
    return core::CounterRandom(seed_, queries.plant[query])
        .uniform(core::DrawDomain::Environment, static_cast<std::uint32_t>(queries.step), queries.module[query],
                 number);
  }

  [[nodiscard]] double qualityAt(const Place& place) const {
    if (extent_.empty()) {
      return 1.0;
    }
    const double x = (place.x - extent_[0]) / width();
    const double z = (place.z - extent_[2]) / depth();
    if (!(x >= 0.0 && x < 1.0 && z >= 0.0 && z < 1.0)) {
      return 0.0;
    }
    if (quality_.empty()) {
      return 1.0;
    }
    const auto& row = quality_[static_cast<std::size_t>(z * static_cast<double>(quality_.size()))];
    return row[static_cast<std::size_t>(x * static_cast<double>(row.size()))];
  }

  bool takesAll_;
  double asymmetry_;
  double leastShare_;
  double deathProbability_;
  double deathOfStep_ = 1.0;  // set by open()
  double germination_;
  bool isPeriodic_;
  std::vector<double> extent_;  // of both horizontal coordinates, low and high; empty: no borders
  ConfigurationRows quality_;
  std::vector<Place> samples_;     // in the unit disc
  std::vector<Zone> zones_;        // of a step, with repetitions
  std::vector<double> strengths_;  // over the present sample point
  std::vector<Weight> weights_ = std::vector<Weight>(1024, {std::bit_cast<std::uint64_t>(1.0), 1.0});  // by a hash
  GridAxes axes_;
  std::uint64_t seed_ = 0;
  std::string lengthUnit_ = "m";
};

ProcessOrErrors makeCrowding(const Configuration& configuration) {
  const auto& extent = configuration.numbers("extent");
  std::string wrong;
  if (!extent.empty() && (extent.size() != 4 || !(extent[0] < extent[1] && extent[2] < extent[3]))) {
    wrong = "'extent' is not a smallest and a largest number for each of the two horizontal coordinates";
  } else if (extent.empty() && (configuration.flag("periodic") || !configuration.rows("siteQuality").empty())) {
    wrong = "'periodic' and 'siteQuality' need the 'extent' of the plot";
  }
  if (!wrong.empty()) {
    return refuse("crowding", wrong, "write for example \"extent\": [-5, 5, -5, 5]");
  }
  return std::make_unique<Crowding>(configuration);
}

}  // namespace

extern constinit const ProcessEntry kCrowdingProcess{
    .name = "crowding",
    .summary = kCrowdingSummary,
    .source =
        "Gates & Westcott 1978; Weiner et al. 2001, The effects of density, spatial pattern, and competitive symmetry "
        "on size variation in simulated plant populations; Deussen et al. 1998",
    .keys = kCrowdingKeys,
    .make = makeCrowding};

}  // namespace espalier::environment
