// The process `wind` (docs/environments.md): the velocity of the air, constant or by height above the ground.
//
// Profiles after Monteith & Unsworth, Principles of Environmental Physics (1990). O(n).

#include <algorithm>
#include <array>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/turtle/weather.h"
#include "environment/base/default_lengths.h"
#include "environment/base/length_unit.h"
#include "environment/base/process_entry.h"
#include "environment/directions/direction_reply.h"
#include "environment/geometry/world_up.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kWindSummary = "The velocity of the air, constant or by height above the ground.";
constexpr std::array kEast{1.0, 0.0, 0.0};
constexpr std::array<std::string_view, 4> kProfiles{"constant", "logarithmic", "power", "table"};
constexpr std::array kWindKeys{
    ConfigurationKey{.name = "direction",
                     .kind = KeyKind::Numbers,
                     .description = "x, y, z of the direction in which the wind blows, of any length but 0",
                     .defaultNumbers = kEast,
                     .minimumCount = 3,
                     .maximumCount = 3},
    ConfigurationKey{.name = "speed",
                     .description =
                         "speed, with a profile at the reference height; the weather's wind takes its place; "
                         "the default is converted from metres",
                     .unit = "length/s",
                     .minimum = 0.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "profile",
                     .kind = KeyKind::Choice,
                     .description = "how the speed changes with height",
                     .defaultText = "constant",
                     .choices = kProfiles},
    ConfigurationKey{
        .name = "groundHeight", .description = "height of the ground along the world's up", .unit = "length"},
    ConfigurationKey{.name = "referenceHeight",
                     .description = "height above the ground at which the speed is known; the default is converted "
                                    "from metres",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 10.0},
    ConfigurationKey{.name = "roughness",
                     .description = "z0 of the logarithmic profile; the default is converted from metres",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 0.1},
    ConfigurationKey{.name = "displacement",
                     .description = "d of the logarithmic profile, about two thirds of a canopy's height",
                     .unit = "length",
                     .minimum = 0.0},
    ConfigurationKey{.name = "exponent",
                     .description = "exponent of the power profile",
                     .minimum = 0.0,
                     .maximum = 2.0,
                     .defaultNumber = 0.143},
    ConfigurationKey{.name = "heights",
                     .kind = KeyKind::Numbers,
                     .description = "ascending heights above the ground of the table profile",
                     .unit = "length"},
    ConfigurationKey{.name = "speeds",
                     .kind = KeyKind::Numbers,
                     .description = "speeds at the heights of the table profile",
                     .unit = "length/s",
                     .minimum = 0.0},
};

constexpr std::string_view kLowReference =
    "'referenceHeight' must be above displacement + roughness, where the wind begins";

enum class Profile : std::uint8_t { Constant, Logarithmic, Power, Table };

