// Benchmarks of roots and soil together: C1.1 and C1.2 of Schnepf et al. 2020, by the process `xylem`.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <sstream>

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

constexpr std::size_t kExchange = 4, kCollarFlow = 6;

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
    for (const double r : {0.05, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6}) {
      const double part = r * r / (kRoot * kRoot);
      const double rise =
          run.q * kRoot * ((part - 1.0) / (2.0 * (1.0 - square)) - square / (1.0 - square) * std::log(r / kRoot));
      // at the onset the root surface is as dry as it becomes
      const double expected = potential.headAt(potential.at(kDry) + rise);
      worst.add(std::abs(potential.headAt(atRoot + rise) / expected - 1.0));
    }
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

/// Benchmark C1.2 with cells of one size; with `ages` by conductivities of order and age.
void addDryingSoil(const ReferenceTable& table, const ReferenceTable* ages, const ReferenceTable& transpiration,
                   double size, std::optional<double> tolerance, CaseResult& result) {
  const std::string cells = std::to_string(std::lround(8.0 / size)) + "," + std::to_string(std::lround(8.0 / size)) +
                            "," + std::to_string(std::lround(15.0 / size));
  std::string conductivities = R"("kx":0.0432,"kr":0.0001728)";
  if (ages != nullptr) {
    conductivities.clear();
    for (const std::string column : {"kx", "kr"}) {
      conductivities += (conductivities.empty() ? "\"" : ",\"") + column + R"(Table":[)";
      for (std::size_t row = 0; row < ages->rowCount(); ++row) {
        conductivities += (row == 0 ? "[" : ",[") + ages->text(row, "order") + "," + ages->text(row, "age") + "," +
                          ages->text(row, column) + "]";
      }
      conductivities += "]";
    }
  }
  // hydrostatic, −659.8 cm at the surface
  StandingRoots roots(
      "{" + conductivities + R"(,"transpiration":[[0,6.4]],"dayCourse":true,"lowestHead":-15290,)" +
          R"("soil":[{"type":"soil-water","gridSize":[)" + cells + R"(],"cellSize":[)" + text(size) + "," + text(size) +
          "," + text(size) +
          R"(],"position":[-4,-4,-15],"bottom":"closed","initially":"waterTable","waterTableDepth":659.8,)" +
          R"("layers":)" + layerText(kLoam) + "}]}",
      1.0 / 48.0, {0, 0, 1});
  const auto place = [&](std::size_t row) {
    return core::Vec3{table.number(row, "x"), table.number(row, "y"), table.number(row, "z")};
  };
  for (std::size_t row = 0; row < table.rowCount(); ++row) {
    if (const auto parent = parentOf(table, row, "parent")) {
      roots.segment(place(*parent), place(row), table.number(row, "radius"), 8.0 - table.number(row, "emergence"),
                    table.number(row, "order"));
    }
  }
  const std::string name = std::string(ages == nullptr ? "a" : "b") + ", cells of " + text(size) + " cm";
  if (!roots.isOpen()) {
    result.rows.push_back({name + ", the soil opens", NAN, 0.0, ""});
    return;
  }
  const double stored = roots.integral("waterContent");
  double taken = 0.0;
  Curve ours{name, false, {{0.0, 0.0}}};
  for (int step = 0; step < 3 * 48; ++step) {
    if (!roots.step()) {
      result.rows.push_back({name + ", " + roots.failure(), NAN, 0.0, ""});
      return;
    }
    taken += roots.reply(0, kCollarFlow) / 48.0;
    ours.points.emplace_back((step + 1) / 48.0, taken);
  }
  std::vector<double> expected, found;
  for (std::size_t row = 0; row < transpiration.rowCount(); ++row) {
    expected.push_back(transpiration.number(row, "cumulative"));
    found.push_back(interpolate(ours.points, transpiration.number(row, "time")));
  }
  if (ages == nullptr) {
    result.rows.push_back({name + ", nRMSE of the cumulative uptake", normalisedError(expected, found), tolerance,
                           "DuMux kernel 0.037, CPlantBox-DuMux 0.103, OpenSimRoot 0.208, R-SWMS 0.55, SRI 0.56"});
  }
  result.rows.push_back({name + ", uptake in three days, cm3 (reference of a: 3.470)", taken, std::nullopt, ""});
  result.rows.push_back({name + ", balance of water, relative",
                         std::abs((stored - taken) / roots.integral("waterContent") - 1.0), 1e-8, ""});
  result.across = "time, day";
  result.up = "uptake since the beginning, cm³";
  result.curves.push_back(std::move(ours));
}

CaseResult dryingSoil(const Data& data) {
  CaseResult result;
  const auto roots = ReferenceTable::read(data, "c12_roots.tsv", result.missing);
  const auto transpiration = ReferenceTable::read(data, "c12_transpiration.tsv", result.missing);
  if (roots && transpiration) {
    addDryingSoil(*roots, nullptr, *transpiration, 1.0, 0.12, result);
    Curve reference{"reference", true, {}};
    for (std::size_t row = 0; row < transpiration->rowCount(); ++row) {
      reference.points.emplace_back(transpiration->number(row, "time"), transpiration->number(row, "cumulative"));
    }
    result.curves.push_back(std::move(reference));
  }
  return result;
}

CaseResult dryingSoilFine(const Data& data) {
  CaseResult result;
  const auto roots = ReferenceTable::read(data, "c12_roots.tsv", result.missing);
  const auto transpiration = ReferenceTable::read(data, "c12_transpiration.tsv", result.missing);
  if (roots && transpiration) {
    addDryingSoil(*roots, nullptr, *transpiration, 0.5, 0.15, result);
  }
  return result;
}

CaseResult dryingSoilByAge(const Data& data) {
  CaseResult result;
  const auto roots = ReferenceTable::read(data, "c12_roots.tsv", result.missing);
  const auto transpiration = ReferenceTable::read(data, "c12_transpiration.tsv", result.missing);
  const auto ages = ReferenceTable::read(data, "root_conductivities.tsv", result.missing);
  if (roots && transpiration && ages) {
    addDryingSoil(*roots, &*ages, *transpiration, 1.0, std::nullopt, result);
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
