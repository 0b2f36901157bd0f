// The process `light-voxels` (docs/environments.md): light in a box of voxels, through a turbid medium of leaves or by
// additive shadow propagation.
//
// The voxels are filled again in every step, so there is no state. "turbid": O(n · directions · voxels on a ray);
// directions that no change touches are kept (turbid_memory.h), but not those of a sun that moves. "shadow": sums over
// rectangles make it O(voxels + n · shadowDepth), for any number of casters.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/core/elementary.h"
#include "engine/core/work_meter.h"
#include "engine/turtle/field.h"
#include "environment/base/replies.h"
#include "environment/geometry/box_note.h"
#include "environment/geometry/grid_keys.h"
#include "environment/geometry/world_up.h"
#include "environment/light/light_bands.h"
#include "environment/light/voxels/leaf_angles.h"
#include "environment/light/voxels/scattered_light.h"
#include "environment/light/voxels/turbid_memory.h"
#include "environment/light/voxels/voxel_field.h"
#include "environment/light/voxels/voxel_keys.h"
#include "environment/light/voxels/voxel_sources.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::size_t kAnswers = 5;  // to a query, of each band

/// The common data of bands with leaves of the same absorptance: extinction of the light of each source.
struct Medium {
  double dimming = 1.0;             // √α (Goudriaan 1977); with scattering 1
  std::vector<double> extinctions;  // √α G, per leaf area density and length (sources)
  std::vector<double> perLeaf;      // √α G/cos θ times the weight (sources)
};

