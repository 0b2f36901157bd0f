// The process `xylem` (docs/environments.md): water in the xylem of plants, from the soil through root tips to collars
// and leaves.
//
// The segments that the plants draw are joined to trees (plant_trees.h) and solved exactly (hydraulic_tree.h), alone
// or together with the water of a soil within the step (root_uptake.h). O(segments · rounds · internal steps), and the
// cost of the soil.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"
#include "engine/turtle/field.h"
#include "engine/turtle/turtle_motion.h"
#include "engine/turtle/weather.h"
#include "environment/base/length_unit.h"
#include "environment/base/number_text.h"
#include "environment/base/replies.h"
#include "environment/base/state_numbers.h"
#include "environment/geometry/world_up.h"
#include "environment/hydraulics/plant_trees.h"
#include "environment/hydraulics/uptake_fractions.h"
#include "environment/hydraulics/xylem_keys.h"

namespace espalier::environment {

namespace {

using core::Vec3;
using Collar = HydraulicTree::Collar;

constexpr std::size_t kMostNodes = std::size_t{1} << 25;

/// The time of the day at the start, days after midnight: of the mean sun where the longitude is known, else as the
/// start is written.
double clockOf(const turtle::World& world) {
  const std::size_t time = world.start.find_first_of("T ");
  const std::string local = world.start.substr(0, world.start.find_first_of("Z+-", std::min(time, world.start.size())));
  const auto seconds = turtle::secondsOfDate(world.longitudeDegrees ? world.start : local);
  if (!seconds) {
    return 0.0;
  }
  constexpr std::int64_t kSecondsPerDay = 86400;
  const double days = static_cast<double>(*seconds % kSecondsPerDay) / static_cast<double>(kSecondsPerDay) +
                      world.longitudeDegrees.value_or(0.0) / 360.0;
  return days - std::floor(days);
}

/// The data from queries about the segment before them.
struct SegmentTraits {
  double age = 0.0;
  double order = 0.0;         // 0: as drawn
  double demand = 0.0;        // at the node, length³/day
  double leafArea = 0.0;      // of leaves with stomata at the node, length²
  double netRadiation = 0.0;  // sum of area times net radiation, length² W/m²
  double par = 0.0;           // sum of area times light, length² µmol m⁻² s⁻¹
  std::optional<double> radial, axial;
};

/// The plants of a step as trees of segments that fit into cells of soil.
struct Plants {
  std::vector<std::uint32_t> first;  // first node of the tree for each node of PlantTrees, and the end
  std::vector<Vec3> middles;         // of the segments of the tree's nodes (nodes of the tree)
  std::vector<std::uint8_t> axes;    // world axes along which those run most (nodes of the tree)
  std::vector<HydraulicTree::Node> nodes;
};

class Xylem final : public turtle::EnvironmentProcess {
 public:
  Xylem(const Configuration& configuration, std::optional<SoilBody> soil)
      : given_(readXylem(configuration)), soil_(std::move(soil)) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    const std::string& unit = lengthUnit_;
    const std::string flow = unit + "^3/day";
    return {.name = "xylem",
            .summary = std::string(kXylemSummary),
            .needs = {.position = true, .parameters = true, .geometry = true},
            .inputs = {{"age", "day", ""},
                       {"order", "1", ""},
                       hasStomata() ? turtle::EnvironmentVariable{"leafArea", unit + "^2", ""}
                                    : turtle::EnvironmentVariable{"waterGivenOff", flow, ""},
                       {hasStomata() ? "netRadiation" : "unused4", hasStomata() ? "W/m^2" : "1", ""},
                       {hasStomata() ? "par" : "unused5", hasStomata() ? "umol/(m^2 s)" : "1", ""},
                       {"unused6", "1", ""},
                       {"unused7", "1", ""},
                       {"unused8", "1", ""},
                       {"unused9", "1", ""},
                       {"unused10", "1", ""},
                       {"kr", "1/day", ""},
                       {"kx", flow, ""}},
            .outputs = {{"unused1", "1", ""},
                        {"unused2", "1", ""},
                        {"unused3", "1", ""},
                        {"head", unit, ""},
                        {"waterExchanged", flow, ""},
                        {"collarHead", unit, ""},
                        {"collarFlow", flow, ""},
                        {"conductance", unit + "^2/day", ""},
                        {"uptakeFraction", "1", ""},
                        {"surfaceHead", unit, ""},
                        {"unused11", "1", ""},
                        {"unused12", "1", ""},
                        {"waterContent", "1", ""},
                        {"gradientX", "1/" + unit, ""},
                        {"gradientY", "1/" + unit, ""},
                        {"gradientZ", "1/" + unit, ""}},
            .isStateful = soil_.has_value()};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto up = upOf("xylem", context.world);
    if (!up) {
      return up.error();
    }
    const LengthUnit* unit = findLengthUnit(context.world.lengthUnit);
    if (unit == nullptr) {
      return unknownLengthUnit("xylem", context.world);
    }
    if (!(context.world.stepDurationDays > 0.0)) {
      return failure("lets time pass in steps: the world's 'stepDurationDays' must be greater than 0.");
    }
    up_ = *up;
    lengthUnit_ = context.world.lengthUnit;
    days_ = context.world.stepDurationDays;
    keys_ = given_;
    trees_ = PlantTrees(keys_.join);
    const double metres = unit->metres;
    for (const auto& [isGiven, head] : {std::pair(keys_.hasOwnSoilHead, &keys_.soilHead),
                                        {keys_.hasOwnCollarHead, &keys_.collarHead},
                                        {keys_.hasOwnLowestHead, &keys_.lowestHead}}) {
      *head /= isGiven ? 1.0 : metres;
    }
    keys_.leafGas.stomata.halfHead /= keys_.leafGas.hasOwnStomataHead ? 1.0 : metres;
    keys_.leafGas.growthHead /= keys_.leafGas.hasOwnGrowthHead ? 1.0 : metres;
    metres_ = metres;
    world_ = context.world;
    clock_ = clockOf(context.world);
    axialUnit_ = keys_.hasOwnAxial ? 1.0 : 1.0 / (metres * metres * metres);
    return soil_ ? soil_->open("xylem", context.world) : std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    const std::vector<double> before = soil_ ? soil_->numbers() : std::vector<double>();
    const auto goBack = [&] {
      if (soil_) {
        soil_->setNumbers(before);
      }
    };
    try {
      auto error = advance(queries, replies);
      if (error) {
        goBack();
      }
      return error;
    } catch (...) {
      goBack();
      throw;
    }
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t) override {
    turtle::ReplyBatch none;
    turtle::QueryBatch nobody;
    nobody.parameterOffset.push_back(0);
    return step(nobody, none);
  }

