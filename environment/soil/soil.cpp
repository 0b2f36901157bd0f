// The process `soil` (docs/environments.md): water or a nutrient in the ground, which roots take up and which diffuses,
// in the plane x,y or in space.
//
// All queries see the field of the step before. When they want more than a cell holds, each gets the same share of what
// it wants. Then the obtained amounts leave the cells, and the field spreads. `compatible`: published_soil.cpp.
// O(n log n + cells · steps).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "environment/base/process_entry.h"
#include "environment/base/replies.h"
#include "environment/base/state_numbers.h"
#include "environment/geometry/box_note.h"
#include "environment/geometry/grid_keys.h"
#include "environment/geometry/world_up.h"
#include "environment/obstacles/obstacle_scene.h"
#include "environment/obstacles/scene_file.h"
#include "environment/soil/published_soil.h"
#include "environment/soil/soil_avoidance.h"
#include "environment/soil/soil_field.h"
#include "environment/soil/soil_specification.h"

namespace espalier::environment {

namespace {

using core::Vec3;

constexpr std::string_view kSoilSummary =
    "Water or a nutrient in the ground: roots take it up, and it spreads by diffusion.";
constexpr std::array kUnitRange{0.0, 1.0};
constexpr std::array<std::string_view, 1> kOff{"off"};
constexpr int kMostDiffusionSteps = 1000000;
constexpr std::size_t kSoilMaximumCellCount = std::size_t{1} << 26;

constexpr std::array kSoilKeys{
    sidesKey("domainSize", "size of the box along x, y, z", kUnitSides),
    positionKey(kOrigin),
    ConfigurationKey{.name = "concentration",
                     .kind = KeyKind::Rows,
                     .description =
                         "concentrations by rows along x, the highest row first by the world's up, slice after "
                         "slice along z (y when z is up); empty: uniformConcentration everywhere",
                     .minimumCount = 1},
    ConfigurationKey{
        .name = "sliceCount",
        .kind = KeyKind::Integer,
        .description = "number of slices in the rows; 1: when y is up a plane field, else a box of one cell",
        .minimum = 1,
        .maximum = 4096,
        .defaultNumber = 1},
    gridSizeKey(kUnitSides, "cells along x, y, z when no concentration is given"),
    ConfigurationKey{.name = "uniformConcentration",
                     .description = "concentration of every cell when no concentration is given",
                     .minimum = 0.0,
                     .defaultNumber = 1.0},
    ConfigurationKey{.name = "concentrationRange",
                     .kind = KeyKind::Numbers,
                     .description = "the smallest and the largest concentration, to which gradients are relative",
                     .defaultNumbers = kUnitRange,
                     .minimumCount = 2,
                     .maximumCount = 2},
    ConfigurationKey{.name = "obstacleMap",
                     .kind = KeyKind::Rows,
                     .description = "1 where nothing passes, 0 elsewhere, laid out as concentration; empty: nowhere",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .isWhole = true,
                     .minimumCount = 1},
    ConfigurationKey{
        .name = "obstacleScene",
        .kind = KeyKind::Text,
        .description = "the text of a background scene: cells whose middle is in a solid of it are obstacles"},
    ConfigurationKey{.name = "sourceMap",
                     .kind = KeyKind::Rows,
                     .description = "1 where the concentration is restored in every step, laid out as concentration",
                     .minimum = 0.0,
                     .maximum = 1.0,
                     .isWhole = true,
                     .minimumCount = 1},
    ConfigurationKey{.name = "depletion",
                     .kind = KeyKind::Boolean,
                     .description = "the amount that a query obtains leaves its cell"},
    ConfigurationKey{.name = "diffusionSteps",
                     .kind = KeyKind::Integer,
                     .description = "diffusion steps in a step of the simulation; -1: until diffusionTolerance is met",
                     .minimum = -1,
                     .maximum = kMostDiffusionSteps},
    ConfigurationKey{.name = "diffusionTolerance",
                     .description = "stop the diffusion of a step when no cell changes by as much; 0: never",
                     .minimum = 0.0},
    ConfigurationKey{.name = "relaxationFactor",
                     .description =
                         "part of the way to the mean of the neighbours in a diffusion step; above 1 only when "
                         "compatible",
                     .minimum = 0.0,
                     .maximum = 2.0,
                     .defaultNumber = 0.5},
    ConfigurationKey{.name = "layerThicknesses",
                     .kind = KeyKind::Numbers,
                     .description = "thickness of each layer from the top of the box downwards, by the world's up",
                     .unit = "length",
                     .minimum = 0.0},
    ConfigurationKey{
        .name = "geotropicAngles",
        .kind = KeyKind::Numbers,
        .description = "angle from down of the direction in which gravity draws roots, by layer; missing: 0",
        .unit = "degree",
        .minimum = -180.0,
        .maximum = 180.0},
    ConfigurationKey{.name = "compatible",
                     .kind = KeyKind::Boolean,
                     .description = "uptake in string order, gradients, layers and diffusion as the published program"},
};

constexpr std::array kSoilPublishedKeywords{
    PublishedKeyword{.keyword = "domain size", .kind = PublishedKind::Numbers, .key = "domainSize", .count = 3},
    PublishedKeyword{.keyword = "position", .kind = PublishedKind::Numbers, .key = "position", .count = 3},
    PublishedKeyword{.keyword = "array", .kind = PublishedKind::Own, .key = {}, .read = readArray},
    PublishedKeyword{.keyword = "image", .kind = PublishedKind::Own, .key = {}, .read = readSoilImage},
    // read by the two lines above
    PublishedKeyword{.keyword = "obstacles and sources", .kind = PublishedKind::Unused, .key = {}},
    PublishedKeyword{.keyword = "3D primitives", .kind = PublishedKind::Own, .key = {}, .read = readPrimitives},
    PublishedKeyword{.keyword = "diffusion", .kind = PublishedKind::Own, .key = {}, .read = readDiffusion},
    PublishedKeyword{.keyword = "depletion", .kind = PublishedKind::Switch, .key = "depletion", .offWords = kOff},
    PublishedKeyword{.keyword = "relaxation factor", .key = "relaxationFactor"},
    PublishedKeyword{.keyword = "layer thicknesses", .kind = PublishedKind::Own, .key = {}, .read = readThicknesses},
    PublishedKeyword{.keyword = "geotropic angles", .kind = PublishedKind::Own, .key = {}, .read = readAngles},
};

struct Layers {
  std::vector<double> thicknesses;
  std::vector<double> angles;  // degrees, as many as thicknesses
};

/// The world axes of the rows' numbers, of the rows and of the slices.
std::array<std::size_t, 3> axesOfRows(const GridAxes& axes) {
  return {axes.up == 0 ? 1U : 0U, static_cast<std::size_t>(axes.up), axes.up == 2 ? 1U : 2U};
}

/// Values by cell from rows with the highest first; a message when the rows have another shape.
template <typename Value>
std::string layOut(const ConfigurationRows& rows, std::string_view key, const std::array<std::size_t, 3>& worldCells,
                   const GridAxes& axes, std::vector<Value>& values) {
  if (rows.empty()) {
    return {};
  }
  const auto axisOf = axesOfRows(axes);
  const std::array<std::size_t, 3> strides{1, worldCells[0], worldCells[0] * worldCells[1]};
  const std::array cells{worldCells[axisOf[0]], worldCells[axisOf[1]], worldCells[axisOf[2]]};
  if (rows.size() != cells[1] * cells[2]) {
    return "'" + std::string(key) + "' must have " + std::to_string(cells[1] * cells[2]) + " rows, found " +
           std::to_string(rows.size());
  }
  values.resize(cells[0] * cells[1] * cells[2]);
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (rows[row].size() != cells[0]) {
      return "'" + std::string(key) + "[" + std::to_string(row) + "]' must have " + std::to_string(cells[0]) +
             " numbers, found " + std::to_string(rows[row].size());
    }
    const std::size_t slice = row / cells[1];
    const std::size_t height = axes.sign < 0.0 ? row % cells[1] : cells[1] - 1 - row % cells[1];
    for (std::size_t x = 0; x < cells[0]; ++x) {
      values[slice * strides[axisOf[2]] + height * strides[axisOf[1]] + x * strides[axisOf[0]]] =
          static_cast<Value>(rows[row][x]);
    }
  }
  return {};
}

/// Marks the cells whose middle is in a solid of a scene; a message when the scene cannot be read.
std::string markSolids(const std::string& text, const SoilField::Shape& shape, std::vector<std::uint8_t>& isObstacle) {
  if (text.empty()) {
    return {};
  }
  auto read = readScene(text);
  if (!read) {
    return "'obstacleScene', " + read.error();
  }
  ObstacleScene::Content content;
  content.spheres = read->spheres;
  for (MeshData& mesh : read->meshes) {
    if (const std::string problem = problemOf(mesh); !problem.empty()) {
      return "'obstacleScene' " + problem;
    }
    content.meshes.push_back(std::move(mesh));
  }
  const ObstacleScene scene(std::move(content));
  const auto [nx, ny, nz] = shape.cells;
  isObstacle.resize(nx * ny * nz, 0);
  const auto middle = [](double low, double size, std::size_t cell, std::size_t count) {
    return low + size * (static_cast<double>(cell) + 0.5) / static_cast<double>(count);
  };
  for (std::size_t cell = 0; cell < isObstacle.size(); ++cell) {
    const Vec3 place{middle(shape.position.x, shape.size.x, cell % nx, nx),
                     middle(shape.position.y, shape.size.y, cell / nx % ny, ny),
                     middle(shape.position.z, shape.size.z, cell / (nx * ny), nz)};
    isObstacle[cell] = isObstacle[cell] != 0 || scene.isInside(place) ? 1 : 0;
  }
  return {};
}

/// The field of a configuration by cells of the world, before it begins.
struct SoilContent {
  SoilField::Shape shape;
  std::vector<double> initial;
  std::vector<std::uint8_t> isObstacle;
  std::vector<std::uint8_t> isSource;
};

/// The cells of a configuration whose rows are laid out along the axes of a world, or its errors.
tl::expected<SoilContent, std::vector<core::Diagnostic>> readContent(const Configuration& configuration,
                                                                     const GridAxes& axes) {
  const ConfigurationRows& rows = configuration.rows("concentration");
  SoilContent content{{vectorOf(configuration, "position"), vectorOf(configuration, "domainSize"), {}}, {}, {}, {}};
  SoilField::Shape& shape = content.shape;
  const auto sliceCount = static_cast<std::size_t>(configuration.integer("sliceCount"));
  if (rows.empty()) {
    shape.cells = cellsOf(configuration);
  } else if (rows.size() % sliceCount != 0) {
    return refuse("soil",
                  "'concentration' has " + std::to_string(rows.size()) + " rows, which are not " +
                      std::to_string(sliceCount) + " slices of equal size",
                  "sliceCount: number of slices in the rows");
  } else {
    const auto axisOf = axesOfRows(axes);
    shape.cells[axisOf[0]] = rows.front().size();
    shape.cells[axisOf[1]] = rows.size() / sliceCount;
    shape.cells[axisOf[2]] = sliceCount;
  }
  if (auto problem = tooManyCells("soil", shape.cells, kSoilMaximumCellCount)) {
    return tl::unexpected(std::vector{std::move(*problem)});
  }
  content.initial.assign(shape.cells[0] * shape.cells[1] * shape.cells[2],
                         configuration.number("uniformConcentration"));
  std::vector<core::Diagnostic> errors;
  for (const std::string& problem :
       {layOut(rows, "concentration", shape.cells, axes, content.initial),
        layOut(configuration.rows("obstacleMap"), "obstacleMap", shape.cells, axes, content.isObstacle),
        markSolids(configuration.text("obstacleScene"), shape, content.isObstacle),
        layOut(configuration.rows("sourceMap"), "sourceMap", shape.cells, axes, content.isSource)}) {
    if (!problem.empty()) {
      errors.push_back(wrongConfiguration("soil", problem, "all maps have one number for each cell"));
    }
  }
  if (!errors.empty()) {
    return tl::unexpected(std::move(errors));
  }
  return content;
}

/// Whether rows say what is in a cell: they count down along the world's up.
bool hasRows(const Configuration& configuration) {
  return !configuration.rows("concentration").empty() || !configuration.rows("obstacleMap").empty() ||
         !configuration.rows("sourceMap").empty();
}

SoilField fieldOf(SoilContent content) {
  return {content.shape, std::move(content.initial), std::move(content.isObstacle), std::move(content.isSource)};
}

class Soil final : public turtle::EnvironmentProcess {
 public:
  Soil(SoilField field, const Configuration& configuration)
      : field_(std::move(field)),
        given_(configuration),
        diffusion_{.stepCount = static_cast<int>(configuration.integer("diffusionSteps")),
                   .tolerance = configuration.number("diffusionTolerance"),
                   .relaxation = configuration.number("relaxationFactor")},
        layers_{configuration.numbers("layerThicknesses"), configuration.numbers("geotropicAngles")},
        range_(configuration.numbers("concentrationRange")[1] - configuration.numbers("concentrationRange")[0]),
        depletes_(configuration.flag("depletion")) {
    layers_.angles.resize(layers_.thicknesses.size(), 0.0);
    if (diffusion_.stepCount < 0) {
      diffusion_.stepCount = kMostDiffusionSteps;
    }
  }

