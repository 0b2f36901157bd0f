// Benchmarks of roots and soil together: C1.1 and C1.2 of Schnepf et al. 2020, by the process `xylem`.

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <memory>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/validation/reference_table.h"
#include "clients/espalier/validation/root_tables.h"
#include "clients/espalier/validation/validation.h"
#include "engine/turtle/environment_process.h"
#include "engine/turtle/field.h"
#include "engine/turtle/scene/geometry.h"
#include "environment/hydraulics/rhizosphere.h"
#include "environment/registry.h"
#include "environment/soil/flux_potential.h"

namespace espalier::validation {

namespace {

using environment::SoilLayer;

constexpr std::size_t kUptake = 4, kCollarFlow = 6;

/// A process with roots that do not grow: segments, and a query behind each.
class StandingRoots {
 public:
  StandingRoots(const std::string& configuration, double stepDays, const core::Vec3& up) : stepDays_(stepDays) {
    auto made = environment::makeProcess("xylem", configuration);
    turtle::EnvironmentContext context;
    context.world.lengthUnit = "cm";
    context.world.up = up;
    context.world.stepDurationDays = stepDays;
    if (made && !(*made)->open(context)) {
      process_ = std::move(*made);
    }
    queries_.parameterOffset.push_back(0);
  }
  [[nodiscard]] bool isOpen() const { return process_ != nullptr; }

  void segment(const core::Vec3& from, const core::Vec3& to, double radius, double age, double order) {
    geometry_.start.push_back(from);
    geometry_.end.push_back(to);
    geometry_.startWidth.push_back(2.0 * radius);
    geometry_.endWidth.push_back(2.0 * radius);
    geometry_.segments.plant.push_back(0);
    geometry_.segments.module.push_back(2 * queries_.plant.size());
    geometry_.segments.symbol.push_back(1);
    geometry_.segments.colour.push_back(0);
    geometry_.segments.branchOrder.push_back(0);
    queries_.module.push_back(2 * queries_.plant.size() + 1);
    queries_.plant.push_back(0);
    queries_.symbol.push_back(0);
    queries_.isTransient.push_back(0);
    queries_.position.push_back(to);
    std::array<double, 10> parameters{age, order};
    queries_.parameters.insert(queries_.parameters.end(), parameters.begin(), parameters.end());
    queries_.parameterOffset.push_back(queries_.parameters.size());
  }

  /// Lets a step pass; false when it fails.
  [[nodiscard]] bool step() {
    if (!queries_.geometry) {
      queries_.geometry = std::make_shared<turtle::Geometry>(geometry_);
    }
    queries_.timeDays = static_cast<double>(queries_.step) * stepDays_;
    replies_.prepare(queries_);
    const auto error = process_->step(queries_, replies_);
    ++queries_.step;
    failure_ = error ? error->message : "";
    return !error;
  }
  /// Why the last step failed.
  [[nodiscard]] const std::string& failure() const { return failure_; }
  [[nodiscard]] double reply(std::size_t segment, std::size_t k) const {
    return replies_.values[queries_.parameterOffset[segment] + k];
  }
  /// Integral of a quantity of the soil over its box.
  [[nodiscard]] double integral(const std::string& name) const {
    double sum = 0.0;
    for (const turtle::Field& field : process_->fields()) {
      for (const double value : field.name == name ? field.values : std::vector<double>()) {
        sum += value * field.cellSize.x * field.cellSize.y * field.cellSize.z;
      }
    }
    return sum;
  }
  /// The first value of a quantity of the soil.
  [[nodiscard]] double first(const std::string& name) const {
    for (const turtle::Field& field : process_->fields()) {
      if (field.name == name) {
        return field.values.front();
      }
    }
    return NAN;
  }

