// The process `light` (docs/environments.md): sun and sky on the organs of all plants, by rays (leaf_light.h), with
// bounces between organs, in several bands of the spectrum.
//
// Only the rays that no change of the plants can touch outlast a step; the replies are the same without them, bit by
// bit. Sun and sky are those of daylight.h.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "engine/turtle/field.h"
#include "environment/base/length_unit.h"
#include "environment/base/number_text.h"
#include "environment/base/replies.h"
#include "environment/geometry/grid_axes.h"
#include "environment/light/daylight.h"
#include "environment/light/daylight_keys.h"
#include "environment/light/light_bands.h"
#include "environment/light/rays/leaf_light.h"
#include "environment/light/rays/light_keys.h"
#include "environment/light/rays/plant_surfaces.h"
#include "environment/light/rays/ray_daylight.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::size_t kMostDirections = 65536;    // that the error asks for
constexpr std::size_t kRaysOfABalance = 500'000;  // to the sun, of all triangles together
constexpr double kMostPlots = 50.0;               // that one triangle reaches
constexpr double kFurthestPlot = 1e6;             // beyond it places have too few digits
constexpr std::uint32_t kGroundMaterial = 2 * PlantSurfaces::kSegment;

class Light final : public turtle::EnvironmentProcess {
 public:
  explicit Light(const Configuration& configuration)
      : configuration_(configuration),
        bands_(bandsOf(configuration)),
        unit_(configuration.text("unit")),
        remainder_(configuration.number("remainder")),
        error_(configuration.number("error")),
        groundCells_(static_cast<std::uint32_t>(configuration.integer("groundCells"))),
        daylight_(configuration, configuration.number("diffuseIrradiance")) {
    for (const LightBand& band : bands_) {
      parts_.push_back(band.part);
    }
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description{
        .name = "light",
        .summary = std::string(kLightSummary),
        .needs = {.position = true, .parameters = true, .following = true, .geometry = true},
        .inputs = {},
        .outputs = {},
        .isStateful = false};
    const std::string total = unit_ == "W" ? "W" : unit_ == "umol" ? "umol/s" : "mol/day";
    const std::string density = densityUnit();
    for (std::size_t band = 1; band <= bands_.size(); ++band) {
      const std::string number = bands_.size() == 1 ? "" : std::to_string(band);
      description.outputs.push_back({"absorbed" + number, density, ""});
      description.outputs.push_back({"absorbedTotal" + number, total, ""});
      description.outputs.push_back({"incident" + number, density, ""});
      description.outputs.push_back({"incidentTotal" + number, total, ""});
    }
    return description;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto fail = [](const std::string& sentences) {
      return turtle::EnvironmentError{"Environment 'light' " + sentences, false};
    };
    const turtle::World& world = context.world;
    const LengthUnit* unit = findLengthUnit(world.lengthUnit);
    if (unit == nullptr) {
      return unknownLengthUnit("light", world);
    }
    metres_ = unit->metres;
    axes_ = axesOf(world.up);
    if (!axes_ && !configuration_.numbers("plot").empty()) {
      return fail(
          "repeats a 'plot' along the axes, so it needs a world whose 'up' is along x, y or z. Set it to 0 1 0.");
    }
    up_ = core::normalised(world.up);
    if (const auto missing = daylight_.open(world)) {
      return fail(*missing);
    }
    levels_.clear();
    groundLight_.clear();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    try {
      return answerAll(queries, replies);
    } catch (...) {
      levels_.clear();  // the next step would take rays that were not traced for kept ones
      throw;
    }
  }

