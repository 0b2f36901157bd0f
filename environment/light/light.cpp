#include "environment/light/light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "engine/turtle/field.h"
#include "environment/grid_axes.h"
#include "environment/light/leaf_light.h"
#include "environment/light/plant_surfaces.h"
#include "environment/light/sky.h"
#include "environment/light/sun_position.h"
#include "environment/replies.h"

namespace espalier::environment {

namespace {

using core::Vec3;
using std::numbers::pi;

constexpr std::string_view kSummary = "Sun and sky on the organs of all plants, by rays, with bounces and bands.";
constexpr std::array<std::string_view, 3> kSuns{"none", "direction", "position"};
constexpr std::array<std::string_view, 2> kUnits{"W", "umol"};
constexpr std::array kHigh{0.0, 1.0, 0.0};
constexpr std::array kOne{1.0};
constexpr std::array kPhotons{4.57};
constexpr std::array kReflectance{0.08};
constexpr std::array kTransmittance{0.05};
constexpr std::array kStemReflectance{0.2};
constexpr std::array kGroundReflectance{0.1};
constexpr int kGroundCells = 16;
constexpr std::uint32_t kGroundMaterial = 2 * PlantSurfaces::kSegment;
constexpr std::array kKeys{
    ConfigurationKey{.name = "sky",
                     .kind = KeyKind::Choice,
                     .description = "brightness of the sky; overcast is (1 + 2 cos θ)/3, clear the CIE's with the sun",
                     .defaultText = "overcast",
                     .choices = kSkyNames},
    ConfigurationKey{.name = "diffuseIrradiance",
                     .description = "of a horizontal plane under the open sky, unless the sun is by position",
                     .unit = "W/m^2",
                     .minimum = 0.0,
                     .defaultNumber = 200.0},
    ConfigurationKey{
        .name = "sun",
        .kind = KeyKind::Choice,
        .description = "none; direction: sunDirection; position: by the world's latitude, longitude and start",
        .defaultText = "none",
        .choices = kSuns},
    ConfigurationKey{.name = "start",
                     .kind = KeyKind::Text,
                     .description = "date and universal time of step 0, with latitude and longitude, instead of the "
                                    "world's; empty: the world's"},
    ConfigurationKey{.name = "latitude",
                     .description = "with start: north is positive",
                     .unit = "degree",
                     .minimum = -90.0,
                     .maximum = 90.0},
    ConfigurationKey{.name = "longitude",
                     .description = "with start: east is positive",
                     .unit = "degree",
                     .minimum = -360.0,
                     .maximum = 360.0},
    ConfigurationKey{.name = "sunDirection",
                     .kind = KeyKind::Numbers,
                     .description = "x, y, z towards the sun",
                     .defaultNumbers = kHigh,
                     .minimumCount = 3,
                     .maximumCount = 3},
    ConfigurationKey{.name = "directIrradiance",
                     .description = "of a plane that faces the sun, unless the sun is by position",
                     .unit = "W/m^2",
                     .minimum = 0.0,
                     .defaultNumber = 800.0},
    ConfigurationKey{.name = "atmosphere",
                     .description = "τ, what clear air lets through from the zenith",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .isMinimumExclusive = true,
                     .defaultNumber = 0.7},
    ConfigurationKey{.name = "sunSamples",
                     .kind = KeyKind::Integer,
                     .description = "positions of the sun in a step; 1: in its middle",
                     .minimum = 1.0,
                     .maximum = 1000.0,
                     .defaultNumber = 24.0},
    ConfigurationKey{.name = "bands",
                     .kind = KeyKind::Numbers,
                     .description = "part of the irradiance that is in each band of the spectrum",
                     .minimum = 0.0,
                     .defaultNumbers = kOne,
                     .minimumCount = 1,
                     .maximumCount = 16},
    ConfigurationKey{.name = "unit",
                     .kind = KeyKind::Choice,
                     .description = "of what comes back: W or µmol/s",
                     .defaultText = "W",
                     .choices = kUnits},
    ConfigurationKey{.name = "photonsPerJoule",
                     .kind = KeyKind::Numbers,
                     .description = "of each band, or one number for all; 4.57: PAR",
                     .unit = "umol/J",
                     .minimum = 0.0,
                     .defaultNumbers = kPhotons,
                     .minimumCount = 1},
    ConfigurationKey{.name = "reflectance",
                     .kind = KeyKind::Numbers,
                     .description = "of organs, in each band, or one number for all",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumbers = kReflectance,
                     .minimumCount = 1},
    ConfigurationKey{.name = "transmittance",
                     .kind = KeyKind::Numbers,
                     .description = "of organs, in each band, or one number for all",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumbers = kTransmittance,
                     .minimumCount = 1},
    ConfigurationKey{.name = "stemReflectance",
                     .kind = KeyKind::Numbers,
                     .description = "of segments, which let nothing through, in each band, or one number for all",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumbers = kStemReflectance,
                     .minimumCount = 1},
    ConfigurationKey{.name = "materials",
                     .kind = KeyKind::Rows,
                     .description = "organs of a colour: its number, then reflectance and transmittance of each band",
                     .minimum = 0.0,
                     .maximum = 255.0,
                     .minimumCount = 3},
    ConfigurationKey{.name = "bounces",
                     .kind = KeyKind::Integer,
                     .description = "how often light is scattered between organs",
                     .minimum = 0.0,
                     .maximum = 100.0,
                     .defaultNumber = 2.0},
    ConfigurationKey{.name = "directions",
                     .kind = KeyKind::Integer,
                     .description = "of the rays of a triangle, over the whole sphere",
                     .minimum = 8.0,
                     .maximum = 65536.0,
                     .defaultNumber = 128.0},
    ConfigurationKey{.name = "plot",
                     .kind = KeyKind::Numbers,
                     .description =
                         "the stand repeats itself without end: smallest and largest of the first, then of the "
                         "second horizontal coordinate (x and z when y is up); none: plants stand alone",
                     .unit = "length",
                     .maximumCount = 4},
    ConfigurationKey{
        .name = "ground", .kind = KeyKind::Boolean, .description = "a ground under the plot that reflects"},
    ConfigurationKey{.name = "groundHeight", .description = "along the world's up", .unit = "length"},
    ConfigurationKey{.name = "groundReflectance",
                     .kind = KeyKind::Numbers,
                     .description = "in each band, or one number for all",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .defaultNumbers = kGroundReflectance,
                     .minimumCount = 1},
    ConfigurationKey{.name = "segmentSides",
                     .kind = KeyKind::Integer,
                     .description = "of the prisms that stand for segments",
                     .minimum = 3.0,
                     .maximum = 64.0,
                     .defaultNumber = 5.0},
    ConfigurationKey{.name = "threads",
                     .kind = KeyKind::Integer,
                     .description = "that trace rays; the light is the same for any number",
                     .minimum = 1.0,
                     .maximum = 256.0,
                     .defaultNumber = 1.0},
};

double metresIn(std::string_view unit) {
  constexpr std::array<std::pair<std::string_view, double>, 4> kMetres{
      {{"m", 1.0}, {"dm", 0.1}, {"cm", 0.01}, {"mm", 0.001}}};
  const auto found = std::find_if(kMetres.begin(), kMetres.end(), [&](const auto& one) { return one.first == unit; });
  return found == kMetres.end() ? 0.0 : found->second;
}

double ofBand(const std::vector<double>& numbers, std::size_t band) {
  return numbers[std::min(band, numbers.size() - 1)];
}

/// The light of a step before it meets a plant: of the whole spectrum.
struct Incoming {
  std::vector<LeafLight::Sun> suns;  // irradiance by band
  std::vector<double> sky;           // radiance by direction, W m⁻² sr⁻¹
};

class Light final : public turtle::EnvironmentProcess {
 public:
  explicit Light(const Configuration& configuration)
      : configuration_(configuration),
        bands_(configuration.numbers("bands")),
        isPhotons_(configuration.text("unit") == "umol"),
        sun_(configuration.text("sun")),
        skyKind_(static_cast<SkyKind>(std::find(kSkyNames.begin(), kSkyNames.end(), configuration.text("sky")) -
                                      kSkyNames.begin())) {}

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    turtle::EnvironmentDescription description{
        .name = "light",
        .summary = std::string(kSummary),
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
    metres_ = metresIn(world.lengthUnit);
    if (metres_ == 0.0) {
      return fail("knows light on areas in m, dm, cm and mm, not in the world's unit '" + world.lengthUnit +
                  "'. Set lengthUnit to one of these.");
    }
    axes_ = axesOf(world.up);
    if (!axes_ && !configuration_.numbers("plot").empty()) {
      return fail("repeats a 'plot' along the axes: the world's 'up' must be along x, y or z. Set it to 0 1 0.");
    }
    up_ = core::normalised(world.up);
    if (sun_ == "position") {
      const std::string& own = configuration_.text("start");
      const auto start = julianDayOf(own.empty() ? world.start : own);
      if (!start || (own.empty() && !world.latitudeDegrees)) {
        return fail(
            "needs to know where and when it is for the position of the sun: set 'latitude', 'longitude' and "
            "'start', here or in the world (\"2026-06-21\" or \"2026-06-21T12:00\", universal time).");
      }
      startDay_ = *start;
      latitude_ = own.empty() ? *world.latitudeDegrees : configuration_.number("latitude");
      longitude_ = own.empty() ? world.longitudeDegrees.value_or(0.0) : configuration_.number("longitude");
      north_ = core::normalised(world.north - up_ * core::dot(world.north, up_));
      stepDays_ = world.stepDurationDays;
    } else if (sun_ == "direction") {
      const auto& direction = configuration_.numbers("sunDirection");
      sunDirection_ = core::normalised({direction[0], direction[1], direction[2]});
      if (!(core::dot(sunDirection_, up_) > 1e-6)) {
        return fail("has its sun below the horizon. Give a 'sunDirection' that points up to the sun.");
      }
    }
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    PlantSurfaces plants = queries.geometry
                               ? surfacesOf(*queries.geometry, static_cast<int>(configuration_.integer("segmentSides")))
                               : PlantSurfaces{};
    addGround(plants.surfaces);
    const int bounces = static_cast<int>(configuration_.integer("bounces"));
    // without bounces only what is asked about needs light
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
    LeafLight::Options options{.directions = static_cast<int>(configuration_.integer("directions")),
                               .keepsHits = bounces > 0,
                               .threads = static_cast<unsigned>(configuration_.integer("threads"))};
    const auto& plot = configuration_.numbers("plot");
    if (!plot.empty()) {
      options.repetition = RayCaster::Repetition{
          {axes_->up == 0 ? 1 : 0, axes_->up == 2 ? 1 : 2}, {plot[0], plot[2]}, {plot[1], plot[3]}};
    }
    if (bounces == 0 && wanted.empty() && !plants.surfaces.triangles.empty()) {
      // only sensors ask: one triangle is enough to have a scene
      wanted.push_back(0);
    }
    const Incoming incoming = incomingLight(queries.timeDays, options.directions);
    const LeafLight light(plants.surfaces, std::move(wanted), incoming.suns, options);
    groundLight_.clear();
    for (std::size_t band = 0; band < bands_.size(); ++band) {
      answerBand(queries, band, bounces, plants, light, incoming, replies);
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
      }
    }
  }