class LightVoxels final : public turtle::EnvironmentProcess {
 public:
  LightVoxels(const VoxelField::Shape& shape, const Configuration& configuration)
      : shape_(shape),
        configuration_(configuration),
        isTurbid_(configuration.text("method") == "turbid"),
        isFluxSensor_(configuration.text("sensor") == "fluxes"),
        unit_(configuration.text("unit")),
        fullLight_(configuration.number("fullLight")),
        strength_(configuration.number("shadowStrength")),
        sources_(configuration) {
    const double base = configuration.number("shadowBase");
    for (std::int64_t q = 0; q <= configuration.integer("shadowDepth"); ++q) {
      shadowOf_.push_back(strength_ * core::pow(base, -static_cast<double>(q)));
    }
    if (isTurbid_) {
      makeMedia();
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
        .outputs = {},
        .isStateful = false};
    const std::string unit = lightUnit();
    const std::string gradient = unit == "1" ? perLength : unit + "/" + lengthUnit_;
    for (std::size_t band = 0; band < std::max<std::size_t>(bands_.size(), 1); ++band) {
      const std::string number = numberOf(band);
      description.outputs.push_back({"light" + number, unit, ""});
      for (const char* name : {"directionX", "directionY", "directionZ"}) {
        description.outputs.push_back({name + number, gradient, ""});
      }
      if (isTurbid_) {
        description.outputs.push_back({"absorbed" + number, unit, ""});
      }
    }
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto axes = gridAxesOf("light-voxels", context.world);
    if (!axes) {
      return axes.error();
    }
    lengthUnit_ = context.world.lengthUnit;
    if (const std::string unit = configuration_.text("fieldUnit"); !unit.empty() && unit != "1/" + lengthUnit_) {
      return turtle::EnvironmentError{"Environment 'light-voxels' begins with leaf area densities in '" + unit +
                                          "', and the world's unit of length is '" + lengthUnit_ +
                                          "'. Give the densities in 1/" + lengthUnit_ + R"(, with "fieldUnit": "1/)" +
                                          lengthUnit_ + R"(", and the places of their voxels in )" + lengthUnit_ + ".",
                                      false};
    }
    up_ = core::normalised(context.world.up);
    scattered_.clear();
    field_ = VoxelField(shape_, *axes);
    memory_.clear();
    background_.clear();
    if (const auto& densities = configuration_.numbers("leafAreaDensity"); !densities.empty() && isTurbid_) {
      background_.resize(field_.values().size());
      std::size_t number = 0;
      eachVoxel(
          [&](const Vec3& middle) { background_[*field_.indexOf(field_.voxelOf(middle))] = densities[number++]; });
    }
    if (!isTurbid_) {
      return std::nullopt;
    }
    if (const auto problem = sources_.open(context.world)) {
      return turtle::EnvironmentError{"Environment 'light-voxels' " + *problem, false};
    }
    keptDirections_.clear();
    for (std::size_t i = 0; i < media_.size() * sources_.fixedCount(); ++i) {
      keptDirections_.push_back(sources_.all()[i % sources_.fixedCount()].direction);
    }
    dim();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    if (isTurbid_) {
      if (const auto problem = sources_.begin(queries.timeDays)) {
        return turtle::EnvironmentError{"Environment 'light-voxels' " + *problem, false};
      }
      dim();
    }
    fill(queries);
    if (isTurbid_) {
      memory_.begin(field_, shape_, keptDirections_);
      scatter();
    } else {
      field_.sumLayers();
    }
    for (std::size_t query = 0; query < queries.size(); ++query) {
      core::pollWork();
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
    noteIfAllAreOutside("light-voxels", field_.box(), lengthUnit_, queries, replies);
    return std::nullopt;
  }

  [[nodiscard]] std::vector<turtle::Field> fields() const override {
    turtle::Field empty{"", "1", {}, shape_.position, {}, {}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      empty.cells[axis] = static_cast<std::size_t>(shape_.cells[axis]);
    }
    empty.cellSize = {shape_.voxelSize, shape_.voxelSize, shape_.voxelSize};
    std::vector<turtle::Field> fields;
    for (std::size_t band = 0; band < std::max<std::size_t>(bands_.size(), 1); ++band) {
      turtle::Field light = empty;
      light.name = "light" + numberOf(band);
      light.unit = lightUnit();
      eachVoxel([&](const Vec3& middle) {
        light.values.push_back(isTurbid_ ? scaleOf(band) * lightAt(middle, band)
                                         : std::max(fullLight_ - shadowAt(middle), 0.0));
      });
      fields.push_back(std::move(light));
    }
    turtle::Field content = empty;
    content.name = isTurbid_ ? "leafAreaDensity" : "casters";
    content.unit = isTurbid_ ? "1/" + lengthUnit_ : "1";
    eachVoxel([&](const Vec3& middle) {
      content.values.push_back(field_.values()[*field_.indexOf(field_.voxelOf(middle))]);
    });
    fields.push_back(std::move(content));
    for (std::size_t band = 0; band < scattered_.size(); ++band) {
      addFluxFields(band, fields);
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
          core::pollWork();
          const Vec3 middle{static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5};
          work(shape_.position + middle * shape_.voxelSize);
        }
      }
    }
  }

  /// The bands, and a medium for each absorptance among them.
  void makeMedia() {
    const bool isScattering = configuration_.flag("scattering");
    const bool isFromSpectra =
        !configuration_.rows("bandLimits").empty() && !configuration_.isGiven("absorptance") && !isScattering;
    bands_ = bandsOf(configuration_);
    for (std::size_t band = 0; band < bands_.size(); ++band) {
      const double absorptance = isFromSpectra ? 1.0 - bands_[band].reflectance - bands_[band].transmittance
                                               : numberOfBand(configuration_.numbers("absorptance"), band);
      const double dimming = std::sqrt(std::max(absorptance, 0.0));
      const auto same = std::find_if(media_.begin(), media_.end(), [&](const auto& m) { return m.dimming == dimming; });
      mediumOf_.push_back(static_cast<std::size_t>(same - media_.begin()));
      if (same == media_.end()) {
        media_.push_back({dimming, {}, {}});
      }
    }
  }

  /// Sets the extinctions of the sources of this step.
  void dim() {
    for (Medium& medium : media_) {
      medium.extinctions.clear();
      medium.perLeaf.clear();
      for (const VoxelSources::Source& source : sources_.all()) {
        const double extinction = medium.dimming * source.projection;
        medium.extinctions.push_back(extinction);
        medium.perLeaf.push_back(extinction / source.cosine * source.weight);
      }
    }
  }

  /// Of a band in names: nothing when there is only one.
  [[nodiscard]] std::string numberOf(std::size_t band) const {
    return bands_.size() <= 1 ? std::string() : std::to_string(band + 1);
  }
  [[nodiscard]] std::string lightUnit() const {
    if (!isTurbid_ || unit_ == "relative") {
      return "1";
    }
    return unit_ == "umol" ? "umol/(m^2 s)" : unit_ == "mol" ? "mol/(m^2 day)" : sources_.isInWatts() ? "W/m^2" : "1";
  }
  /// The factor of the relative light of a band in replies.
  [[nodiscard]] double scaleOf(std::size_t band) const {
    if (unit_ == "relative") {
      return sources_.irradiance();
    }
    const double watts = sources_.irradiance() * bands_[band].part;
    return unit_ == "W"      ? watts
           : unit_ == "umol" ? watts * bands_[band].photonsPerJoule
                             : watts * (bands_[band].photonsPerJoule * kMolesPerDay);
  }

  /// Scatters the light of this step.
  void scatter() {
    scattered_.clear();
    if (!configuration_.flag("scattering")) {
      return;
    }
    std::vector<ScatteredLight::Beam> beams;
    for (const VoxelSources::Source& source : sources_.all()) {
      beams.push_back({source.direction, source.weight, source.projection});
    }
    for (const LightBand& band : bands_) {
      const ScatteredLight::Options options{.leafAngles = leafAnglesOf(configuration_.text("leafAngles")),
                                            .ellipsoidRatio = configuration_.number("ellipsoidRatio"),
                                            .reflectance = band.reflectance,
                                            .transmittance = band.transmittance,
                                            .groundReflectance = band.groundReflectance,
                                            .remainder = configuration_.number("remainder"),
                                            .zenithAngles = static_cast<int>(configuration_.integer("zenithAngles")),
                                            .azimuthAngles = static_cast<int>(configuration_.integer("azimuthAngles"))};
      scattered_.emplace_back(field_, options, up_, beams);
    }
  }

  /// The fluxes of the stand as fields of one cell over the box.
  void addFluxFields(std::size_t band, std::vector<turtle::Field>& fields) const {
    const ScatteredLight::Fluxes& fluxes = scattered_[band].fluxes();
    turtle::Field field{"", lightUnit(), {}, shape_.position, {}, {}};
    const auto side = [&](std::size_t axis) { return static_cast<double>(shape_.cells[axis]) * shape_.voxelSize; };
    field.cells = {1, 1, 1};
    field.cellSize = {side(0), side(1), side(2)};
    for (const auto& [name, value] : {std::pair{"incoming", fluxes.incoming},
                                      {"leavingUp", fluxes.up},
                                      {"leavingAside", fluxes.aside},
                                      {"downOnGround", fluxes.down},
                                      {"absorbedByPlants", fluxes.byPlants},
                                      {"absorbedByGround", fluxes.byGround}}) {
      field.name = name + numberOf(band);
      field.values = {value * scaleOf(band)};
      fields.push_back(field);
    }
  }

  /// Scattered light from above at a place; nothing outside the box.
  [[nodiscard]] double scatteredAt(const Vec3& place, std::size_t band) const {
    const auto voxel = scattered_.empty() ? std::nullopt : field_.indexOf(field_.voxelOf(place));
    return voxel ? scattered_[band].downAt(*voxel) : 0.0;
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
    const std::size_t rays = 1 + 2 * axes;
    // the place itself, and its neighbours along x, y and z
    const double h = shape_.voxelSize;
    const std::array<Vec3, 3> steps{Vec3{h, 0, 0}, Vec3{0, h, 0}, Vec3{0, 0, h}};
    std::array<Vec3, TurbidMemory::kMostRays> from{place};
    for (std::size_t ray = 1; ray < rays; ++ray) {
      from[ray] = ray % 2 == 1 ? place + steps[(ray - 1) / 2] : place - steps[(ray - 1) / 2];
    }
    const Passed& passed = passedTo(place, std::span(from).first(rays));
    const std::size_t bands = std::min(bands_.size(), (count + kAnswers - 1) / kAnswers);
    for (std::size_t band = 0; band < bands; ++band) {
      const std::size_t medium = mediumOf_[band];
      const double scale = scaleOf(band);
      const auto answer = [&](std::size_t k, double value) {
        if (kAnswers * band + k < count) {
          replies.set(queries, query, kAnswers * band + k, value);
        }
      };
      const auto light = [&](std::size_t ray) {
        return passed.light[ray * media_.size() + medium] + scatteredAt(from[ray], band);
      };
      double absorbed = passed.absorbed[medium];
      if (!scattered_.empty()) {
        absorbed *= 1.0 - bands_[band].reflectance - bands_[band].transmittance;
        const auto voxel = field_.indexOf(field_.voxelOf(place));
        absorbed += voxel ? scattered_[band].absorbedAt(*voxel) : 0.0;
      }
      answer(0, scale * light(0));
      for (std::size_t k = 0; k < axes; ++k) {
        answer(1 + k, scale * ((light(1 + 2 * k) - light(2 + 2 * k)) / (2.0 * h)));
      }
      answer(4, scale * absorbed);
    }
  }

  /// Light that passes the leaves: of points (rays, media), and what a unit of leaf area absorbs at the first (media).
  struct Passed {
    std::vector<double> light;
    std::vector<double> absorbed;
  };
  const Passed& passedTo(const Vec3& place, std::span<const Vec3> points) {
    const std::size_t fixed = sources_.fixedCount();
    const std::size_t count = sources_.all().size();
    Passed& passed = passed_;
    passed.light.assign(points.size() * media_.size(), 0.0);
    passed.absorbed.assign(media_.size(), 0.0);
    // last of all: a place that is entered must be filled, also when there is no memory
    const TurbidMemory::Place kept = memory_.lookAt(place, points.size());
    for (std::size_t ray = 0; ray < points.size(); ++ray) {
      for (std::size_t k = 0; k < count; ++k) {
        const VoxelSources::Source& source = sources_.all()[k];
        double integral = -1.0;  // not known
        for (std::size_t m = 0; m < media_.size(); ++m) {
          const std::size_t own = m * fixed + k;  // in the memory
          const std::size_t slot = ray * media_.size() * fixed + own;
          double part = 0.0;
          if (k < fixed && !TurbidMemory::isTouched(kept, own)) {
            part = kept.before[slot];
          } else {
            integral = integral < 0.0 ? field_.integralAlong(points[ray], source.direction) : integral;
            part = core::exp(-media_[m].extinctions[k] * integral);
          }
          if (k < fixed) {
            kept.parts[slot] = part;
          }
          passed.light[ray * media_.size() + m] += source.weight * part;
          passed.absorbed[m] += ray == 0 ? media_[m].perLeaf[k] * part : 0.0;
        }
      }
    }
    return passed;
  }

  /// Of each band what leaves upwards, comes down on the ground, is absorbed by plants and by the ground, and comes in,
  /// on a unit of the box.
  void answerFluxes(const turtle::QueryBatch& queries, std::size_t query, std::size_t count,
                    turtle::ReplyBatch& replies) const {
    for (std::size_t k = 0; k < std::min(count, kAnswers * bands_.size()); ++k) {
      const std::size_t band = k / kAnswers;
      const ScatteredLight::Fluxes& fluxes = scattered_[band].fluxes();
      const std::array<double, kAnswers> values{fluxes.up, fluxes.down, fluxes.byPlants, fluxes.byGround,
                                                fluxes.incoming};
      replies.set(queries, query, k, scaleOf(band) * values[k % kAnswers]);
    }
  }

  [[nodiscard]] double lightAt(const Vec3& place, std::size_t band) const {
    double light = scatteredAt(place, band);
    const Medium& medium = media_[mediumOf_[band]];
    for (std::size_t k = 0; k < sources_.all().size(); ++k) {
      const VoxelSources::Source& source = sources_.all()[k];
      light += source.weight * core::exp(-medium.extinctions[k] * field_.integralAlong(place, source.direction));
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
  std::string unit_;  // W, umol, mol, relative
  double fullLight_;
  double strength_;
  std::vector<double> shadowOf_;  // of one caster by tiers below it (shadowDepth + 1)
  std::vector<LightBand> bands_;  // none with the method shadow
  std::vector<Medium> media_;
  std::vector<std::size_t> mediumOf_;  // of each band
  VoxelSources sources_;
  std::vector<Vec3> keptDirections_;  // of the fixed sources, once for each medium
  Vec3 up_{0, 1, 0};
  std::vector<ScatteredLight> scattered_;  // of this step by band; none: light is not scattered
  TurbidMemory memory_;                    // the replies do not depend on it
  Passed passed_;                          // of the last query
  std::vector<double> background_;         // leaf area density that is always there, as in field_; empty: none
  VoxelField field_;                       // leaf area density, or number of casters
  std::string lengthUnit_ = "m";
};

}  // namespace

ProcessOrErrors makeLightVoxels(const Configuration& configuration) {
  if (auto errors = checkLightVoxels(configuration); !errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  const auto cells = cellsOf(configuration);
  const VoxelField::Shape shape{
      vectorOf(configuration, "position"),
      {static_cast<std::int64_t>(cells[0]), static_cast<std::int64_t>(cells[1]), static_cast<std::int64_t>(cells[2])},
      configuration.number("voxelSize"),
      configuration.flag("periodic")};
  return std::make_unique<LightVoxels>(shape, configuration);
}

}  // namespace espalier::environment