 private:
  double stepDays_;
  std::unique_ptr<turtle::EnvironmentProcess> process_;
  turtle::Geometry geometry_;
  turtle::QueryBatch queries_;
  turtle::ReplyBatch replies_;
  std::string failure_;
};

std::string text(double number) {
  std::ostringstream out;
  out.precision(17);
  out << number;
  return out.str();
}

std::string layerText(const SoilLayer& soil) {
  return "[[1000," + text(soil.residualContent) + "," + text(soil.saturatedContent) + "," + text(soil.alpha) + "," +
         text(soil.n) + "," + text(soil.conductivity) + "]]";
}

constexpr SoilLayer kLoam{0.08, 0.43, 0.04, 1.6, 50.0, 1e-6};
constexpr SoilLayer kClay{0.1, 0.4, 0.01, 1.1, 10.0, 1e-6};
constexpr SoilLayer kSand{0.045, 0.43, 0.15, 3.0, 1000.0, 1e-6};

constexpr double kRoot = 0.02;
constexpr double kOuter = 0.6;
constexpr double kDry = -15'000.0;
/// Side of a cell that has the volume of the cylinder of soil around the root.
double sideOfCell() {
  return std::sqrt(std::numbers::pi * (kOuter * kOuter - kRoot * kRoot));
}

/// One root in a cell of soil, which asks for a flow; the root itself does not resist.
StandingRoots rootInCell(const SoilLayer& layer, double flow, double stepDays) {
  const double side = sideOfCell();
  StandingRoots roots(R"({"transpiration":[[0,)" + text(flow) + R"(]],"lowestHead":)" + text(kDry) +
                          R"(,"kr":1000,"kx":1000000,"soil":[{"type":"soil-water","gridSize":[1,1,1],"cellSize":[)" +
                          text(side) + ",1," + text(side) +
                          R"(],"position":[0,-1,0],"bottom":"closed","initialHead":-100,"layers":)" + layerText(layer) +
                          "}]}",
                      stepDays, {0, 1, 0});
  roots.segment({0.5 * side, 0, 0.5 * side}, {0.5 * side, -1, 0.5 * side}, kRoot, 0, 1);
  return roots;
}

CaseResult oneRoot(const Data&) {
  struct Run {
    std::string soil;
    const SoilLayer* layer;
    double q, onset, tolerance;
    std::string published, publishedHeads;
  };
  const std::array<Run, 4> runs{
      Run{"loam", &kLoam, 0.1, 9.98, 0.05, "DuMux 0.002, OpenSimRoot 0.116, R-SWMS 0.022",
          "nRMSE: DuMux 0.11, OpenSimRoot 0.40, R-SWMS 0.16"},
      Run{"loam", &kLoam, 0.05, 20.935, 0.05, "DuMux 0.001, OpenSimRoot 0.105, R-SWMS 0.018", ""},
      Run{"clay", &kClay, 0.1, 8.525, 0.01, "DuMux 0.022, OpenSimRoot 0.084, R-SWMS 0.011",
          "nRMSE: DuMux 0.057, OpenSimRoot 0.034, R-SWMS 0.007"},
      Run{"clay", &kClay, 0.05, 17.47, 0.01, "DuMux 0.012, OpenSimRoot 0.078, R-SWMS 0.008", ""}};
  CaseResult result;
  for (const Run& run : runs) {
    const double flow = run.q * 2.0 * std::numbers::pi * kRoot;
    const double stepDays = run.onset / 5000.0;
    StandingRoots roots = rootInCell(*run.layer, flow, stepDays);
    double day = 0.0;
    double cell = -100.0;
    const std::string name = run.soil + (run.q == 0.1 ? " 0.1 cm/day" : " 0.05 cm/day");
    for (; day < 2.0 * run.onset; day += stepDays) {
      if (!roots.step()) {
        result.rows.push_back({name + ", " + roots.failure(), NAN, 0.0, ""});
        break;
      }
      if (roots.reply(0, kCollarFlow) < (1.0 - 1e-6) * flow) {
        break;
      }
      cell = roots.first("pressureHead");
    }
    result.rows.push_back({name + ", onset of stress, relative", std::abs(day / run.onset - 1.0), 0.02, run.published});
    // Φ(r) − Φ(root) = q a [(r²/a² − 1)/(2(1 − ρ²)) − ρ²/(1 − ρ²) ln(r/a)] at a steady rate (Schröder et al. 2008)
    const environment::FluxPotential potential(*run.layer);
    const double square = kOuter * kOuter / (kRoot * kRoot);
    const double atRoot =
        potential.at(cell) - flow * environment::annulusFactor(kOuter / kRoot) / (2.0 * std::numbers::pi);
    LargestError worst;
    Curve ours{name, false, {}};
    Curve theirs{name + ", exact", true, {}};
    for (const double r : {0.05, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6}) {
      const double part = r * r / (kRoot * kRoot);
      const double rise =
          run.q * kRoot * ((part - 1.0) / (2.0 * (1.0 - square)) - square / (1.0 - square) * std::log(r / kRoot));
      // at the onset the root surface is as dry as it becomes
      const double expected = potential.headAt(potential.at(kDry) + rise);
      ours.points.emplace_back(r, potential.headAt(atRoot + rise));
      theirs.points.emplace_back(r, expected);
      worst.add(std::abs(ours.points.back().second / expected - 1.0));
    }
    result.across = "distance from the middle of the root, cm";
    result.up = "head in the soil at the onset of stress, cm";
    result.curves.push_back(std::move(ours));
    result.curves.push_back(std::move(theirs));
    result.rows.push_back(
        {name + ", heads from 0.05 cm at the onset, relative", worst.value(), run.tolerance, run.publishedHeads});
  }
  // sand lets so little through that the root is under stress at once
  for (const double q : {0.1, 0.05}) {
    const double flow = q * 2.0 * std::numbers::pi * kRoot;
    constexpr double kStepDays = 0.0005;
    StandingRoots roots = rootInCell(kSand, flow, kStepDays);
    double day = 0.0;
    while (day < 0.1 && roots.step() && roots.reply(0, kCollarFlow) >= (1.0 - 1e-6) * flow) {
      day += kStepDays;
    }
    result.rows.push_back({"sand " + std::string(q == 0.1 ? "0.1" : "0.05") + " cm/day, onset of stress, day",
                           roots.failure().empty() ? day : NAN, 0.001, ""});
  }
  return result;
}

/// Uptake of a root system from each centimetre of depth, in the course of time.
class SinksByDepth {
 public:
  /// `roots`: the nodes; each that has a parent is a segment, in their order.
  explicit SinksByDepth(const ReferenceTable& roots) {
    for (std::size_t row = 0; row < roots.rowCount(); ++row) {
      if (const auto parent = parentOf(roots, row, "parent")) {
        const double depth = -0.5 * (roots.number(row, "z") + roots.number(*parent, "z"));
        layers_.push_back(static_cast<std::size_t>(std::clamp(depth, 0.0, kDepth - 0.5)));
      }
    }
  }

