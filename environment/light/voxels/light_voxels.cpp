// The process `light-voxels` (docs/environments.md): light in a box of voxels, through a turbid medium of leaves or by
// additive shadow propagation.
//
// The voxels are filled again in every step, so there is no state. "turbid": O(n · directions · voxels on a ray);
// directions that no change touches are kept (turbid_memory.h). "shadow": sums over rectangles make it O(voxels + n ·
// shadowDepth), for any number of casters.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/turtle/field.h"
#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/geometry/grid_keys.h"
#include "environment/geometry/world_up.h"
#include "environment/light/sky.h"
#include "environment/light/voxels/leaf_angles.h"
#include "environment/light/voxels/scattered_light.h"
#include "environment/light/voxels/turbid_memory.h"
#include "environment/light/voxels/voxel_field.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kLightVoxelsSummary =
    "Light in voxels: through a turbid medium of leaves, or by propagated shadows.";
constexpr std::array<std::string_view, 2> kMethods{"turbid", "shadow"};
constexpr std::array<std::string_view, 2> kSkies{"uniform", "overcast"};
constexpr std::array<std::string_view, 2> kLightVoxelsSensors{"horizontal", "fluxes"};
constexpr std::array kLightVoxelsGridSize{40.0, 40.0, 40.0};
constexpr std::array kLightVoxelsPosition{-10.0, 0.0, -10.0};
constexpr std::size_t kLightVoxelsMaximumCellCount = std::size_t{1} << 27;
constexpr std::array kLightVoxelsKeys{
    ConfigurationKey{.name = "method",
                     .kind = KeyKind::Choice,
                     .description = "turbid: Beer-Lambert through the leaf area density; shadow: additive shadow "
                                    "propagation",
                     .defaultText = "turbid",
                     .choices = kMethods},
    gridSizeKey(kLightVoxelsGridSize, "number of voxels along x, y, z"),
    ConfigurationKey{.name = "voxelSize",
                     .description = "side of a voxel, which is a cube",
                     .unit = "length",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 0.5},
    positionKey(kLightVoxelsPosition),
    ConfigurationKey{.name = "periodic",
                     .kind = KeyKind::Boolean,
                     .description = "the box repeats itself without end in the horizontal directions: a stand"},
    ConfigurationKey{.name = "sky",
                     .kind = KeyKind::Choice,
                     .description = "turbid: brightness of the sky; overcast is (1 + 2 cos θ)/3",
                     .defaultText = "overcast",
                     .choices = kSkies},
    ConfigurationKey{.name = "zenithAngles",
                     .kind = KeyKind::Integer,
                     .description = "turbid: rings of the sky's directions, at Gauss points of cos θ",
                     .minimum = 1.0,
                     .maximum = 64.0,
                     .defaultNumber = 6.0},
    ConfigurationKey{.name = "azimuthAngles",
                     .kind = KeyKind::Integer,
                     .description = "turbid: directions in each ring",
                     .minimum = 1.0,
                     .maximum = 256.0,
                     .defaultNumber = 8.0},
    ConfigurationKey{.name = "directions",
                     .kind = KeyKind::Rows,
                     .description =
                         "turbid: instead of a sky, directions x, y, z towards the light and the part of the "
                         "irradiance of a horizontal plane that comes from there",
                     .minimumCount = 4,
                     .maximumCount = 4},
    ConfigurationKey{.name = "irradiance",
                     .description = "turbid: of a horizontal plane in the open; 1: all light is relative",
                     .unit = "any",
                     .minimum = 0.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{
        .name = "leafAngles",
        .kind = KeyKind::Choice,
        .description = "turbid: distribution of the leaf normals (de Wit 1965; ellipsoidal: Campbell 1986)",
        .defaultText = "spherical",
        .choices = kLeafAngleNames},
    ConfigurationKey{.name = "ellipsoidRatio",
                     .description =
                         "turbid, ellipsoidal: horizontal over vertical axis χ; above 1 the leaves are rather "
                         "horizontal",
                     .minimum = 0.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "absorptance",
                     .description = "turbid: part of the light that a leaf absorbs",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "scattering",
                     .kind = KeyKind::Boolean,
                     .description = "turbid: leaves scatter light with reflectance and transmittance, and the ground "
                                    "below the box reflects it"},
    ConfigurationKey{.name = "reflectance",
                     .description = "scattering: part of the light that leaves reflect",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumber = 0.08},
    ConfigurationKey{.name = "transmittance",
                     .description = "scattering: part of the light that passes leaves",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumber = 0.05},
    ConfigurationKey{.name = "groundReflectance",
                     .description = "scattering: part of the light that the ground reflects",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumber = 0.1},
    ConfigurationKey{.name = "remainder",
                     .description = "scattering: part of the light that may be left when it ends",
                     .minimum = 0.0,
                     .maximum = 0.1,
                     .isMinimumExclusive = true,
                     .defaultNumber = 1e-4},
    ConfigurationKey{.name = "sensor",
                     .kind = KeyKind::Choice,
                     .description = "scattering: the answer to a query with a leaf area of 0: light on a horizontal "
                                    "plane, or the fluxes of the stand",
                     .defaultText = "horizontal",
                     .choices = kLightVoxelsSensors},
    ConfigurationKey{.name = "leafAreaDensity",
                     .kind = KeyKind::Numbers,
                     .description =
                         "turbid: leaf area per volume of every voxel, x fastest, then y, then z, of plants that are "
                         "not simulated; a \"fieldFile\" brings it; none: there are none",
                     .unit = "1/length",
                     .minimum = 0.0},
    ConfigurationKey{.name = "fullLight",
                     .description = "shadow: C, the light without shadow",
                     .minimum = 0.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "shadowStrength",
                     .description = "shadow: a, the shadow in the own voxel",
                     .minimum = 0.0,
                     .defaultNumber = 0.2},
    ConfigurationKey{.name = "shadowBase",
                     .description = "shadow: b, by which the shadow is weaker with every voxel further down",
                     .minimum = 1.0,
                     .defaultNumber = 2.0},
    ConfigurationKey{.name = "shadowDepth",
                     .kind = KeyKind::Integer,
                     .description = "shadow: how many voxels down it reaches",
                     .minimum = 0.0,
                     .maximum = 1000.0,
                     .defaultNumber = 8.0},
};

/// A direction of the light with its extinction in the medium.
struct Beam {
  Vec3 direction;
  double weight = 0.0;      // part of the irradiance of a horizontal plane
  double extinction = 0.0;  // √α G, per leaf area density and length
  double perLeaf = 0.0;     // √α G/cos θ times the weight
};

class LightVoxels final : public turtle::EnvironmentProcess {
 public:
  LightVoxels(const VoxelField::Shape& shape, const Configuration& configuration)
      : shape_(shape),
        configuration_(configuration),
        isTurbid_(configuration.text("method") == "turbid"),
        isFluxSensor_(configuration.text("sensor") == "fluxes"),
        irradiance_(configuration.number("irradiance")),
        fullLight_(configuration.number("fullLight")),
        strength_(configuration.number("shadowStrength")) {
    const double base = configuration.number("shadowBase");
    for (std::int64_t q = 0; q <= configuration.integer("shadowDepth"); ++q) {
      shadowOf_.push_back(strength_ * core::pow(base, -static_cast<double>(q)));
    }
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    const std::string perLength = "1/" + lengthUnit_;
    const std::string area = lengthUnit_ + "^2";
    turtle::EnvironmentDescription description{
        .name = "light-voxels",
        .summary = std::string(kLightVoxelsSummary),
        .needs = {.position = true, .parameters = true},
        .inputs = {{isTurbid_ ? "leafArea" : "castsShadow", isTurbid_ ? area : "1", ""}},
        .outputs = {{"light", "1", ""},
                    {"directionX", perLength, ""},
                    {"directionY", perLength, ""},
                    {"directionZ", perLength, ""}},
        .isStateful = false};
    if (isTurbid_) {
      description.outputs.push_back({"absorbed", "1", ""});
    }
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto axes = gridAxesOf("light-voxels", context.world);
    if (!axes) {
      return axes.error();
    }
    lengthUnit_ = context.world.lengthUnit;
    up_ = core::normalised(context.world.up);
    scattered_.reset();
    field_ = VoxelField(shape_, *axes);
    memory_.clear();
    background_.clear();
    if (const auto& densities = configuration_.numbers("leafAreaDensity"); !densities.empty() && isTurbid_) {
      background_.resize(field_.values().size());
      std::size_t number = 0;
      eachVoxel(
          [&](const Vec3& middle) { background_[*field_.indexOf(field_.voxelOf(middle))] = densities[number++]; });
    }
    return isTurbid_ ? makeBeams(core::normalised(context.world.up)) : std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    fill(queries);
    if (isTurbid_) {
      memory_.begin(field_, shape_, directions_);
      scatter();
    } else {
      field_.sumLayers();
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const std::size_t count = queries.parametersOf(query).size();
      if (count > 0 && isFluxSensor_ && !(queries.parametersOf(query)[0] > 0.0)) {
        answerFluxes(queries, query, count, replies);
      } else if (count > 0 && isTurbid_) {
        answerTurbid(queries, query, count, replies);
      } else if (count > 0) {
        answerShadow(queries, query, count, replies);
      }
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

  [[nodiscard]] std::vector<turtle::Field> fields() const override {
    turtle::Field light{"light", "1", {}, shape_.position, {}, {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      light.cells[axis] = static_cast<std::size_t>(shape_.cells[axis]);
    }
    light.cellSize = {shape_.voxelSize, shape_.voxelSize, shape_.voxelSize};
    turtle::Field content = light;
    content.name = isTurbid_ ? "leafAreaDensity" : "casters";
    content.unit = isTurbid_ ? "1/" + lengthUnit_ : "1";
    eachVoxel([&](const Vec3& middle) {
      content.values.push_back(field_.values()[*field_.indexOf(field_.voxelOf(middle))]);
      light.values.push_back(isTurbid_ ? irradiance_ * lightAt(middle) : std::max(fullLight_ - shadowAt(middle), 0.0));
    });
    std::vector<turtle::Field> fields{std::move(light), std::move(content)};
    if (scattered_) {
      addFluxFields(fields);
    }
    return fields;
  }

 private:
  /// The middles of all voxels, x fastest, then y, then z.
  template <typename Work>
  void eachVoxel(const Work& work) const {
    for (std::int64_t z = 0; z < shape_.cells[2]; ++z) {
      for (std::int64_t y = 0; y < shape_.cells[1]; ++y) {
        for (std::int64_t x = 0; x < shape_.cells[0]; ++x) {
          const Vec3 middle{static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5};
          work(shape_.position + middle * shape_.voxelSize);
        }
      }
    }
  }

  /// Scatters the light of this step.
  void scatter() {
    scattered_.reset();
    if (!configuration_.flag("scattering")) {
      return;
    }
    std::vector<ScatteredLight::Beam> beams;
    for (const Beam& beam : beams_) {
      beams.push_back({beam.direction, beam.weight, beam.extinction});
    }
    const ScatteredLight::Options options{.leafAngles = leafAngles(),
                                          .ellipsoidRatio = configuration_.number("ellipsoidRatio"),
                                          .reflectance = configuration_.number("reflectance"),
                                          .transmittance = configuration_.number("transmittance"),
                                          .groundReflectance = configuration_.number("groundReflectance"),
                                          .remainder = configuration_.number("remainder"),
                                          .zenithAngles = static_cast<int>(configuration_.integer("zenithAngles")),
                                          .azimuthAngles = static_cast<int>(configuration_.integer("azimuthAngles"))};
    scattered_.emplace(field_, options, up_, beams);
  }

  /// The fluxes of the stand as fields of one cell over the box.
  void addFluxFields(std::vector<turtle::Field>& fields) const {
    const ScatteredLight::Fluxes& fluxes = scattered_->fluxes();
    turtle::Field field{"", "1", {}, shape_.position, {}, {}};
    const auto side = [&](std::size_t axis) { return static_cast<double>(shape_.cells[axis]) * shape_.voxelSize; };
    field.cells = {1, 1, 1};
    field.cellSize = {side(0), side(1), side(2)};
    for (const auto& [name, value] : {std::pair{"incoming", fluxes.incoming},
                                      {"leavingUp", fluxes.up},
                                      {"leavingAside", fluxes.aside},
                                      {"downOnGround", fluxes.down},
                                      {"absorbedByPlants", fluxes.byPlants},
                                      {"absorbedByGround", fluxes.byGround}}) {
      field.name = name;
      field.values = {value * irradiance_};
      fields.push_back(field);
    }
  }

  /// Scattered light from above at a place; nothing outside the box.
  [[nodiscard]] double scatteredAt(const Vec3& place) const {
    const auto voxel = scattered_ ? field_.indexOf(field_.voxelOf(place)) : std::nullopt;
    return voxel ? scattered_->downAt(*voxel) : 0.0;
  }

  [[nodiscard]] LeafAngles leafAngles() const {
    return static_cast<LeafAngles>(
        std::find(kLeafAngleNames.begin(), kLeafAngleNames.end(), configuration_.text("leafAngles")) -
        kLeafAngleNames.begin());
  }

  [[nodiscard]] static turtle::EnvironmentError fromBelow() {
    return {
        "Environment 'light-voxels' takes light from above only: in 'directions' every direction must be above the "
        "horizon and no weight below 0.",
        false};
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> makeBeams(const Vec3& up) {
    std::vector<LightDirection> lights;
    for (const auto& row : configuration_.rows("directions")) {
      if (row[3] < 0.0) {
        return fromBelow();
      }
      lights.push_back({{row[0], row[1], row[2]}, row[3]});
    }
    if (lights.empty()) {
      const SkyKind kind = configuration_.text("sky") == "uniform" ? SkyKind::Uniform : SkyKind::Overcast;
      lights = skyRings(kind, static_cast<int>(configuration_.integer("zenithAngles")),
                        static_cast<int>(configuration_.integer("azimuthAngles")), up, up);
    } else {
      normaliseLight(lights);
    }
    const LeafAngles angles = leafAngles();
    const double dimming = std::sqrt(configuration_.number("absorptance"));
    beams_.clear();
    directions_.clear();
    for (const LightDirection& light : lights) {
      const double cosine = core::dot(light.direction, up);
      if (!(cosine > 1e-6)) {
        return fromBelow();
      }
      directions_.push_back(light.direction);
      const double projection = leafProjection(angles, cosine, configuration_.number("ellipsoidRatio"));
      beams_.push_back(
          {light.direction, light.weight, dimming * projection, dimming * projection / cosine * light.weight});
    }
    return std::nullopt;
  }

  /// The contribution of the organs to their voxels: leaf area per volume, or a number of casters.
  void fill(const turtle::QueryBatch& queries) {
    std::fill(field_.values().begin(), field_.values().end(), 0.0);
    std::vector<std::pair<std::size_t, double>> given;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      if (!parameters.empty() && parameters[0] > 0.0) {
        if (const auto voxel = field_.indexOf(field_.voxelOf(queries.position[query]))) {
          given.emplace_back(*voxel, parameters[0]);
        }
      }
    }
    // sorted, the sums of a voxel are the same for any order of queries
    std::sort(given.begin(), given.end());
    for (const auto& [voxel, amount] : given) {
      field_.values()[voxel] += amount;
    }
    if (isTurbid_) {
      const double volume = shape_.voxelSize * shape_.voxelSize * shape_.voxelSize;
      for (const auto& entry : given) {
        // once for each voxel: the first of its entries
        if (&entry == given.data() || (&entry - 1)->first != entry.first) {
          field_.values()[entry.first] /= volume;
        }
      }
      for (std::size_t voxel = 0; voxel < background_.size(); ++voxel) {
        field_.values()[voxel] += background_[voxel];
      }
    }
  }

  void answerTurbid(const turtle::QueryBatch& queries, std::size_t query, std::size_t count,
                    turtle::ReplyBatch& replies) {
    const Vec3& place = queries.position[query];
    const std::size_t axes = std::min<std::size_t>(count - 1, 3);
    const TurbidMemory::Place rays = memory_.lookAt(place, 1 + 2 * axes);
    // the place itself, and its neighbours along x, y and z
    const double h = shape_.voxelSize;
    const std::array<Vec3, 3> steps{Vec3{h, 0, 0}, Vec3{0, h, 0}, Vec3{0, 0, h}};
    std::array<double, TurbidMemory::kMostRays> light{};
    double absorbed = 0.0;
    for (std::size_t ray = 0; ray < 1 + 2 * axes; ++ray) {
      const Vec3 from = ray == 0 ? place : ray % 2 == 1 ? place + steps[(ray - 1) / 2] : place - steps[(ray - 1) / 2];
      const std::size_t first = ray * beams_.size();
      for (std::size_t k = 0; k < beams_.size(); ++k) {
        const Beam& beam = beams_[k];
        const double part = TurbidMemory::isTouched(rays, k)
                                ? core::exp(-beam.extinction * field_.integralAlong(from, beam.direction))
                                : rays.before[first + k];
        rays.parts[first + k] = part;
        light[ray] += beam.weight * part;
        absorbed += ray == 0 ? beam.perLeaf * part : 0.0;
      }
      light[ray] += scatteredAt(from);
    }
    if (scattered_) {
      absorbed *= 1.0 - configuration_.number("reflectance") - configuration_.number("transmittance");
      const auto voxel = field_.indexOf(field_.voxelOf(place));
      absorbed += voxel ? scattered_->absorbedAt(*voxel) : 0.0;
    }
    replies.set(queries, query, 0, irradiance_ * light[0]);
    for (std::size_t k = 0; k < axes; ++k) {
      replies.set(queries, query, 1 + k, irradiance_ * ((light[1 + 2 * k] - light[2 + 2 * k]) / (2.0 * h)));
    }
    if (count > 4) {
      replies.set(queries, query, 4, irradiance_ * absorbed);
    }
  }

  /// What leaves upwards, comes down on the ground, is absorbed by plants and by the ground, on a unit of the box.
  void answerFluxes(const turtle::QueryBatch& queries, std::size_t query, std::size_t count,
                    turtle::ReplyBatch& replies) const {
    const ScatteredLight::Fluxes& fluxes = scattered_->fluxes();
    const std::array<double, 4> values{fluxes.up, fluxes.down, fluxes.byPlants, fluxes.byGround};
    for (std::size_t k = 0; k < std::min(count, values.size()); ++k) {
      replies.set(queries, query, k, irradiance_ * values[k]);
    }
  }

  [[nodiscard]] double lightAt(const Vec3& place) const {
    double light = scatteredAt(place);
    for (const Beam& beam : beams_) {
      light += beam.weight * core::exp(-beam.extinction * field_.integralAlong(place, beam.direction));
    }
    return light;
  }

  void answerShadow(const turtle::QueryBatch& queries, std::size_t query, std::size_t count,
                    turtle::ReplyBatch& replies) const {
    const Vec3& place = queries.position[query];
    const bool isInside = field_.indexOf(field_.voxelOf(place)).has_value();
    const double own = isInside ? strength_ * std::max(queries.parametersOf(query)[0], 0.0) : 0.0;
    replies.set(queries, query, 0, std::max(fullLight_ - shadowAt(place) + own, 0.0));
    const double h = shape_.voxelSize;
    const std::array<Vec3, 3> steps{Vec3{h, 0, 0}, Vec3{0, h, 0}, Vec3{0, 0, h}};
    for (std::size_t k = 0; k < std::min<std::size_t>(count - 1, 3); ++k) {
      replies.set(queries, query, 1 + k, (shadowAt(place - steps[k]) - shadowAt(place + steps[k])) / (2.0 * h));
    }
  }

  [[nodiscard]] double shadowAt(const Vec3& place) const {
    VoxelField::Voxel voxel = field_.voxelOf(place);
    double shadow = 0.0;
    for (std::size_t q = 0; q < shadowOf_.size(); ++q, ++voxel.layer) {
      shadow += shadowOf_[q] * field_.boxSum(voxel, static_cast<std::int64_t>(q));
    }
    return shadow;
  }

  VoxelField::Shape shape_;
  Configuration configuration_;
  bool isTurbid_;
  bool isFluxSensor_;
  double irradiance_;
  double fullLight_;
  double strength_;
  std::vector<double> shadowOf_;  // of one caster by tiers below it (shadowDepth + 1)
  std::vector<Beam> beams_;
  std::vector<Vec3> directions_;  // of the beams
  Vec3 up_{0, 1, 0};
  std::optional<ScatteredLight> scattered_;  // of this step; nothing: light is not scattered
  TurbidMemory memory_;                      // the replies do not depend on it
  std::vector<double> background_;           // leaf area density that is always there, as in field_; empty: none
  VoxelField field_;                         // leaf area density, or number of casters
  std::string lengthUnit_ = "m";
};

ProcessOrErrors makeLightVoxels(const Configuration& configuration) {
  const auto cells = cellsOf(configuration);
  if (auto problem = tooManyCells("light-voxels", cells, kLightVoxelsMaximumCellCount)) {
    return tl::unexpected(std::vector{std::move(*problem)});
  }
  const std::size_t cellCount = cells[0] * cells[1] * cells[2];
  const std::size_t densities = configuration.numbers("leafAreaDensity").size();
  if (densities != 0 && densities != cellCount) {
    return refuse(
        "light-voxels",
        "'leafAreaDensity' has " + std::to_string(densities) + " numbers for " + std::to_string(cellCount) + " voxels",
        "give one for every voxel, or none");
  }
  if (configuration.flag("scattering")) {
    if (configuration.text("method") != "turbid") {
      return refuse("light-voxels", "'scattering' needs the method turbid", "leave one of the two out");
    }
    if (configuration.number("absorptance") != 1.0) {
      return refuse("light-voxels", "'absorptance' and 'scattering' both say what leaves take",
                    "leave 'absorptance' out: leaves take 1 - reflectance - transmittance");
    }
    if (configuration.number("reflectance") + configuration.number("transmittance") > 1.0) {
      return refuse("light-voxels", "'reflectance' and 'transmittance' add up to more than 1",
                    "leaves cannot scatter more light than they get");
    }
  }
  if (configuration.text("sensor") == "fluxes" && !configuration.flag("scattering")) {
    return refuse("light-voxels", "a 'sensor' of fluxes needs 'scattering'", "write \"scattering\": true");
  }
  const VoxelField::Shape shape{
      vectorOf(configuration, "position"),
      {static_cast<std::int64_t>(cells[0]), static_cast<std::int64_t>(cells[1]), static_cast<std::int64_t>(cells[2])},
      configuration.number("voxelSize"),
      configuration.flag("periodic")};
  return std::make_unique<LightVoxels>(shape, configuration);
}

}  // namespace

extern constinit const ProcessEntry kLightVoxelsProcess{
    .name = "light-voxels",
    .summary = kLightVoxelsSummary,
    .source =
        "Monsi & Saeki 1953; Ross 1981; Goudriaan 1977; Campbell 1986; Carlson & Lathrop 1968; Palubicki et al. "
        "2009, Self-organizing tree models for image synthesis",
    .keys = kLightVoxelsKeys,
    .make = makeLightVoxels};

}  // namespace espalier::environment