  [[nodiscard]] std::vector<turtle::Field> fields() const override {
    return soil_ ? soil_->fields() : std::vector<turtle::Field>();
  }
  [[nodiscard]] std::string save() const override {
    return soil_ && soil_->isOpen() ? saveNumbers(soil_->numbers()) : std::string();
  }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    std::vector<double> read = soil_ ? soil_->numbers() : std::vector<double>();
    if (!soil_ && state.empty()) {
      return std::nullopt;
    }
    if (auto error = restoreNumbers(state, "xylem", read)) {
      return error;
    }
    if (soil_) {
      soil_->setNumbers(read);
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] static turtle::EnvironmentError failure(const std::string& sentences) {
    return {"Environment 'xylem' " + sentences, false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> advance(const turtle::QueryBatch& queries,
                                                                turtle::ReplyBatch& replies) {
    static const turtle::Geometry kNothing;
    const turtle::Geometry& geometry = queries.geometry ? *queries.geometry : kNothing;
    if (geometry.areWidthsPixels && keys_.radius == 0.0 && geometry.segments.size() > 0) {
      return failure(
          "needs the radius of segments, and the model draws lines of so many pixels. Give the key 'radius', or 'line "
          "style: cylinder' in the view file.");
    }
    trees_.update(geometry);
    const PlantTrees& trees = trees_;
    std::vector<SegmentTraits> traits(trees.nodes().size());
    std::vector<std::uint32_t> nodeOf(queries.size(), PlantTrees::kNone);
    if (auto error = readQueries(queries, trees, traits, nodeOf)) {
      return error;
    }
    auto plants = plantsOf(trees, traits);
    if (!plants) {
      return plants.error();
    }
    if (const auto dry = plantWithoutUptake(plants->nodes)) {
      return failure("is asked for water that leaves of plant " + std::to_string(*dry) +
                     " give off, and no segment of that plant takes any up: all are above 'groundHeight', or 'kr' is "
                     "0. Put roots into the ground, give a 'kr', or 'closingHeads', at which leaves close.");
    }
    PlantWater water(HydraulicTree(std::move(plants->nodes)), keys_.leaves, keys_.vessels);
    if (hasStomata()) {
      if (auto error = setLeaves(queries.timeDays, traits, *plants, water)) {
        return error;
      }
    }
    WaterSums sums;
    if (auto error = passTime(queries.timeDays, trees, traits, *plants, water, sums)) {
      return error;
    }
    fractions_.update(std::move(water.nodes()));
    answer(queries, trees, *plants, nodeOf, sums, replies);
    countAnswers(queries, replies);
    return std::nullopt;
  }

  /// Finds the node of each query and takes over what the query says about the segments of its module.
  [[nodiscard]] std::optional<turtle::EnvironmentError> readQueries(const turtle::QueryBatch& queries,
                                                                    const PlantTrees& trees,
                                                                    std::vector<SegmentTraits>& traits,
                                                                    std::vector<std::uint32_t>& nodeOf) const {
    const auto& nodes = trees.nodes();
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      const auto sent = [&](std::size_t k) { return k < parameters.size() ? parameters[k] : 0.0; };
      const auto node = trees.nodeAt(queries.plant[query], queries.module[query], queries.position[query]);
      if (!node) {
        continue;
      }
      nodeOf[query] = *node;
      for (const auto& [name, k] : {std::pair(hasStomata() ? "leaf area" : "water given off", std::size_t{2}),
                                    {"light", std::size_t{4}},
                                    {"radial conductivity kr", std::size_t{10}},
                                    {"axial conductance kx", std::size_t{11}}}) {
        if (k == 4 && !hasStomata()) {
          continue;
        }
        if (sent(k) < 0.0 || (k == 11 && parameters.size() > 11 && sent(k) == 0.0)) {
          return failure("got the " + std::string(name) + " " + numberText(sent(k)) + " in parameter " +
                         std::to_string(k + 1) + " of module " + std::to_string(queries.module[query]) + " of plant " +
                         std::to_string(queries.plant[query]) + ". Send a number " +
                         (k == 11  ? "above 0."
                          : k == 4 ? "of at least 0, in each step again: the answer to a leaf takes the place of what "
                                     "it sent."
                                   : "of at least 0."));
        }
      }
      if (hasStomata()) {
        traits[*node].leafArea += sent(2);
        traits[*node].netRadiation += sent(2) * sent(3);
        traits[*node].par += sent(2) * sent(4);
      } else {
        traits[*node].demand += sent(2);
      }
      // all segments of the module are of one age and order
      for (std::uint32_t i = *node; nodes[i].parent != PlantTrees::kNone && nodes[i].plant == nodes[*node].plant &&
                                    nodes[i].module == nodes[*node].module;
           --i) {
        traits[i].age = sent(0);
        traits[i].order = sent(1);
        traits[i].radial = parameters.size() > 10 ? std::optional(sent(10)) : std::nullopt;
        traits[i].axial = parameters.size() > 11 ? std::optional(sent(11)) : std::nullopt;
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] bool hasStomata() const { return given_.leafGas.hasStomata; }

  /// The mean of a quantity of the weather, or a constant when the weather does not have it.
  [[nodiscard]] double meanOf(std::string_view quantity, double constant, double from, double until) const {
    const bool isKnown = world_.weather && world_.weather->has(quantity);
    return isKnown ? world_.weather->mean(quantity, from, until).value_or(constant) : constant;
  }

  /// The air between two times, and the conductance of the boundary layer of leaves in it.
  [[nodiscard]] std::pair<Air, double> airBetween(double from, double until) const {
    const LeafKeys& keys = keys_.leafGas;
    Air air{.temperature = meanOf("temperature", keys.temperature, from, until), .pressure = keys.pressure};
    air.vapourPressure = 0.01 * meanOf("humidity", keys.humidity, from, until) * saturationPressure(air.temperature);
    return {air, keys.boundary > 0.0 ? keys.boundary
                                     : boundaryConductance(keys.width, meanOf("wind", keys.wind, from, until))};
  }

  /// Gives the leaves with stomata their places, and says when the weather of the step is not known.
  [[nodiscard]] std::optional<turtle::EnvironmentError> setLeaves(double timeDays,
                                                                  const std::vector<SegmentTraits>& traits,
                                                                  const Plants& plants, PlantWater& water) const {
    for (const char* quantity : {"temperature", "humidity", "wind"}) {
      if (world_.weather && world_.weather->has(quantity) &&
          !world_.weather->mean(quantity, timeDays, timeDays + days_)) {
        return failure(turtle::missingWeather(world_, quantity, timeDays, timeDays + days_));
      }
    }
    water.setStomata(keys_.leafGas.stomata, keys_.leafGas.isCurve);
    for (std::size_t i = 0; i < traits.size(); ++i) {
      if (traits[i].leafArea > 0.0) {
        // kg m⁻² s⁻¹ on that area as length³/day
        PlantWater::GasLeaf& leaf = water.gasLeaves()[plants.first[i + 1] - 1];
        leaf.flow = traits[i].leafArea * 86.4 / metres_;
        leaf.netRadiation = traits[i].netRadiation / traits[i].leafArea;
      }
    }
    setAir(timeDays, timeDays + days_, traits, plants, water);
    return std::nullopt;
  }

  /// Gives the leaves with stomata the air between two times.
  void setAir(double from, double until, const std::vector<SegmentTraits>& traits, const Plants& plants,
              PlantWater& water) const {
    const auto [air, boundary] = airBetween(from, until);
    const Stomata& stomata = keys_.leafGas.stomata;
    for (std::size_t i = 0; i < traits.size(); ++i) {
      if (traits[i].leafArea > 0.0) {
        PlantWater::GasLeaf& leaf = water.gasLeaves()[plants.first[i + 1] - 1];
        leaf.air = air;
        leaf.boundary = boundary;
        leaf.open = stomata.most * stomata.openness(traits[i].par / traits[i].leafArea, air.deficit());
      }
    }
  }

  /// The smallest side of the soil's cells; infinite without soil.
  [[nodiscard]] double smallestSide() const {
    double side = std::numeric_limits<double>::infinity();
    for (std::size_t cell = 0; soil_ && cell < soil_->water().cellCount(); ++cell) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        side = std::min(side, soil_->water().sizeOf(cell, axis));
      }
    }
    return side;
  }

  [[nodiscard]] double heightOf(const Vec3& place) const { return core::dot(place, up_); }

  [[nodiscard]] double profileAt(double height) const {
    const auto& rows = keys_.soilHeads;
    if (rows.empty()) {
      return keys_.soilHead;
    }
    const auto above = std::find_if(rows.begin(), rows.end(), [&](const auto& row) { return row[0] > height; });
    if (above == rows.begin() || above == rows.end()) {
      return above == rows.begin() ? rows.front()[1] : rows.back()[1];
    }
    const auto& below = *(above - 1);
    return below[1] + (height - below[0]) / ((*above)[0] - below[0]) * ((*above)[1] - below[1]);
  }

  [[nodiscard]] tl::expected<Plants, turtle::EnvironmentError> plantsOf(
      const PlantTrees& trees, const std::vector<SegmentTraits>& traits) const {
    const double longest = smallestSide();
    Plants plants;
    plants.first.reserve(trees.nodes().size() + 1);
    plants.middles.reserve(trees.nodes().size());
    plants.axes.reserve(trees.nodes().size());
    plants.nodes.reserve(trees.nodes().size());
    for (std::size_t i = 0; i < trees.nodes().size(); ++i) {
      const PlantTrees::Node& from = trees.nodes()[i];
      plants.first.push_back(static_cast<std::uint32_t>(plants.nodes.size()));
      HydraulicTree::Node node;
      node.plant = from.plant;
      node.radius = keys_.radius > 0.0 ? keys_.radius : from.radius;
      if (from.parent == PlantTrees::kNone) {
        plants.nodes.push_back(node);
        plants.middles.push_back(from.place);
        plants.axes.push_back(0);
        continue;
      }
      const Vec3& start = trees.nodes()[from.parent].place;
      const Vec3 way = from.place - start;
      const Vec3 size{std::abs(way.x), std::abs(way.y), std::abs(way.z)};
      const std::uint8_t axis = size.z > std::max(size.x, size.y) ? 2 : size.y > size.x ? 1 : 0;
      const double parts = std::max(1.0, std::ceil(core::length(way) / longest - 1e-9));
      if (!(parts + static_cast<double>(plants.nodes.size()) < static_cast<double>(kMostNodes))) {
        return tl::unexpected(failure("cuts segments where they cross cells of soil, which makes more than " +
                                      std::to_string(kMostNodes) +
                                      " of them. Use larger cells, or fewer and shorter segments."));
      }
      const double order = traits[i].order > 0.0 ? traits[i].order : from.order;
      node.length = core::length(way) / parts;
      node.rise = core::dot(way, up_) / parts;
      node.axialConductance = traits[i].axial.value_or(keys_.axial.at(order, traits[i].age) * axialUnit_);
      const double radial = traits[i].radial.value_or(keys_.radial.at(order, traits[i].age));
      node.parent = lastOf(plants, from.parent);
      for (double part = 0.0; part < parts; part += 1.0) {
        const Vec3 middle = start + way * ((part + 0.5) / parts);
        node.radialConductivity = heightOf(middle) <= keys_.groundHeight ? radial : 0.0;
        // a width of 0 is drawn as the smallest one
        if (node.radialConductivity > 0.0 && !(node.radius > 0.5 * turtle::kSmallestWidth)) {
          return tl::unexpected(failure("needs the radius of segments, and one of plant " + std::to_string(from.plant) +
                                        " in the soil, drawn by module " + std::to_string(from.module) +
                                        ", has no width. Give the key 'radius', draw roots with a width, or give a "
                                        "file of roots their diameters."));
        }
        node.soilHead = profileAt(heightOf(middle));
        node.demand = part + 1.0 == parts ? traits[i].demand : 0.0;
        plants.nodes.push_back(node);
        plants.middles.push_back(middle);
        plants.axes.push_back(axis);
        node.parent = static_cast<std::uint32_t>(plants.nodes.size() - 1);
      }
    }
    plants.first.push_back(static_cast<std::uint32_t>(plants.nodes.size()));
    return plants;
  }

  /// The first plant whose leaves must give off water that nothing brings.
  [[nodiscard]] std::optional<std::uint32_t> plantWithoutUptake(const std::vector<HydraulicTree::Node>& nodes) const {
    if (keys_.hasCollarHead || keys_.leaves.canClose || hasStomata()) {
      return std::nullopt;
    }
    struct Sums {
      double demand = 0.0;
      bool isTakingUp = false;
    };
    std::vector<Sums> plants;
    for (const HydraulicTree::Node& node : nodes) {
      plants.resize(std::max<std::size_t>(plants.size(), node.plant + 1));
      plants[node.plant].demand += node.demand;
      plants[node.plant].isTakingUp = plants[node.plant].isTakingUp || node.radialConductivity > 0.0;
    }
    const auto dry = std::find_if(plants.begin(), plants.end(),
                                  [](const Sums& plant) { return plant.demand > 0.0 && !plant.isTakingUp; });
    return dry == plants.end() ? std::nullopt : std::optional(static_cast<std::uint32_t>(dry - plants.begin()));
  }

  /// The last node of the tree that belongs to a node of PlantTrees, which another one follows or not.
  [[nodiscard]] static std::uint32_t lastOf(const Plants& plants, std::uint32_t node) {
    return (node + 1 < plants.first.size() ? plants.first[node + 1] : static_cast<std::uint32_t>(plants.nodes.size())) -
           1;
  }

  /// The mean flow out of a plant between two times, length³/day.
  [[nodiscard]] double ofDayCourse(double rate, double from, double until) const {
    if (!keys_.hasDayCourse) {
      return rate;
    }
    const double turn = 2.0 * std::numbers::pi;
    const double days = until - from;
    const double begin = turn * (clock_ + from);
    const double end = turn * (clock_ + until);
    return rate * (1.0 - (core::sin(end) - core::sin(begin)) / (turn * days));
  }

  /// The mean flow that `transpiration` gives between two times, length³/day.
  [[nodiscard]] double transpirationBetween(double from, double until) const {
    // below it times are the same but for rounding
    const double least = 1e-12 * std::max(1.0, until);
    double sum = 0.0;
    double begin = from;
    while (until - begin > least) {
      core::pollWork();
      const double end = std::min(until, begin + std::max(keys_.transpiration.remaining(begin), least));
      sum += ofDayCourse(keys_.transpiration.at(begin), begin, end) * (end - begin);
      begin = end;
    }
    return begin > from ? sum / (begin - from) : keys_.transpiration.at(from);
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> passTime(double timeDays, const PlantTrees& trees,
                                                                 const std::vector<SegmentTraits>& traits,
                                                                 const Plants& plants, PlantWater& water,
                                                                 WaterSums& sums) {
    std::vector<double> wanted;  // the flow that queries at collars ask of each plant, length³/day
    for (std::size_t i = 0; i < trees.nodes().size(); ++i) {
      const PlantTrees::Node& node = trees.nodes()[i];
      wanted.resize(std::max<std::size_t>(wanted.size(), node.plant + 1), 0.0);
      wanted[node.plant] += node.parent == PlantTrees::kNone ? traits[i].demand : 0.0;
    }
    const auto collars = [&](double from, double until) {
      std::vector<Collar> conditions;
      if (hasStomata()) {
        setAir(from, until, traits, plants, water);
      }
      const double ofRows = transpirationBetween(from, until);
      for (const double asked : wanted) {
        conditions.push_back({.hasHead = keys_.hasCollarHead,
                              .head = keys_.collarHead,
                              .flow = ofRows + ofDayCourse(asked, from, until),
                              .lowestHead = keys_.lowestHead});
      }
      return conditions;
    };
    if (soil_) {
      if (auto problem = soil_->problemOfWeather("xylem", days_)) {
        return problem;
      }
      soil_->beginStep(days_);
      RootUptakeFromSoil uptake(water, *soil_, plants.middles, plants.axes, keys_.hasRhizosphere);
      const auto problem = uptake.passTime(days_, keys_.limits, collars, sums);
      if (problem && soil_->areSolutesTooFast()) {
        return failure(soil_->problemOfFlow());
      }
      return problem
                 ? std::optional(failure(*problem + ". Use shorter steps ('longestStep'), larger cells, or a higher "
                                                    "'lowestHead'; leaves that close ('closingHeads') never ask for "
                                                    "more than there is."))
                 : std::nullopt;
    }
    const bool changes = keys_.changesInTime || (hasStomata() && world_.weather);
    const double count = changes ? std::max(1.0, std::ceil(days_ / keys_.limits.longestStep - 1e-9)) : 1.0;
    for (double part = 0.0; part < count; part += 1.0) {
      core::pollWork();
      const double from = timeDays + part / count * days_;
      const auto result = water.solve(collars(from, from + days_ / count));
      if (!result) {
        return failure(
            "finds no heads that fit flow, leaves and vessels: the residual is " + numberText(result.error()) +
            " of the flow. Widen 'closingHeads' (without them leaves may ask for more than there is), or use a "
            "smaller 'vulnerabilityShape' or 'stomataShape'.");
      }
      sums.add(*result, water.nodes(), days_ / count);
    }
    return std::nullopt;
  }

  void answer(const turtle::QueryBatch& queries, const PlantTrees& trees, const Plants& plants,
              const std::vector<std::uint32_t>& nodeOf, const WaterSums& sums, turtle::ReplyBatch& replies) const {
    for (std::size_t query = 0; query < queries.size(); ++query) {
      std::array<double, 16> values{};
      if (nodeOf[query] != PlantTrees::kNone) {
        const PlantTrees::Node& node = trees.nodes()[nodeOf[query]];
        const std::uint32_t end = plants.first[nodeOf[query] + 1];
        values[3] = sums.heads[end - 1] / sums.days;
        for (std::uint32_t i = plants.first[nodeOf[query]]; i < end; ++i) {
          values[4] += (sums.uptakes[i] - sums.given[i]) / sums.days;
          values[8] += fractions_.fractions()[i];
          values[9] += sums.surfaceHeads[i] / sums.days / (end - plants.first[nodeOf[query]]);
        }
        values[5] = sums.collarHeads[node.plant] / sums.days;
        values[6] = sums.collarFlows[node.plant] / sums.days;
        values[7] = fractions_.conductanceOf(node.plant);
        if (hasStomata() && queries.parametersOf(query).size() > 2 && queries.parametersOf(query)[2] > 0.0) {
          const PlantWater::LeafState& leaf = sums.leaves[end - 1];
          values[5] = leaf.conductance / sums.days;
          values[6] = leaf.temperature / sums.days;
          values[7] = leaf.waterPart / sums.days;
          values[8] = keys_.leafGas.growthAt(values[3]);
          values[9] = leaf.latent / sums.days;
        }
      }
      if (soil_) {
        if (const auto cell = soil_->cellOf(queries.position[query])) {
          const RichardsSolver& water = soil_->water();
          const auto contentOf = [&](std::size_t one) { return water.contentOf(one); };
          const Vec3 gradient = soil_->ground().gradientAt(*cell, water, contentOf);
          values[12] = water.contentOf(*cell);
          values[13] = gradient.x;
          values[14] = gradient.y;
          values[15] = gradient.z;
        }
      }
      const std::size_t count = std::min(queries.parametersOf(query).size(), values.size());
      for (std::size_t k = 3; k < count; ++k) {
        if (k != 10 && k != 11) {
          replies.set(queries, query, k, values[k]);
        }
      }
    }
  }

  XylemKeys given_;  // as configured
  XylemKeys keys_;   // with defaults in the world's length unit
  std::optional<SoilBody> soil_;
  PlantTrees trees_;           // of the last step
  UptakeFractions fractions_;  // of the last step
  Vec3 up_{0.0, 1.0, 0.0};
  double days_ = 1.0;       // of a step
  double clock_ = 0.0;      // time of the day at the start, days after midnight
  double axialUnit_ = 1.0;  // the factor of kx
  double metres_ = 1.0;     // of the length unit
  turtle::World world_;
  std::string lengthUnit_ = "m";
};

}  // namespace

ProcessOrErrors makeXylem(const Configuration& configuration) {
  if (auto errors = checkXylem(configuration); !errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  auto soil = readXylemSoil(configuration);
  if (!soil) {
    return tl::unexpected(std::move(soil.error()));
  }
  return std::make_unique<Xylem>(configuration, std::move(*soil));
}

}  // namespace espalier::environment