  /// Takes the uptake of the step that ends at `day`.
  void add(const StandingRoots& roots, double day) {
    std::vector<double> sums(static_cast<std::size_t>(kDepth), 0.0);
    for (std::size_t segment = 0; segment < layers_.size(); ++segment) {
      sums[layers_[segment]] += roots.reply(segment, kUptake);
    }
    days_.push_back(day);
    sums_.push_back(std::move(sums));
  }

  /// Compares with the published ones at their times: rows and a picture of the first noon and the last.
  void compare(const ReferenceTable& published, const std::string& name, CaseResult& result) const {
    std::vector<double> expected, found;
    Picture picture{"sinks", "depth, cm", "uptake from each cm of depth, cm³/day", {}};
    const std::size_t count = static_cast<std::size_t>(kDepth);
    for (std::size_t row = 0; row < published.rowCount(); ++row) {
      const double day = published.number(row, "time");
      Curve ours{text(day) + " day", false, {}};
      Curve theirs{text(day) + " day, published", true, {}};
      for (std::size_t layer = 0; layer < count; ++layer) {
        const double depth = static_cast<double>(layer) + 0.5;
        expected.push_back(published.number(row, text(-depth)));
        found.push_back(between(day, layer));
        ours.points.emplace_back(depth, found.back());
        theirs.points.emplace_back(depth, expected.back());
      }
      if (day == 0.25 || day == 0.5 || day == 1.0 || day == 2.5) {
        picture.curves.push_back(std::move(ours));
        picture.curves.push_back(std::move(theirs));
      }
    }
    result.rows.push_back({name + ", sinks by depth, nRMSE", normalisedError(expected, found), std::nullopt, ""});
    result.pictures.push_back(std::move(picture));
  }