  /// The irradiance of the ground, when there is one, and the fluxes of the stand with a remainder.
  [[nodiscard]] std::vector<turtle::Field> fields() const override {
    std::vector<turtle::Field> fields;
    const auto& plot = configuration_.numbers("plot");
    for (std::size_t band = 0; band < fluxes_.size(); ++band) {
      addFluxFields(band, fields);
    }
    for (std::size_t band = 0; band < groundLight_.size(); ++band) {
      turtle::Field field;
      field.name = "groundLight" + numberOf(band);
      field.unit = densityUnit();
      const double height = configuration_.number("groundHeight");
      const double wide = (plot[1] - plot[0]) / groundCells_;
      const double deep = (plot[3] - plot[2]) / groundCells_;
      const Vec3 low = axes_->toWorld({plot[0], height, plot[2]});
      field.position = low;
      const std::array<std::size_t, 2> axes{axes_->up == 0 ? 1U : 0U, axes_->up == 2 ? 1U : 2U};
      field.cells[axes[0]] = groundCells_;
      field.cells[axes[1]] = groundCells_;
      std::array<double, 3> sizes{};
      sizes[static_cast<std::size_t>(axes_->up)] = std::min(wide, deep);
      sizes[axes[0]] = wide;
      sizes[axes[1]] = deep;
      field.cellSize = {sizes[0], sizes[1], sizes[2]};
      for (std::size_t second = 0; second < groundCells_; ++second) {
        for (std::size_t first = 0; first < groundCells_; ++first) {
          field.values.push_back(groundLight_[band][first * groundCells_ + second]);
        }
      }
      fields.push_back(std::move(field));
    }
    return fields;
  }

