// The process `light` (docs/environments.md): sun and sky on the organs of all plants, by rays (leaf_light.h), with
// bounces between organs, in several bands of the spectrum.
//
// Only the rays that no change of the plants can touch outlast a step; the replies are the same without them, bit by
// bit. With the sun by position its strength is 1361 W/m² at the mean distance, times τ^m through air of the optical
// mass m = 1/sin(elevation). The sky has 0.3 (1 − τ^m) of the light that the sun would give a horizontal plane (Liu &
// Jordan 1960; Campbell & Norman 1998).

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "engine/turtle/field.h"
#include "environment/base/length_unit.h"
#include "environment/base/number_text.h"
#include "environment/base/replies.h"
#include "environment/geometry/grid_axes.h"
#include "environment/light/rays/daylight.h"
#include "environment/light/rays/leaf_light.h"
#include "environment/light/rays/light_keys.h"
#include "environment/light/rays/plant_surfaces.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr int kGroundCells = 16;
constexpr double kMostPlots = 50.0;    // that one triangle reaches
constexpr double kFurthestPlot = 1e6;  // beyond it places have too few digits
constexpr std::uint32_t kGroundMaterial = 2 * PlantSurfaces::kSegment;

class Light final : public turtle::EnvironmentProcess {
 public:
  explicit Light(const Configuration& configuration)
      : configuration_(configuration),
        bands_(configuration.numbers("bands")),
        isPhotons_(configuration.text("unit") == "umol"),
        daylight_(configuration) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description{
        .name = "light",
        .summary = std::string(kLightSummary),
        .needs = {.position = true, .parameters = true, .following = true, .geometry = true},
        .inputs = {},
        .outputs = {},
        .isStateful = false};
    const std::string total = isPhotons_ ? "umol/s" : "W";
    const std::string density = isPhotons_ ? "umol/(m^2 s)" : "W/m^2";
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
    LeafLight::Options options{.directions = static_cast<int>(configuration_.integer("directions")),
                               .keepsHits = configuration_.integer("bounces") > 0,
                               .threads = static_cast<unsigned>(configuration_.integer("threads"))};
    const auto& plot = configuration_.numbers("plot");
    if (!plot.empty()) {
      options.repetition = RayCaster::Repetition{
          {axes_->up == 0 ? 1 : 0, axes_->up == 2 ? 1 : 2}, {plot[0], plot[2]}, {plot[1], plot[3]}};
    }
    light_.emplace(options);
    groundLight_.clear();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    PlantSurfaces plants = queries.geometry
                               ? surfacesOf(*queries.geometry, static_cast<int>(configuration_.integer("segmentSides")))
                               : PlantSurfaces{};
    if (auto problem = beyondThePlot(plants.surfaces)) {
      return turtle::EnvironmentError{"Environment 'light' " + *problem, false};
    }
    addGround(plants.surfaces);
    const int bounces = static_cast<int>(configuration_.integer("bounces"));
    // without bounces only organs with a query need light
    std::vector<std::uint32_t> wanted;
    if (bounces == 0) {
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
    }
    if (bounces == 0 && wanted.empty() && !plants.surfaces.triangles.empty()) {
      // only sensors ask: one triangle is enough to have a scene
      wanted.push_back(0);
    }
    const Daylight::Incoming incoming = daylight_.at(queries.timeDays, light_->directions());
    light_->setScene(plants.surfaces, std::move(wanted), incoming.suns);
    groundLight_.clear();
    for (std::size_t band = 0; band < bands_.size(); ++band) {
      answerBand(queries, band, bounces, plants, incoming.sky, replies);
    }
    countAnswers(queries, replies);
    return std::nullopt;
  }

  /// The irradiance of the ground, when there is one.
  [[nodiscard]] std::vector<turtle::Field> fields() const override {
    std::vector<turtle::Field> fields;
    const auto& plot = configuration_.numbers("plot");
    for (std::size_t band = 0; band < groundLight_.size(); ++band) {
      turtle::Field field;
      field.name = bands_.size() == 1 ? "groundLight" : "groundLight" + std::to_string(band + 1);
      field.unit = isPhotons_ ? "umol/(m^2 s)" : "W/m^2";
      const double height = configuration_.number("groundHeight");
      const double wide = (plot[1] - plot[0]) / kGroundCells;
      const double deep = (plot[3] - plot[2]) / kGroundCells;
      const Vec3 low = axes_->toWorld({plot[0], height, plot[2]});
      field.position = low;
      const std::array<std::size_t, 2> axes{axes_->up == 0 ? 1U : 0U, axes_->up == 2 ? 1U : 2U};
      field.cells[axes[0]] = kGroundCells;
      field.cells[axes[1]] = kGroundCells;
      std::array<double, 3> sizes{};
      sizes[static_cast<std::size_t>(axes_->up)] = std::min(wide, deep);
      sizes[axes[0]] = wide;
      sizes[axes[1]] = deep;
      field.cellSize = {sizes[0], sizes[1], sizes[2]};
      for (std::size_t second = 0; second < kGroundCells; ++second) {
        for (std::size_t first = 0; first < kGroundCells; ++first) {
          field.values.push_back(groundLight_[band][first * kGroundCells + second]);
        }
      }
      fields.push_back(std::move(field));
    }
    return fields;
  }

 private:
  /// The error of organs that are too large for a repeated plot: a triangle counts once in each plot that it reaches.
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
    const auto base = static_cast<std::uint32_t>(surfaces.vertices.size());
    const double height = configuration_.number("groundHeight");
    for (int i = 0; i <= kGroundCells; ++i) {
      for (int k = 0; k <= kGroundCells; ++k) {
        const double a = plot[0] + (plot[1] - plot[0]) * i / kGroundCells;
        const double b = plot[2] + (plot[3] - plot[2]) * k / kGroundCells;
        surfaces.vertices.push_back(axes_->toWorld({a, height, b}));
      }
    }
    for (std::uint32_t i = 0; i < kGroundCells; ++i) {
      for (std::uint32_t k = 0; k < kGroundCells; ++k) {
        const std::uint32_t corner = base + i * (kGroundCells + 1) + k;
        surfaces.triangles.push_back({corner, corner + 1, corner + kGroundCells + 2});
        surfaces.triangles.push_back({corner, corner + kGroundCells + 2, corner + kGroundCells + 1});
        surfaces.material.insert(surfaces.material.end(), 2, kGroundMaterial);
        const std::uint32_t number = 2 * (i * kGroundCells + k);
        surfaces.seed.insert(surfaces.seed.end(), {number, number + 1});
        surfaces.thinning.insert(surfaces.thinning.end(), 2, 0);
      }
    }
  }

  [[nodiscard]] std::vector<LightMaterial> materialsOf(std::size_t band) const {
    std::vector<LightMaterial> materials(kGroundMaterial + 1);
    for (std::size_t colour = 0; colour < PlantSurfaces::kSegment; ++colour) {
      materials[colour] = {numberOfBand(configuration_.numbers("reflectance"), band),
                           numberOfBand(configuration_.numbers("transmittance"), band)};
      materials[PlantSurfaces::kSegment + colour] = {numberOfBand(configuration_.numbers("stemReflectance"), band),
                                                     0.0};
    }
    for (const auto& row : configuration_.rows("materials")) {
      materials[static_cast<std::size_t>(row[0])] = {row[1 + 2 * band], row[2 + 2 * band]};
    }
    materials[kGroundMaterial] = {numberOfBand(configuration_.numbers("groundReflectance"), band), 0.0};
    return materials;
  }

  /// The light on the squares of the ground, each two triangles at the end of all.
  void keepGroundLight(const LightSurfaces& surfaces, const std::vector<double>& irradiances, std::size_t band) {
    constexpr std::size_t kTriangles = 2 * kGroundCells * kGroundCells;
    const std::size_t count = surfaces.triangles.size();
    if (count < kTriangles || surfaces.material[count - kTriangles] != kGroundMaterial) {
      return;
    }
    const double unit = isPhotons_ ? numberOfBand(configuration_.numbers("photonsPerJoule"), band) : 1.0;
    std::vector<double> light;
    for (std::size_t triangle = count - kTriangles; triangle < count; triangle += 2) {
      // either side may be the front, and the other one sees nothing
      double sum = 0.0;
      for (std::size_t side = 2 * triangle; side < 2 * triangle + 4; ++side) {
        sum += irradiances[side];
      }
      light.push_back(0.5 * sum * unit);
    }
    groundLight_.push_back(std::move(light));
  }

  void answerBand(const turtle::QueryBatch& queries, std::size_t band, int bounces, const PlantSurfaces& plants,
                  std::vector<double> sky, turtle::ReplyBatch& replies) {
    for (double& radiance : sky) {
      radiance *= bands_[band];
    }
    const std::vector<LightMaterial> materials = materialsOf(band);
    const std::vector<double> irradiances = light_->irradiances(band, sky, materials, {}, bounces);
    keepGroundLight(plants.surfaces, irradiances, band);
    const double unit = isPhotons_ ? numberOfBand(configuration_.numbers("photonsPerJoule"), band) : 1.0;
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
        area += light_->areaOf(triangle);
        incident += light_->areaOf(triangle) * both;
        absorbed += light_->areaOf(triangle) * both * (1.0 - material.reflectance - material.transmittance);
      }
      std::array<double, 4> values{};
      if (area > 0.0) {
        values = {absorbed / area, absorbed * metres_ * metres_, incident / area, incident * metres_ * metres_};
      } else if (begin == end) {
        values[2] = light_->irradianceAt(queries.position[query], up_, band, sky);
      }
      for (std::size_t k = 0; k < std::min<std::size_t>(count - 4 * band, 4); ++k) {
        replies.set(queries, query, 4 * band + k, values[k] * unit);
      }
    }
  }

  std::vector<std::vector<double>> groundLight_;  // irradiance by band and square of the ground; none: no ground
  Configuration configuration_;
  std::vector<double> bands_;  // parts of the irradiance
  bool isPhotons_;
  Daylight daylight_;
  std::optional<GridAxes> axes_;
  Vec3 up_{0, 1, 0};
  double metres_ = 1.0;  // in a length unit
  /// Keeps the rays of the last step; the replies do not depend on them. Set by open().
  std::optional<LeafLight> light_;
};

}  // namespace

ProcessOrErrors makeLight(const Configuration& configuration) {
  if (auto errors = checkLight(configuration); !errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  return std::make_unique<Light>(configuration);
}

}  // namespace espalier::environment