  [[nodiscard]] Incoming incomingLight(double timeDays, int directionCount) const {
    const std::vector<Vec3> directions = LeafLight::directionsOf(directionCount);
    Incoming incoming;
    incoming.sky.assign(directions.size(), 0.0);
    const auto addSun = [&](const Vec3& direction, double irradiance) {
      LeafLight::Sun sun{direction, {}};
      for (const double part : bands_) {
        sun.irradiance.push_back(irradiance * part);
      }
      incoming.suns.push_back(std::move(sun));
    };
    if (sun_ == "none") {
      addSky(directions, up_, configuration_.number("diffuseIrradiance"), incoming.sky);
      return incoming;
    }
    if (sun_ == "direction") {
      addSun(sunDirection_, configuration_.number("directIrradiance"));
      addSky(directions, sunDirection_, configuration_.number("diffuseIrradiance"), incoming.sky);
      return incoming;
    }
    const auto samples = static_cast<int>(configuration_.integer("sunSamples"));
    for (int i = 0; i < samples; ++i) {
      const double day = startDay_ + timeDays + stepDays_ * (i + 0.5) / samples;
      const SunPosition position = sunPosition(day, latitude_, longitude_);
      const double sine = std::sin(position.elevationRadians);
      if (sine > 1e-3) {
        const Vec3 direction = sunDirection(position, up_, north_);
        const double passed = std::pow(configuration_.number("atmosphere"), 1.0 / sine);
        const double outside = solarIrradiance(day) / samples;
        addSun(direction, outside * passed);
        addSky(directions, direction, 0.3 * (1.0 - passed) * outside * sine, incoming.sky);
      }
    }
    return incoming;
  }