 private:
  [[nodiscard]] std::optional<turtle::EnvironmentError> answerAll(const turtle::QueryBatch& queries,
                                                                  turtle::ReplyBatch& replies) {
    PlantSurfaces plants = queries.geometry
                               ? surfacesOf(*queries.geometry, static_cast<int>(configuration_.integer("segmentSides")))
                               : PlantSurfaces{};
    if (auto problem = beyondNumbers(plants.surfaces)) {
      return turtle::EnvironmentError{"Environment 'light' " + *problem, false};
    }
    if (auto problem = beyondThePlot(plants.surfaces)) {
      return turtle::EnvironmentError{"Environment 'light' " + *problem, false};
    }
    const std::size_t groundBegin = plants.surfaces.triangles.size();
    addGround(plants.surfaces);
    auto lit = shine(0, queries, plants, groundBegin);
    // twice as many rays until that changes little
    for (std::size_t level = 1; lit && error_ > 0.0 && (directionCount() << level) <= kMostDirections; ++level) {
      auto finer = shine(level, queries, plants, groundBegin);
      const bool isEnough = !finer || differenceOf(*lit, *finer, plants) <= error_;
      lit = std::move(finer);
      if (isEnough) {
        break;
      }
    }
    if (!lit) {
      return turtle::EnvironmentError{"Environment 'light' " + lit.error(), false};
    }
    groundLight_.clear();
    fluxes_ = std::move(lit->fluxes);
    for (std::size_t band = 0; band < bands_.size(); ++band) {
      keepGroundLight(plants.surfaces, lit->irradiances[band], band);
      answerBand(queries, band, plants, *lit, replies);
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

  /// The fluxes of the light that comes in over the plot, W/m² of it.
  struct Fluxes {
    double incoming = 0.0;
    double up = 0.0;        // scattered, to the sky
    double down = 0.0;      // on the ground
    double byPlants = 0.0;  // absorbed
    double byGround = 0.0;
  };
  /// The light of all bands, with one number of rays.
  struct Lit {
    const LeafLight* light = nullptr;
    std::vector<std::vector<double>> irradiances;  // of the sides of all triangles, by band
    std::vector<std::vector<double>> sent;         // radiant exitance of the sides, by band; empty: nothing scatters
    std::vector<std::vector<double>> skies;        // radiance by direction, by band
    std::vector<Fluxes> fluxes;                    // by band; empty: not known
  };

  [[nodiscard]] std::string densityUnit() const {
    return unit_ == "W" ? "W/m^2" : unit_ == "umol" ? "umol/(m^2 s)" : "mol/(m^2 day)";
  }
  /// Of a band in names: nothing when there is only one.
  [[nodiscard]] std::string numberOf(std::size_t band) const {
    return bands_.size() == 1 ? std::string() : std::to_string(band + 1);
  }
  /// The unit of replies in W.
  [[nodiscard]] double unitOf(std::size_t band) const {
    return unit_ == "W"      ? 1.0
           : unit_ == "umol" ? bands_[band].photonsPerJoule
                             : bands_[band].photonsPerJoule * kMolesPerDay;
  }
  [[nodiscard]] std::size_t directionCount() const {
    return static_cast<std::size_t>(configuration_.integer("directions"));
  }

  /// The rays of a level, each of which has twice as many as the one before.
  LeafLight& lightOf(std::size_t level) {
    while (levels_.size() <= level) {
      LeafLight::Options options{.directions = static_cast<int>(directionCount() << levels_.size()),
                                 .keepsHits = scatters(),
                                 .settles = remainder_ > 0.0,
                                 .threads = static_cast<unsigned>(configuration_.integer("threads"))};
      const auto& plot = configuration_.numbers("plot");
      if (!plot.empty()) {
        options.repetition = RayCaster::Repetition{
            {axes_->up == 0 ? 1 : 0, axes_->up == 2 ? 1 : 2}, {plot[0], plot[2]}, {plot[1], plot[3]}};
      }
      levels_.push_back(std::make_unique<LeafLight>(options));
    }
    return *levels_[level];
  }
  [[nodiscard]] bool scatters() const { return configuration_.integer("bounces") > 0 || remainder_ > 0.0; }

  [[nodiscard]] tl::expected<Lit, std::string> shine(std::size_t level, const turtle::QueryBatch& queries,
                                                     const PlantSurfaces& plants, std::size_t groundBegin) {
    LeafLight& light = lightOf(level);
    auto daylight = daylight_.at(queries.timeDays);
    if (!daylight) {
      return tl::unexpected(std::move(daylight.error()));
    }
    RayDaylight incoming = onRays(*daylight, skyKindOf(configuration_), parts_, light.directions(), up_);
    if (const std::size_t rays = sunRaysOf(level, groundBegin, incoming.suns.size()); rays > 1) {
      repeat(incoming.suns, rays);
    }
    light.setScene(plants.surfaces, scatters() ? std::vector<std::uint32_t>{} : wantedBy(queries, plants),
                   incoming.suns);
    Lit lit;
    lit.light = &light;
    const bool hasGround = plants.surfaces.triangles.size() > groundBegin;
    for (std::size_t band = 0; band < bands_.size(); ++band) {
      std::vector<double> sky = incoming.sky;
      for (double& radiance : sky) {
        radiance *= bands_[band].part;
      }
      const std::vector<LightMaterial> materials = materialsOf(band);
      if (remainder_ > 0.0) {
        Fluxes fluxes;
        fluxes.incoming = incoming.diffuse * bands_[band].part;
        for (const LeafLight::Sun& sun : incoming.suns) {
          fluxes.incoming += core::dot(sun.direction, up_) * sun.irradiance[band];
        }
        LeafLight::Balance balance =
            light.settle(band, sky, materials, remainder_, up_,
                         hasGround ? std::optional(fluxes.incoming * plotArea()) : std::nullopt);
        if (hasGround) {
          complete(fluxes, balance, light, plants.surfaces, materials, groundBegin);
          lit.fluxes.push_back(fluxes);
        }
        lit.irradiances.push_back(std::move(balance.gathered));
        lit.sent.push_back(std::move(balance.sent));
      } else {
        lit.irradiances.push_back(light.irradiances(band, sky, materials, {},
                                                    static_cast<int>(configuration_.integer("bounces")),
                                                    scatters() ? &lit.sent.emplace_back() : nullptr));
        lit.sent.resize(band + 1);
      }
      lit.skies.push_back(std::move(sky));
    }
    return lit;
  }

  /// Rays from a triangle to each of the suns. The sum over a stand of one ray from each leaf has an error of about
  /// L √(f (1 − f)/leaves) of the light, with the leaf area index L and the lit part f.
  [[nodiscard]] std::size_t sunRaysOf(std::size_t level, std::size_t triangles, std::size_t suns) const {
    constexpr std::size_t kMost = 256;
    if (remainder_ > 0.0 && error_ == 0.0 && !configuration_.isGiven("sunRays") && triangles > 0 && suns > 0) {
      return std::clamp<std::size_t>(kRaysOfABalance / (triangles * suns), 1, kMost);
    }
    return static_cast<std::size_t>(configuration_.integer("sunRays")) << level;
  }

  /// Each sun as so many, which shine on other points of a triangle.
  static void repeat(std::vector<LeafLight::Sun>& suns, std::size_t times) {
    std::vector<LeafLight::Sun> all;
    for (LeafLight::Sun& sun : suns) {
      for (double& irradiance : sun.irradiance) {
        irradiance /= static_cast<double>(times);
      }
      all.insert(all.end(), times, sun);
    }
    suns = std::move(all);
  }

  [[nodiscard]] double plotArea() const {
    const auto& plot = configuration_.numbers("plot");
    return (plot[1] - plot[0]) * (plot[3] - plot[2]);
  }

  void complete(Fluxes& fluxes, const LeafLight::Balance& balance, const LeafLight& light,
                const LightSurfaces& surfaces, const std::vector<LightMaterial>& materials,
                std::size_t groundBegin) const {
    for (std::size_t triangle = 0; triangle < surfaces.triangles.size(); ++triangle) {
      const LightMaterial& material = materials[surfaces.material[triangle]];
      const double power =
          (balance.irradiances[2 * triangle] + balance.irradiances[2 * triangle + 1]) * light.areaOf(triangle);
      const double absorbed = power * (1.0 - material.reflectance - material.transmittance);
      if (triangle < groundBegin) {
        fluxes.byPlants += absorbed / plotArea();
      } else {
        fluxes.down += power / plotArea();
        fluxes.byGround += absorbed / plotArea();
      }
    }
    fluxes.up = balance.leavingUp / plotArea();
    // organs may reach below the ground: there nothing comes back
    fluxes.byGround += balance.leavingDown / plotArea();
  }

  /// The root mean square of the differences of what the organs absorb, over the mean: each weighted with its area.
  [[nodiscard]] double differenceOf(const Lit& coarse, const Lit& fine, const PlantSurfaces& plants) const {
    double squares = 0.0;
    double sum = 0.0;
    double area = 0.0;
    for (std::size_t band = 0; band < bands_.size(); ++band) {
      for (std::size_t begin = 0; begin < plants.bySource.size();) {
        const auto [first, end] =
            plants.rangeOf(plants.sources[plants.bySource[begin]].first, plants.sources[plants.bySource[begin]].second);
        double own = 0.0;
        double difference = 0.0;
        double light = 0.0;
        for (std::size_t i = first; i < end; ++i) {
          const std::size_t side = 2 * std::size_t{plants.bySource[i]};
          const double size = fine.light->areaOf(plants.bySource[i]);
          const double now = fine.irradiances[band][side] + fine.irradiances[band][side + 1];
          own += size;
          light += size * now;
          difference += size * (now - coarse.irradiances[band][side] - coarse.irradiances[band][side + 1]);
        }
        squares += own > 0.0 ? difference * difference / own : 0.0;
        sum += light;
        area += own;
        begin = end;
      }
    }
    return sum > 0.0 ? std::sqrt(squares * area) / sum : 0.0;
  }

  /// Without bounces only the ground and organs with a query need light.
  [[nodiscard]] std::vector<std::uint32_t> wantedBy(const turtle::QueryBatch& queries,
                                                    const PlantSurfaces& plants) const {
    std::vector<std::uint32_t> wanted;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto [begin, end] = plants.rangeOf(queries.plant[query], queries.module[query] + 1);
      wanted.insert(wanted.end(), plants.bySource.begin() + static_cast<std::ptrdiff_t>(begin),
                    plants.bySource.begin() + static_cast<std::ptrdiff_t>(end));
    }
    for (std::uint32_t triangle = 0; triangle < plants.surfaces.triangles.size(); ++triangle) {
      if (plants.surfaces.material[triangle] == kGroundMaterial) {
        wanted.push_back(triangle);
      }
    }
    std::sort(wanted.begin(), wanted.end());
    wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
    if (wanted.empty() && !plants.surfaces.triangles.empty()) {
      // only sensors ask: one triangle is enough to have a scene
      wanted.push_back(0);
    }
    return wanted;
  }

  /// The fluxes of a band as fields of one cell over the plot.
  void addFluxFields(std::size_t band, std::vector<turtle::Field>& fields) const {
    const auto& plot = configuration_.numbers("plot");
    const Fluxes& fluxes = fluxes_[band];
    turtle::Field field;
    field.unit = densityUnit();
    field.position = axes_->toWorld({plot[0], configuration_.number("groundHeight"), plot[2]});
    const double wide = plot[1] - plot[0];
    const double deep = plot[3] - plot[2];
    field.cellSize = axes_->toWorld({wide, std::min(wide, deep), deep});
    field.cellSize = {std::abs(field.cellSize.x), std::abs(field.cellSize.y), std::abs(field.cellSize.z)};
    for (const auto& [name, value] : {std::pair{"incoming", fluxes.incoming},
                                      {"leavingUp", fluxes.up},
                                      {"downOnGround", fluxes.down},
                                      {"absorbedByPlants", fluxes.byPlants},
                                      {"absorbedByGround", fluxes.byGround}}) {
      field.name = name + numberOf(band);
      field.values = {value * unitOf(band)};
      fields.push_back(field);
    }
  }

  /// The error of organs that are too large for a repeated plot: a triangle counts once in each plot that it reaches.
  [[nodiscard]] static std::optional<std::string> beyondNumbers(const LightSurfaces& surfaces) {
    constexpr double kFurthest = 1e17;
    for (const Vec3& place : surfaces.vertices) {
      for (const double coordinate : {place.x, place.y, place.z}) {
        if (!(std::abs(coordinate) <= kFurthest)) {
          return "follows rays among places up to 1e17 from the origin, and an organ reaches " +
                 numberText(coordinate) + ". Bring the plants nearer, or use a larger unit of length.";
        }
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<std::string> beyondThePlot(const LightSurfaces& surfaces) const {
    const auto& plot = configuration_.numbers("plot");
    for (std::size_t k = 0; k < plot.size(); k += 2) {
      const double width = plot[k + 1] - plot[k];
      const auto across = [&](const Vec3& place) {
        const Vec3 own = axes_->toGrid(place);
        return k == 0 ? own.x : own.z;
      };
      for (const auto& corners : surfaces.triangles) {
        const auto [low, high] =
            std::minmax({across(surfaces.vertices[corners[0]]), across(surfaces.vertices[corners[1]]),
                         across(surfaces.vertices[corners[2]])});
        if (!(high - low <= kMostPlots * width)) {
          return "repeats a 'plot' that is " + numberText(width) + " wide, and an organ is more than " +
                 numberText(kMostPlots) + " times as wide. Use a larger 'plot'.";
        }
        if (!(std::abs(low - plot[k]) <= kFurthestPlot * width)) {
          return "repeats a 'plot' that is " + numberText(width) +
                 " wide, and an organ is more than a million plots away. Bring the plants nearer.";
        }
      }
    }
    return std::nullopt;
  }

  /// A ground of squares under the plot.
  void addGround(LightSurfaces& surfaces) const {
    const auto& plot = configuration_.numbers("plot");
    if (!configuration_.flag("ground") || plot.empty()) {
      return;
    }
    surfaces.groundBegin = surfaces.triangles.size();
    const auto base = static_cast<std::uint32_t>(surfaces.vertices.size());
    const double height = configuration_.number("groundHeight");
    for (std::uint32_t i = 0; i <= groundCells_; ++i) {
      for (std::uint32_t k = 0; k <= groundCells_; ++k) {
        const double a = plot[0] + (plot[1] - plot[0]) * i / groundCells_;
        const double b = plot[2] + (plot[3] - plot[2]) * k / groundCells_;
        surfaces.vertices.push_back(axes_->toWorld({a, height, b}));
      }
    }
    for (std::uint32_t i = 0; i < groundCells_; ++i) {
      for (std::uint32_t k = 0; k < groundCells_; ++k) {
        const std::uint32_t corner = base + i * (groundCells_ + 1) + k;
        surfaces.triangles.push_back({corner, corner + 1, corner + groundCells_ + 2});
        surfaces.triangles.push_back({corner, corner + groundCells_ + 2, corner + groundCells_ + 1});
        surfaces.material.insert(surfaces.material.end(), 2, kGroundMaterial);
        const std::uint32_t number = 2 * (i * groundCells_ + k);
        surfaces.seed.insert(surfaces.seed.end(), {number, number + 1});
        surfaces.thinning.insert(surfaces.thinning.end(), 2, 0);
      }
    }
  }

  [[nodiscard]] std::vector<LightMaterial> materialsOf(std::size_t number) const {
    const LightBand& band = bands_[number];
    const double stem = numberOfBand(configuration_.numbers("stemReflectance"), number);
    std::vector<LightMaterial> materials(kGroundMaterial + 1);
    for (std::size_t colour = 0; colour < PlantSurfaces::kSegment; ++colour) {
      materials[colour] = {band.reflectance, band.transmittance};
      materials[PlantSurfaces::kSegment + colour] = {stem, 0.0};
    }
    for (const auto& row : configuration_.rows("materials")) {
      materials[static_cast<std::size_t>(row[0])] = {row[1 + 2 * number], row[2 + 2 * number]};
    }
    materials[kGroundMaterial] = {band.groundReflectance, 0.0};
    return materials;
  }

  /// The light on the squares of the ground, each two triangles at the end of all.
  void keepGroundLight(const LightSurfaces& surfaces, const std::vector<double>& irradiances, std::size_t band) {
    const std::size_t count = surfaces.triangles.size();
    const std::size_t squares = std::size_t{groundCells_} * groundCells_;
    if (count < 2 * squares || surfaces.material[count - 2 * squares] != kGroundMaterial) {
      return;
    }
    const double unit = unitOf(band);
    std::vector<double> light;
    for (std::size_t triangle = count - 2 * squares; triangle < count; triangle += 2) {
      // either side may be the front, and the other one sees nothing
      double sum = 0.0;
      for (std::size_t side = 2 * triangle; side < 2 * triangle + 4; ++side) {
        sum += irradiances[side];
      }
      light.push_back(0.5 * sum * unit);
    }
    groundLight_.push_back(std::move(light));
  }

  void answerBand(const turtle::QueryBatch& queries, std::size_t band, const PlantSurfaces& plants, const Lit& lit,
                  turtle::ReplyBatch& replies) const {
    const std::vector<LightMaterial> materials = materialsOf(band);
    const std::vector<double>& irradiances = lit.irradiances[band];
    const double unit = unitOf(band);
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const std::size_t count = queries.parametersOf(query).size();
      if (count <= 4 * band) {
        continue;
      }
      const auto [begin, end] = plants.rangeOf(queries.plant[query], queries.module[query] + 1);
      double area = 0.0;
      double incident = 0.0;
      double absorbed = 0.0;
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t triangle = plants.bySource[i];
        const std::uint32_t number = plants.surfaces.material[triangle];
        const LightMaterial& material = materials[number];
        // of a segment only the outside counts
        const bool isSegment = number >= PlantSurfaces::kSegment;
        const double both = irradiances[2 * triangle] + (isSegment ? 0.0 : irradiances[2 * triangle + 1]);
        area += lit.light->areaOf(triangle);
        incident += lit.light->areaOf(triangle) * both;
        absorbed += lit.light->areaOf(triangle) * both * (1.0 - material.reflectance - material.transmittance);
      }
      std::array<double, 4> values{};
      if (area > 0.0) {
        values = {absorbed / area, absorbed * metres_ * metres_, incident / area, incident * metres_ * metres_};
      } else if (begin == end && configuration_.text("sensor") == "fluxes") {
        const Fluxes& fluxes = fluxes_[band];
        values = {fluxes.up, fluxes.down, fluxes.byPlants, fluxes.byGround};
      } else if (begin == end) {
        values[2] = lit.light->irradianceAt(queries.position[query], up_, band, lit.skies[band], lit.sent[band]);
      }
      for (std::size_t k = 0; k < std::min<std::size_t>(count - 4 * band, 4); ++k) {
        replies.set(queries, query, 4 * band + k, values[k] * unit);
      }
    }
  }

  std::vector<std::vector<double>> groundLight_;  // irradiance by band and square of the ground; none: no ground
  std::vector<Fluxes> fluxes_;                    // of the last step, by band; empty: not known
  Configuration configuration_;
  std::vector<LightBand> bands_;
  std::vector<double> parts_;  // of the irradiance in each band
  std::string unit_;           // W, umol, mol
  double remainder_;
  double error_;
  std::uint32_t groundCells_;  // along each side
  Daylight daylight_;
  std::optional<GridAxes> axes_;
  Vec3 up_{0, 1, 0};
  double metres_ = 1.0;  // in a length unit
  /// Keep the rays of the last step; the replies do not depend on them. By level, made when needed.
  std::vector<std::unique_ptr<LeafLight>> levels_;
};

}  // namespace

ProcessOrErrors makeLight(const Configuration& configuration) {
  if (auto errors = checkLight(configuration); !errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  return std::make_unique<Light>(configuration);
}

}  // namespace espalier::environment