  [[nodiscard]] turtle::EnvironmentDescription describe() const override {
    return describeSoil(lengthUnit_, field_.isInSpace());
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> open(const turtle::EnvironmentContext& context) override {
    const auto up = upOf("soil", context.world);
    if (!up) {
      return up.error();
    }
    up_ = *up;
    lengthUnit_ = context.world.lengthUnit;
    if (hasRows(given_)) {
      const auto axes = gridAxesOf("soil", context.world);
      if (!axes) {
        return axes.error();
      }
      // the rows were checked when the process was made
      field_ = fieldOf(*readContent(given_, *axes));
    }
    field_.reset();
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> step(const turtle::QueryBatch& queries,
                                                             turtle::ReplyBatch& replies) override {
    field_.prepareToSpread(diffusion_);
    for (std::size_t query = 0; query < queries.size(); ++query) {
      setDirections(queries, query, replies);
    }
    field_.orGoBack(diffusion_.stepCount, [&] {
      shareOut(queries, replies);
      countAnswers(queries, replies);
      noteIfAllAreOutside("soil", field_.box(), lengthUnit_, queries, replies);
      field_.spread(diffusion_);
    });
    return std::nullopt;
  }

  [[nodiscard]] std::optional<turtle::EnvironmentError> tick(std::uint64_t) override {
    field_.orGoBack(diffusion_.stepCount, [&] { field_.spread(diffusion_); });
    return std::nullopt;
  }

  [[nodiscard]] std::vector<turtle::Field> fields() const override { return {field_.field("concentration", "1")}; }
  [[nodiscard]] std::string save() const override { return saveNumbers(field_.cells()); }
  [[nodiscard]] std::optional<turtle::EnvironmentError> restore(std::string_view state) override {
    return restoreNumbers(state, "soil", field_.cells());
  }

 private:
  /// All queries of a cell at once: all get what they want, or all the same share of it. An amount that is given off
  /// (negative) is there only for the next step.
  void shareOut(const turtle::QueryBatch& queries, turtle::ReplyBatch& replies) {
    struct Want {
      std::size_t cell;
      double amount;
      std::size_t query;
    };
    std::vector<Want> wants;
    for (std::size_t query = 0; query < queries.size(); ++query) {
      const auto parameters = queries.parametersOf(query);
      const auto cell = field_.cellOf(queries.position[query]);
      if (parameters.empty()) {
        continue;
      }
      if (!cell) {
        replies.set(queries, query, 0, 0.0);
      } else if (!depletes_) {
        replies.set(queries, query, 0, std::min(parameters[0], field_.cells()[*cell]));
      } else {
        wants.push_back({*cell, parameters[0], query});
      }
    }
    // sorted by amount, sums do not depend on the order of queries
    std::sort(wants.begin(), wants.end(),
              [](const Want& a, const Want& b) { return std::pair(a.cell, a.amount) < std::pair(b.cell, b.amount); });
    for (std::size_t begin = 0; begin < wants.size();) {
      double given = 0.0;
      double wanted = 0.0;
      std::size_t end = begin;
      for (; end < wants.size() && wants[end].cell == wants[begin].cell; ++end) {
        (wants[end].amount < 0.0 ? given : wanted) += wants[end].amount;
      }
      double& concentration = field_.cells()[wants[begin].cell];
      const double available = std::max(concentration, 0.0);
      const bool isEnough = wanted <= available;
      for (std::size_t k = begin; k < end; ++k) {
        const double amount = wants[k].amount;
        replies.set(queries, wants[k].query, 0, isEnough || amount < 0.0 ? amount : amount * (available / wanted));
      }
      concentration = (isEnough ? concentration - wanted : concentration - available) - given;
      begin = end;
    }
  }

  void setDirections(const turtle::QueryBatch& queries, std::size_t query, turtle::ReplyBatch& replies) const {
    const auto parameters = queries.parametersOf(query);
    const Vec3& position = queries.position[query];
    const Vec3& heading = queries.heading[query];
    if (parameters.size() > 1) {
      const double gradientWeight = parameters.size() > 2 ? parameters[2] : 0.0;
      Vec3 direction = geotropicDirection(position, heading) * parameters[1];
      if (const auto cell = field_.cellOf(position)) {
        direction = direction + gradientAt(*cell) * gradientWeight;
      }
      const std::array<double, 3> components{direction.x, direction.y, direction.z};
      for (std::size_t k = 1; k < std::min<std::size_t>(parameters.size(), 4); ++k) {
        replies.set(queries, query, k, components[k - 1]);
      }
    }
    answerAvoidance(field_, queries, query, replies);
  }

  [[nodiscard]] Vec3 gradientAt(std::size_t cell) const {
    const Vec3 differences = field_.differencesAt(cell);
    const Vec3 size = field_.cellSize();
    const Vec3 gradient{differences.x / size.x, differences.y / size.y, differences.z / size.z};
    return range_ == 0.0 ? gradient : gradient * (1.0 / range_);
  }

  /// Where gravity draws a root: down, turned towards the side to which it grows by the angle of its layer.
  [[nodiscard]] Vec3 geotropicDirection(const Vec3& position, const Vec3& heading) const {
    const Vec3 axis = core::cross(-up_, heading);
    if (!(core::length(axis) > 1e-9)) {
      return -up_;
    }
    const auto layer = layerOf(position);
    if (!layer) {
      return -up_;
    }
    return rotated(-up_, core::normalised(axis), layers_.angles[*layer] * std::numbers::pi / 180.0);
  }

  [[nodiscard]] std::optional<std::size_t> layerOf(const Vec3& position) const {
    // the highest corner of the box
    const Vec3& low = field_.shape().position;
    const Vec3& size = field_.shape().size;
    const Vec3 top = low + Vec3{up_.x > 0.0 ? size.x : 0.0, up_.y > 0.0 ? size.y : 0.0, up_.z > 0.0 ? size.z : 0.0};
    double depth = core::dot(top, up_) - core::dot(position, up_);
    for (std::size_t layer = 0; layer < layers_.thicknesses.size(); ++layer) {
      depth -= layers_.thicknesses[layer];
      if (depth < 0.0) {
        return layer;
      }
    }
    // the last layer goes on below
    return layers_.thicknesses.empty() ? std::nullopt : std::optional(layers_.thicknesses.size() - 1);
  }

  SoilField field_;
  Configuration given_;
  Diffusion diffusion_;
  Layers layers_;
  double range_;
  bool depletes_;
  Vec3 up_{0.0, 1.0, 0.0};
  std::string lengthUnit_ = "m";
};

ProcessOrErrors makeSoil(const Configuration& configuration) {
  const ConfigurationRows& rows = configuration.rows("concentration");
  const bool isCompatible = configuration.flag("compatible");
  if (configuration.numbers("layerThicknesses").size() < configuration.numbers("geotropicAngles").size() &&
      !isCompatible) {
    return refuse("soil",
                  "there are " + std::to_string(configuration.numbers("layerThicknesses").size()) +
                      " layer thicknesses and " + std::to_string(configuration.numbers("geotropicAngles").size()) +
                      " geotropic angles",
                  "give one angle for each layer");
  }
  if (configuration.number("relaxationFactor") > 1.0 && !isCompatible) {
    return refuse("soil", "'relaxationFactor' is above 1, so cells would give more than they hold",
                  "write a number from 0 to 1");
  }
  if (configuration.integer("diffusionSteps") < 0 && configuration.number("diffusionTolerance") == 0.0 &&
      !isCompatible) {
    return refuse("soil", "'diffusionSteps' is -1 and 'diffusionTolerance' is 0, so the diffusion would never end",
                  "give a number of steps, or a tolerance above 0");
  }
  const std::vector<double>& range = configuration.numbers("concentrationRange");
  if (!(range[0] < range[1])) {
    return refuse("soil", "'concentrationRange' must be a smaller and a larger number",
                  "gradients are relative to the difference of the two");
  }
  if (!rows.empty() && configuration.isGiven("gridSize")) {
    return refuse("soil", "both 'concentration' and 'gridSize' are given",
                  "the cells are those of 'concentration', or 'gridSize' of 'uniformConcentration'");
  }
  auto content = readContent(configuration, GridAxes{});
  if (!content) {
    return tl::unexpected(std::move(content.error()));
  }
  if (isCompatible) {
    return makePublishedSoil(
        {content->shape, std::move(content->initial), std::move(content->isObstacle), std::move(content->isSource)},
        configuration);
  }
  return std::make_unique<Soil>(fieldOf(std::move(*content)), configuration);
}

ConfigurationValues publishedDefaultsOfSoil() {
  return {{"domainSize", std::vector<double>{2.0, 2.0, 2.0}},
          {"position", std::vector<double>{-1.0, -1.0, -1.0}},
          {"uniformConcentration", 6.0},
          {"depletion", true},
          {"layerThicknesses", std::vector<double>{2.0}}};
}

}  // namespace

turtle::EnvironmentDescription describeSoil(const std::string& lengthUnit, bool isInSpace) {
  turtle::EnvironmentDescription description{.name = "soil",
                                             .summary = std::string(kSoilSummary),
                                             .needs = {.position = true, .heading = true, .parameters = true},
                                             .inputs = {{"desiredAmount", "1", ""},
                                                        {"gravityWeight", "1", ""},
                                                        {"gradientWeight", "1", ""},
                                                        {"unused", "1", ""},
                                                        {"segmentLength", lengthUnit, ""},
                                                        {"divergence", "degree", ""}},
                                             .outputs = {{"obtainedAmount", "1", ""},
                                                         {"directionX", "1", ""},
                                                         {"directionY", "1", ""},
                                                         {"directionZ", "1", ""}},
                                             .isStateful = true};
  if (isInSpace) {
    description.needs.left = true;
    description.outputs.push_back({"avoidanceX", "1", ""});
    description.outputs.push_back({"avoidanceY", "1", ""});
    description.outputs.push_back({"avoidanceZ", "1", ""});
  } else {
    description.outputs.push_back({"avoidanceAngle", "degree", ""});
  }
  return description;
}

extern constinit const ProcessEntry kSoilProcess{
    .name = "soil",
    .summary = kSoilSummary,
    .source =
        "Clausnitzer & Hopmans 1994, Simultaneous modeling of transient three-dimensional root growth and soil water "
        "flow; Mech & Prusinkiewicz 1996",
    .keys = kSoilKeys,
    .publishedKeywords = kSoilPublishedKeywords,
    .make = makeSoil,
    .publishedDefaults = publishedDefaultsOfSoil};

}  // namespace espalier::environment