  /// Adds a sky that gives a horizontal plane this irradiance, as the directions sum it up.
  void addSky(const std::vector<Vec3>& directions, const Vec3& sun, double irradiance, std::vector<double>& sky) const {
    std::vector<double> radiance(directions.size(), 0.0);
    double weights = 0.0;
    double sum = 0.0;
    for (std::size_t i = 0; i < directions.size(); ++i) {
      const double cosine = core::dot(directions[i], up_);
      if (cosine > 0.0) {
        radiance[i] = skyRadiance(skyKind_, cosine, core::dot(directions[i], sun), core::dot(up_, sun));
        weights += cosine;
        sum += cosine * radiance[i];
      }
    }
    for (std::size_t i = 0; i < directions.size(); ++i) {
      sky[i] += radiance[i] * irradiance / (pi * sum / weights);
    }
  }

  [[nodiscard]] std::vector<LightMaterial> materialsOf(std::size_t band) const {
    std::vector<LightMaterial> materials(kGroundMaterial + 1);
    for (std::size_t colour = 0; colour < PlantSurfaces::kSegment; ++colour) {
      materials[colour] = {ofBand(configuration_.numbers("reflectance"), band),
                           ofBand(configuration_.numbers("transmittance"), band)};
      materials[PlantSurfaces::kSegment + colour] = {ofBand(configuration_.numbers("stemReflectance"), band), 0.0};
    }
    for (const auto& row : configuration_.rows("materials")) {
      materials[static_cast<std::size_t>(row[0])] = {row[1 + 2 * band], row[2 + 2 * band]};
    }
    materials[kGroundMaterial] = {ofBand(configuration_.numbers("groundReflectance"), band), 0.0};
    return materials;
  }