 private:
  static constexpr double kDepth = 15.0;

  /// Between the steps before and after a day: the uptake of a step is that of its middle.
  [[nodiscard]] double between(double day, std::size_t layer) const {
    std::vector<std::pair<double, double>> points;
    for (std::size_t step = 0; step < days_.size(); ++step) {
      points.emplace_back(days_[step] - 0.5 * days_[0], sums_[step][layer]);
    }
    return interpolate(points, day);
  }

  std::vector<std::size_t> layers_;        // of a segment
  std::vector<double> days_;               // when the steps end
  std::vector<std::vector<double>> sums_;  // (step, layer), cm³/day
};

/// The tables of C1.2.
struct DryingSoil {
  RootTable roots;
  ReferenceTable transpiration;
  std::optional<ReferenceTable> sinks;
};

std::optional<DryingSoil> readDryingSoil(const Data& data, CaseResult& result) {
  auto roots = readRootTable(data, "c12_roots", result.missing);
  auto transpiration = ReferenceTable::read(data, "c12_transpiration.tsv", result.missing);
  if (!roots || !transpiration) {
    return std::nullopt;
  }
  return DryingSoil{std::move(*roots), std::move(*transpiration), std::nullopt};
}

/// The keys of xylem for conductivities: constant ones, or rows by order and age.
std::string conductivityKeys(const ReferenceTable* ages) {
  if (ages == nullptr) {
    return R"("kx":0.0432,"kr":0.0001728)";
  }
  std::string keys;
  for (const std::string column : {"kx", "kr"}) {
    keys += (keys.empty() ? "\"" : ",\"") + column + R"(Table":[)";
    for (std::size_t row = 0; row < ages->rowCount(); ++row) {
      keys += (row == 0 ? "[" : ",[") + ages->text(row, "order") + "," + ages->text(row, "age") + "," +
              ages->text(row, column) + "]";
    }
    keys += "]";
  }
  return keys;
}

/// The root system of C1.2 in soil with cells of one size, hydrostatic with −659.8 cm at the surface.
StandingRoots rootsInBox(const ReferenceTable& table, const ReferenceTable* ages, double size) {
  const std::string side = std::to_string(std::lround(8.0 / size));
  StandingRoots roots(
      "{" + conductivityKeys(ages) + R"(,"transpiration":[[0,6.4]],"dayCourse":true,"lowestHead":-15290,)" +
          R"("soil":[{"type":"soil-water","gridSize":[)" + side + "," + side + "," +
          std::to_string(std::lround(15.0 / size)) + R"(],"cellSize":[)" + text(size) + "," + text(size) + "," +
          text(size) +
          R"(],"position":[-4,-4,-15],"bottom":"closed","initially":"waterTable","waterTableDepth":659.8,)" +
          R"("layers":)" + layerText(kLoam) + "}]}",
      1.0 / 48.0, {0, 0, 1});
  const auto place = [&](std::size_t row) {
    return core::Vec3{table.number(row, "x"), table.number(row, "y"), table.number(row, "z")};
  };
  for (std::size_t row = 0; row < table.rowCount(); ++row) {
    if (const auto parent = parentOf(table, row, "parent")) {
      roots.segment(place(*parent), place(row), table.number(row, "radius"),
                    ages == nullptr ? 8.0 : 8.0 - table.number(row, "emergence"), table.number(row, "order"));
    }
  }
  return roots;
}

/// Benchmark C1.2 with cells of one size; with `ages` by conductivities of order and age.
void addDryingSoil(const DryingSoil& data, const ReferenceTable* ages, double size, std::optional<double> tolerance,
                   CaseResult& result) {
  const ReferenceTable& table = data.roots.nodes;
  StandingRoots roots = rootsInBox(table, ages, size);
  const std::string name = std::string(ages == nullptr ? "a" : "b") + ", cells of " + text(size) + " cm";
  if (!roots.isOpen()) {
    result.rows.push_back({name + ", the soil opens", NAN, 0.0, ""});
    return;
  }
  const std::clock_t begin = std::clock();
  const double stored = roots.integral("waterContent");
  double taken = 0.0;
  SinksByDepth sinks(table);
  Curve ours{name, false, {{0.0, 0.0}}};
  for (int step = 0; step < 3 * 48; ++step) {
    if (!roots.step()) {
      result.rows.push_back({name + ", " + roots.failure(), NAN, 0.0, ""});
      return;
    }
    taken += roots.reply(0, kCollarFlow) / 48.0;
    ours.points.emplace_back((step + 1) / 48.0, taken);
    sinks.add(roots, (step + 1) / 48.0);
  }
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::vector<double> expected, found;
  for (std::size_t row = 0; row < data.transpiration.rowCount(); ++row) {
    expected.push_back(data.transpiration.number(row, "cumulative"));
    found.push_back(interpolate(ours.points, data.transpiration.number(row, "time")));
  }
  if (ages == nullptr) {
    result.rows.push_back({name + ", nRMSE of the cumulative uptake", normalisedError(expected, found), tolerance,
                           "DuMux kernel 0.037, CPlantBox-DuMux 0.103, OpenSimRoot 0.208, R-SWMS 0.55, SRI 0.56"});
  }
  result.rows.push_back({name + ", uptake in three days, cm3 (reference of a: 3.470)", taken, std::nullopt, ""});
  result.rows.push_back({name + ", balance of water, relative",
                         std::abs((stored - taken) / roots.integral("waterContent") - 1.0), 1e-8, ""});
  if (ages == nullptr && size == 1.0) {
    result.rows.push_back({name + ", time of the processor, s", seconds, 10.0, ""});
  }
  if (data.sinks) {
    sinks.compare(*data.sinks, name, result);
  }
  result.across = "time, day";
  result.up = "uptake since the beginning, cm³";
  result.curves.push_back(std::move(ours));
  Curve reference{name + ", published", true, {}};
  for (std::size_t row = 0; ages == nullptr && row < data.transpiration.rowCount(); ++row) {
    reference.points.emplace_back(data.transpiration.number(row, "time"), expected[row]);
  }
  if (!reference.points.empty()) {
    result.curves.push_back(std::move(reference));
  }
}

CaseResult dryingSoil(const Data& data) {
  CaseResult result;
  if (auto tables = readDryingSoil(data, result)) {
    tables->sinks = ReferenceTable::read(data, "c12_sinks.tsv", result.missing);
    addDryingSoil(*tables, nullptr, 1.0, 0.12, result);
  }
  return result;
}

CaseResult dryingSoilFine(const Data& data) {
  CaseResult result;
  if (auto tables = readDryingSoil(data, result)) {
    tables->sinks = ReferenceTable::read(data, "c12_sinks.tsv", result.missing);
    addDryingSoil(*tables, nullptr, 0.5, 0.15, result);
  }
  return result;
}

CaseResult dryingSoilByAge(const Data& data) {
  CaseResult result;
  const auto tables = readDryingSoil(data, result);
  if (tables && !tables->roots.hasDays) {
    result.missing.emplace_back("the function 'emergence_time' in c12_roots.rsml");
    return result;
  }
  const auto ages = ReferenceTable::read(data, "root_conductivities.tsv", result.missing);
  if (tables && ages) {
    addDryingSoil(*tables, &*ages, 1.0, std::nullopt, result);
  }
  return result;
}

constexpr std::array kUptakeCases{
    Case{"c1.1", "stress around one root (Schnepf et al. 2020; Schröder et al. 2008)", true, oneRoot},
    Case{"c1.2", "a root system in drying soil (Schnepf et al. 2020), cells of 1 cm", true, dryingSoil},
    Case{"c1.2-fine", "the same with cells of 0.5 cm", true, dryingSoilFine},
    Case{"c1.2-ages", "the same with conductivities by order and age, cells of 1 cm", true, dryingSoilByAge},
};

}  // namespace

std::span<const Case> uptakeCases() {
  return kUptakeCases;
}

}  // namespace espalier::validation