class Wind final : public turtle::EnvironmentProcess {
 public:
  explicit Wind(Configuration given) : given_(std::move(given)) {
    const auto chosen = std::find(kProfiles.begin(), kProfiles.end(), given_.text("profile"));
    profile_ = static_cast<Profile>(chosen - kProfiles.begin());
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return {.name = "wind",
            .summary = std::string(kWindSummary),
            .needs = {.position = true},
            .inputs = {},
            .outputs = vectorOutputs("velocity", lengthUnit_ + "/s"),
            .isStateful = false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto up = upOf("wind", context.world);
    if (!up) {
      return up.error();
    }
    up_ = *up;
    lengthUnit_ = context.world.lengthUnit;
    world_ = context.world;
    read(withDefaultLengths(given_, kWindKeys, findLengthUnit(lengthUnit_)));
    if (profile_ == Profile::Logarithmic && reference_ <= displacement_ + roughness_) {
      return turtle::EnvironmentError{"Environment 'wind': " + std::string(kLowReference) +
                                          ", in a world whose unit is '" + lengthUnit_ +
                                          "'. The usual reference height is 10 m.",
                                      false};
    }
    isMeasured_ = world_.weather && world_.weather->has("wind") && profile_ != Profile::Table;
    if (isMeasured_ && findLengthUnit(lengthUnit_) == nullptr) {
      return unknownLengthUnit("wind", world_);
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (isMeasured_) {
      const double end = queries.timeDays + world_.stepDurationDays;
      const auto mean = world_.weather->mean("wind", queries.timeDays, end);
      if (!mean) {
        return turtle::EnvironmentError{
            "Environment 'wind' " + turtle::missingWeather(world_, "wind", queries.timeDays, end), false};
      }
      speed_ = *mean / findLengthUnit(lengthUnit_)->metres;
    }
    replyVectors(queries, replies,
                 [this](const Vec3& place) { return direction_ * speedAt(core::dot(place, up_) - ground_); });
    return std::nullopt;
  }

 private:
  void read(const Configuration& c) {
    const auto& direction = c.numbers("direction");
    direction_ = core::normalised({direction[0], direction[1], direction[2]});
    speed_ = c.number("speed");
    ground_ = c.number("groundHeight");
    reference_ = c.number("referenceHeight");
    roughness_ = c.number("roughness");
    displacement_ = c.number("displacement");
    exponent_ = c.number("exponent");
    heights_ = c.numbers("heights");
    speeds_ = c.numbers("speeds");
  }

  [[nodiscard]] double speedAt(double height) const {
    switch (profile_) {
      case Profile::Constant:
        return speed_;
      case Profile::Logarithmic:
        return height <= displacement_ + roughness_ ? 0.0
                                                    : speed_ * core::log((height - displacement_) / roughness_) /
                                                          core::log((reference_ - displacement_) / roughness_);
      case Profile::Power:
        return height <= 0.0 ? 0.0 : speed_ * core::pow(height / reference_, exponent_);
      case Profile::Table:
        break;
    }
    const auto above = std::upper_bound(heights_.begin(), heights_.end(), height);
    if (above == heights_.begin()) {
      return speeds_.front();
    }
    if (above == heights_.end()) {
      return speeds_.back();
    }
    const auto i = static_cast<std::size_t>(above - heights_.begin());
    const double part = (height - heights_[i - 1]) / (heights_[i] - heights_[i - 1]);
    return speeds_[i - 1] + part * (speeds_[i] - speeds_[i - 1]);
  }

  Configuration given_;
  Profile profile_ = Profile::Constant;
  // in the world's unit, from open() on
  Vec3 direction_;
  double speed_ = 0.0;  // of this step
  double ground_ = 0.0;
  double reference_ = 0.0;
  double roughness_ = 0.0;
  double displacement_ = 0.0;
  double exponent_ = 0.0;
  std::vector<double> heights_;  // ascending
  std::vector<double> speeds_;   // as many
  Vec3 up_{0.0, 1.0, 0.0};
  std::string lengthUnit_ = "m";
  turtle::World world_;
  bool isMeasured_ = false;  // the weather brings the speed
};

ProcessOrErrors makeWind(const Configuration& configuration) {
  if (!givenVector(configuration, "direction")) {
    return refuseDirection("wind", "direction");
  }
  const auto& heights = configuration.numbers("heights");
  const auto& speeds = configuration.numbers("speeds");
  // a height that is not given depends on the world's unit
  if (configuration.text("profile") == "logarithmic" && configuration.isGiven("referenceHeight") &&
      configuration.isGiven("roughness") &&
      configuration.number("referenceHeight") <=
          configuration.number("displacement") + configuration.number("roughness")) {
    return refuse("wind", std::string(kLowReference), "the usual reference height is 10 m");
  }
  if (configuration.text("profile") == "table") {
    if (heights.empty() || heights.size() != speeds.size()) {
      return refuse(
          "wind",
          "there are " + std::to_string(heights.size()) + " heights and " + std::to_string(speeds.size()) + " speeds",
          "the table profile needs one speed for each of at least one height");
    }
    if (std::adjacent_find(heights.begin(), heights.end(), [](double a, double b) { return a >= b; }) !=
        heights.end()) {
      return refuse("wind", "'heights' must be ascending", "sort them, each with its speed");
    }
  }
  return std::make_unique<Wind>(configuration);
}

}  // namespace

extern constinit const ProcessEntry kWindProcess{
    .name = "wind",
    .summary = kWindSummary,
    .source = "Monteith & Unsworth 1990, Principles of Environmental Physics",
    .keys = kWindKeys,
    .make = makeWind};

}  // namespace espalier::environment