  /// The light on the squares of the ground, each two triangles at the end of all.
  void keepGroundLight(const LightSurfaces& surfaces, const std::vector<double>& irradiances, std::size_t band) {
    constexpr std::size_t kTriangles = 2 * kGroundCells * kGroundCells;
    const std::size_t count = surfaces.triangles.size();
    if (count < kTriangles || surfaces.material[count - kTriangles] != kGroundMaterial) {
      return;
    }
    const double unit = isPhotons_ ? ofBand(configuration_.numbers("photonsPerJoule"), band) : 1.0;
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
                  const LeafLight& light, const Incoming& incoming, turtle::ReplyBatch& replies) {
    std::vector<double> sky = incoming.sky;
    for (double& radiance : sky) {
      radiance *= bands_[band];
    }
    const std::vector<LightMaterial> materials = materialsOf(band);
    const std::vector<double> irradiances = light.irradiances(band, sky, materials, {}, bounces);
    keepGroundLight(plants.surfaces, irradiances, band);
    const double unit = isPhotons_ ? ofBand(configuration_.numbers("photonsPerJoule"), band) : 1.0;
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
        area += light.areaOf(triangle);
        incident += light.areaOf(triangle) * both;
        absorbed += light.areaOf(triangle) * both * (1.0 - material.reflectance - material.transmittance);
      }
      std::array<double, 4> values{};
      if (area > 0.0) {
        values = {absorbed / area, absorbed * metres_ * metres_, incident / area, incident * metres_ * metres_};
      } else if (begin == end) {
        values[2] = light.irradianceAt(queries.position[query], up_, band, sky);
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
  std::string sun_;
  SkyKind skyKind_;
  std::optional<GridAxes> axes_;
  Vec3 up_{0, 1, 0};
  Vec3 north_{0, 0, -1};
  Vec3 sunDirection_{0, 1, 0};
  double metres_ = 1.0;    // in a length unit
  double startDay_ = 0.0;  // Julian day
  double latitude_ = 0.0;
  double longitude_ = 0.0;
  double stepDays_ = 1.0;
};

ProcessOrErrors makeLight(const Configuration& configuration) {
  std::vector<core::Diagnostic> errors;
  const auto refuse = [&](const std::string& sentence, const std::string& hint) {
    core::Diagnostic diagnostic;
    diagnostic.message = "environment process 'light': " + sentence;
    diagnostic.hint = hint;
    errors.push_back(std::move(diagnostic));
  };
  const std::size_t bands = configuration.numbers("bands").size();
  for (const std::string key :
       {"photonsPerJoule", "reflectance", "transmittance", "stemReflectance", "groundReflectance"}) {
    const std::size_t count = configuration.numbers(key).size();
    if (count != 1 && count != bands) {
      refuse("'" + key + "' has " + std::to_string(count) + " numbers for " + std::to_string(bands) + " bands",
             "give one number for each band, or one for all");
    }
  }
  for (std::size_t band = 0; band < bands && errors.empty(); ++band) {
    if (ofBand(configuration.numbers("reflectance"), band) + ofBand(configuration.numbers("transmittance"), band) >
        1.0) {
      refuse("'reflectance' and 'transmittance' add up to more than 1 in band " + std::to_string(band + 1),
             "organs cannot scatter more light than they get");
    }
  }
  for (const auto& row : configuration.rows("materials")) {
    bool isWrong = row.size() != 1 + 2 * bands || row[0] != std::floor(row[0]);
    for (std::size_t band = 0; !isWrong && band < bands; ++band) {
      isWrong = row[1 + 2 * band] + row[2 + 2 * band] > 1.0;
    }
    if (isWrong) {
      refuse("a row of 'materials' is not a colour number with reflectance and transmittance for each of " +
                 std::to_string(bands) + " bands, together at most 1",
             "write for example \"materials\": [[3, 0.1, 0.05]]");
    }
  }
  const auto& plot = configuration.numbers("plot");
  if (!plot.empty() && (plot.size() != 4 || !(plot[0] < plot[1] && plot[2] < plot[3]))) {
    refuse("'plot' is not a smallest and a largest number for each of the two horizontal coordinates",
           "write for example \"plot\": [-5, 5, -5, 5]");
  }
  if (configuration.flag("ground") && plot.empty()) {
    refuse("a 'ground' needs a 'plot'", "write for example \"plot\": [-5, 5, -5, 5]");
  }
  if (configuration.text("sky") == "clear" && configuration.text("sun") == "none") {
    refuse("a clear 'sky' is brightest around the sun, and 'sun' is none", "set sun to direction or position");
  }
  if (!errors.empty()) {
    return errors;
  }
  return std::make_unique<Light>(configuration);
}

}  // namespace

constinit const ProcessEntry kLightProcess{
    .name = "light", .summary = kSummary, .aliases = {}, .keys = kKeys, .fieldKeywords = {}, .make = makeLight};

}  // namespace espalier::environment
