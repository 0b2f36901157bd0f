// Benchmarks of water and solutes in soil: M2.1 and M2.2 of Schnepf et al. 2020, steady flow above a water table,
// Gardner's soil, fronts of solutes. Lengths in cm, times in days.

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/validation/built_in_tables.h"
#include "clients/espalier/validation/reference_table.h"
#include "clients/espalier/validation/validation.h"
#include "environment/base/number_text.h"
#include "environment/soil/richards.h"
#include "environment/soil/solutes.h"

namespace espalier::validation {

namespace {

using environment::RichardsSolver;
using environment::SoilBorders;
using environment::SoilLayer;

struct NamedSoil {
  std::string name;
  SoilLayer soil;
};

// Vanderborght et al. 2005
const std::array<NamedSoil, 3> kSoils{NamedSoil{"sand", {0.045, 0.43, 0.15, 3.0, 1000.0, 1e-6}},
                                      NamedSoil{"loam", {0.08, 0.43, 0.04, 1.6, 50.0, 1e-6}},
                                      NamedSoil{"clay", {0.1, 0.4, 0.01, 1.1, 10.0, 1e-6}}};

const SoilLayer& soilOf(const std::string& name) {
  return std::find_if(kSoils.begin(), kSoils.end(), [&](const NamedSoil& one) { return one.name == name; })->soil;
}

/// A column of cells of the given heights, the lowest first.
RichardsSolver columnOf(const SoilLayer& soil, std::vector<double> heights, double head) {
  const std::size_t layers = heights.size();
  RichardsSolver solver({{1, 1}, layers, {1, 1}, std::move(heights)}, {soil}, std::vector<int>(layers, 0));
  for (std::size_t cell = 0; cell < layers; ++cell) {
    solver.setHead(cell, head);
  }
  return solver;
}

/// Cells that grow from the surface, `first` high there, to `largest`.
std::vector<double> gradedHeights(double depth, double first, double growth, double largest) {
  std::vector<double> heights;
  double sum = 0.0;
  for (double height = first; sum < depth; sum += heights.back(), height = std::min(height * growth, largest)) {
    heights.push_back(depth - sum < 1.5 * height ? depth - sum : height);
  }
  std::reverse(heights.begin(), heights.end());
  return heights;
}

/// False when a step does not converge.
bool letPass(RichardsSolver& solver, double days, const SoilBorders& borders, double timeTolerance) {
  while (days > 1e-12) {
    const double passed = solver.advance(days, borders, {1e-6, timeTolerance});
    if (!(passed > 0.0)) {
      return false;
    }
    days -= passed;
  }
  return true;
}

/// Depth at which the water content falls below a value, in cells of one height.
double depthOf(const RichardsSolver& solver, double height, double content) {
  const std::size_t layers = solver.cellCount();
  for (std::size_t i = 1; i < layers; ++i) {
    const double above = solver.contentOf(layers - i);
    const double below = solver.contentOf(layers - 1 - i);
    if (above >= content && below < content) {
      return (static_cast<double>(i) - 0.5 + (above - content) / (above - below)) * height;
    }
  }
  return NAN;
}

CaseResult infiltration(const Data& data, const std::string& name) {
  struct Run {
    std::string soil;
    std::array<double, 3> times;
    double contentBehind;  // where K is the rain, or θs
    double tolerance;      // of the depth
    std::optional<double> totalTolerance;
    std::string published;
    std::array<std::string, 3> ofWave;  // errors of programs against the published wave
  };
  const std::array<Run, 3> runs{
      Run{"sand",
          {0.1, 0.2, 0.3},
          0.2824,
          0.3,
          0.005,
          "best program 0.03",
          {"DuMux 0.0045, OpenSimRoot 0.0071, R-SWMS 0.0029, SRI 0.0107; converged solution 0.0053",
           "DuMux 0.0022, OpenSimRoot 0.0036, R-SWMS 0.0010, SRI 0.0046; converged solution 0.0027",
           "DuMux 0.0015, OpenSimRoot 0.0024, R-SWMS 0.0007, SRI 0.0031; converged solution 0.0018"}},
      Run{"loam",
          {0.2, 0.5, 1.0},
          0.43,
          0.3,
          0.005,
          "best program 0.03",
          {"DuMux 0.023, OpenSimRoot 0.031, R-SWMS 0.014, SRI 0.022; converged solution 0.023",
           "DuMux 0.010, OpenSimRoot 0.023, R-SWMS 0.001, SRI 0.012; converged solution 0.010",
           "DuMux 0.005, OpenSimRoot 0.016, R-SWMS 0.003, SRI 0.025; converged solution 0.005"}},
      Run{"clay",
          {0.1, 0.2, 0.5},
          0.4,
          1.0,
          std::nullopt,
          "best program 0.8",
          {"DuMux 0.110, OpenSimRoot 0.079, SRI 0.044; converged solution 0.132",
           "DuMux 0.060, OpenSimRoot 0.039, SRI 0.045; converged solution 0.073",
           "DuMux 0.025, OpenSimRoot 0.013, SRI 0.199; converged solution 0.032"}}};
  constexpr double kHeight = 0.5;
  CaseResult result;
  const auto reference = ReferenceTable::read(data, "m21_infiltration.tsv", result.missing);
  const auto totals = ReferenceTable::read(data, "m21_totals.tsv", result.missing);
  for (const Run& run : runs) {
    if (run.soil != name) {
      continue;
    }
    const SoilLayer& soil = soilOf(run.soil);
    const std::clock_t begin = std::clock();
    auto solver = columnOf(soil, std::vector<double>(400, kHeight), -400.0);
    const double stored = solver.storedWater();
    const double start = soil.content(-400.0);
    double day = 0.0;
    double difference = 0.0;
    int compared = 0;
    std::array<double, 3> middles{};
    LargestError worstTotal;
    std::vector<Row> ofWave;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!letPass(solver, run.times[k] - day, {.rain = 100.0, .driestHead = -1e6}, 1e-3)) {
        result.rows.push_back({run.soil + ", a time step converges", NAN, 0.0, ""});
        break;
      }
      day = run.times[k];
      middles[k] = depthOf(solver, kHeight, 0.5 * (start + run.contentBehind));
      Curve ours{run.soil + " " + std::to_string(run.times[k]).substr(0, 3) + " day", false, {}};
      Curve theirs{ours.name + ", converged", true, {}};
      for (std::size_t cell = solver.cellCount(); cell-- > 0;) {
        ours.points.emplace_back((static_cast<double>(solver.cellCount() - cell) - 0.5) * kHeight,
                                 solver.contentOf(cell));
      }
      std::vector<double> wave, found;
      for (std::size_t row = 0; reference && row < reference->rowCount(); ++row) {
        if (reference->text(row, "soil") == run.soil && reference->number(row, "time") == day) {
          const double depth = reference->number(row, "depth_converged");
          wave.push_back(reference->number(row, "depth_published"));
          found.push_back(depthOf(solver, kHeight, reference->number(row, "theta")));
          difference += std::abs(found.back() - depth);
          theirs.points.emplace_back(depth, reference->number(row, "theta"));
          ++compared;
        }
      }
      if (!wave.empty()) {
        ofWave.push_back(
            {run.soil + ", " + environment::numberText(day) + " day, depths against the published wave, nRMSE",
             normalisedError(wave, found), std::nullopt, run.ofWave[k]});
      }
      std::sort(theirs.points.begin(), theirs.points.end());
      result.across = "depth, cm";
      result.up = "water content";
      result.curves.push_back(std::move(ours));
      result.curves.push_back(std::move(theirs));
      for (std::size_t row = 0; totals && row < totals->rowCount(); ++row) {
        if (totals->text(row, "soil") == run.soil && totals->number(row, "time") == day) {
          const double expected = totals->number(row, "infiltrated");
          const double more =
              std::abs(solver.state().balance.infiltrated - expected) - totals->number(row, "uncertainty");
          worstTotal.add(std::max(more, 0.0) / expected);
        }
      }
    }
    if (compared > 0) {
      result.rows.push_back({run.soil + ", mean difference of the depths of the front, cm", difference / compared,
                             run.tolerance, run.published});
    }
    result.rows.insert(result.rows.end(), ofWave.begin(), ofWave.end());
    // behind the front of sand the soil is as wet as it lets the rain through
    const double behind = soil.headAt(run.contentBehind);
    const double speed =
        (std::min(soil.conductivityAt(behind), 100.0) - soil.conductivityAt(-400.0)) / (run.contentBehind - start);
    result.rows.push_back({run.soil + ", speed of the front, relative",
                           std::abs((middles[2] - middles[1]) / (run.times[2] - run.times[1]) / speed - 1.0), 0.005,
                           ""});
    if (totals) {
      result.rows.push_back({run.soil + ", infiltrated amount beyond its uncertainty, relative", worstTotal.value(),
                             run.totalTolerance, ""});
    }
    const auto& balance = solver.state().balance;
    result.rows.push_back({run.soil + ", balance of water, relative",
                           std::abs((stored + balance.infiltrated - balance.drained) / solver.storedWater() - 1.0),
                           1e-8, ""});
    result.rows.push_back({run.soil + ", time of the processor, s",
                           static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 10.0, ""});
  }
  return result;
}

CaseResult infiltrationIntoSand(const Data& data) {
  return infiltration(data, "sand");
}
CaseResult infiltrationIntoLoam(const Data& data) {
  return infiltration(data, "loam");
}
CaseResult infiltrationIntoClay(const Data& data) {
  return infiltration(data, "clay");
}

CaseResult evaporation(const Data& data) {
  struct Run {
    std::string soil, published;
    double potential, head, first;
  };
  const std::array<Run, 4> runs{Run{"sand", "DuMux 0.08, OpenSimRoot 0.38, R-SWMS 0.10, SRI 1.3", 0.1, -40.0, 0.002},
                                Run{"loam", "DuMux 0.05, OpenSimRoot 0.15, R-SWMS 0.06, SRI 0.05", 0.1, -200.0, 0.02},
                                Run{"loam", "DuMux 0.03, OpenSimRoot 0.23, R-SWMS 0.12, SRI 0.14", 0.3, -200.0, 0.02},
                                Run{"clay", "DuMux 0.04, OpenSimRoot 0.09, R-SWMS 0.08, SRI 0.03", 0.3, -200.0, 0.02}};
  CaseResult result;
  const auto given = ReferenceTable::read(data, "m22_evaporation.tsv", result.missing);
  const auto carried = ReferenceTable::read([](const std::string& name) { return builtInTable(name); },
                                            "m22_evaporation.tsv", result.missing);
  for (std::size_t scenario = 0; given && carried && scenario < runs.size(); ++scenario) {
    const Run& run = runs[scenario];
    // some tables of the benchmarks have no converged rates of the third scenario
    const std::vector<double> scenarios = given->column("scenario");
    const bool isGiven = std::ranges::count(scenarios, static_cast<double>(scenario + 1)) > 0;
    const ReferenceTable* reference = isGiven ? &*given : &*carried;
    auto solver = columnOf(soilOf(run.soil), gradedHeights(100.0, run.first, 1.1, 2.0), run.head);
    const double stored = solver.storedWater();
    const SoilBorders borders{
        .evaporation = run.potential, .driestHead = -10'000.0, .bottom = SoilBorders::Bottom::Closed};
    double day = 0.0;
    LargestError worst;
    std::vector<double> expected, found;
    const std::string name = run.soil + " " + std::to_string(run.potential).substr(0, 3) + " cm/day";
    Curve ours{name, false, {}};
    Curve theirs{name + ", converged", true, {}};
    for (std::size_t row = 0; row < reference->rowCount(); ++row) {
      if (reference->number(row, "scenario") != static_cast<double>(scenario + 1)) {
        continue;
      }
      const double time = reference->number(row, "time");
      if (time < day) {
        reference->refuse(row, "the time " + reference->text(row, "time") + " comes after " +
                                   environment::numberText(day) + ". Write the times of a scenario in ascending order");
      }
      const bool isDone = letPass(solver, time - day, borders, 1e-4);
      day = time;
      expected.push_back(reference->number(row, "rate_converged"));
      found.push_back(isDone ? -solver.surfaceFlux(solver.cellCount() - 1) : NAN);
      ours.points.emplace_back(day, found.back());
      theirs.points.emplace_back(day, expected.back());
      worst.add(std::abs(-solver.state().balance.infiltrated / reference->number(row, "cumulative_converged") - 1.0));
    }
    result.rows.push_back({name + ", nRMSE of the rate", normalisedError(expected, found), 0.03, run.published});
    result.rows.push_back({name + ", cumulative amount, relative", worst.value(), 0.02, ""});
    result.rows.push_back({name + ", balance of water, relative",
                           std::abs((stored + solver.state().balance.infiltrated) / solver.storedWater() - 1.0), 1e-8,
                           ""});
    result.across = "time, day";
    result.up = "evaporation, cm/day";
    result.curves.push_back(std::move(ours));
    result.curves.push_back(std::move(theirs));
  }
  return result;
}

/// Heads at the middles of cells of 1 cm above a water table, from dh/dz = q/K(h) − 1 by Runge and Kutta's method.
std::vector<double> steadyHeads(const SoilLayer& soil, double flow) {
  const auto slope = [&](double head) { return flow / soil.conductivityAt(head) - 1.0; };
  std::vector<double> heads;
  double head = 0.0;
  constexpr int kParts = 2000;  // of a cell: the first ones of sand are steep
  constexpr double kStep = 1.0 / kParts;
  for (int i = 0; i < 100 * kParts; ++i) {
    if (i % kParts == kParts / 2) {
      heads.push_back(head);
    }
    const double k1 = slope(head);
    const double k2 = slope(head + 0.5 * kStep * k1);
    const double k3 = slope(head + 0.5 * kStep * k2);
    const double k4 = slope(head + kStep * k3);
    head += kStep / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return heads;
}

CaseResult steady(const Data&) {
  struct Run {
    std::string soil;
    double flow;
  };
  CaseResult result;
  for (const Run& run :
       {Run{"sand", 10.0}, {"loam", 0.5}, {"loam", 5.0}, {"clay", 0.05}, {"loam", -0.02}, {"clay", -0.002}}) {
    const SoilLayer& soil = soilOf(run.soil);
    auto solver = columnOf(soil, std::vector<double>(100, 1.0), -30.0);
    const SoilBorders borders{.rain = std::max(run.flow, 0.0),
                              .evaporation = std::max(-run.flow, 0.0),
                              .driestHead = -15'000.0,
                              .bottom = SoilBorders::Bottom::Head};
    const bool isDone = letPass(solver, 1e5, borders, 1e-3);
    const std::vector<double> expected = steadyHeads(soil, run.flow);
    const double part = run.soil == "sand" ? 0.02 : 0.005;
    LargestError worst;
    const std::string name = run.soil + " " + environment::numberText(run.flow) + " cm/day";
    Curve ours{name, false, {}};
    Curve theirs{name + ", exact", true, {}};
    for (std::size_t cell = 0; cell < expected.size(); ++cell) {
      ours.points.emplace_back(static_cast<double>(cell) + 0.5, solver.state().heads[cell]);
      theirs.points.emplace_back(static_cast<double>(cell) + 0.5, expected[cell]);
      const double difference = std::abs(solver.state().heads[cell] - expected[cell]);
      worst.add(isDone ? difference / (0.1 + part * std::abs(expected[cell])) : NAN);
    }
    result.rows.push_back({run.soil + ", " + std::to_string(run.flow).substr(0, 6) +
                               " cm/day, heads in units of 0.1 cm + " + (part == 0.02 ? "2 %" : "0.5 %"),
                           worst.value(), 1.0, ""});
    result.across = "height above the water table, cm";
    result.up = "head, cm";
    result.curves.push_back(std::move(ours));
    result.curves.push_back(std::move(theirs));
  }
  return result;
}

/// K/Ks at a height, in units of 1/α, of a column of Gardner's soil above a water table, when the flow from above
/// changes from `before` to `after` (parts of Ks) at time 0 (Srivastava & Yeh 1991).
double relativeConductivity(double height, double time, double length, double before, double after) {
  const double steadyPart = after - (after - 1.0) * std::exp(-height);
  double sum = 0.0;
  for (int n = 1; n < 400; ++n) {
    // λ: tan(λL) = −2λ, one root in each ((n − 1/2)π, nπ)/L
    double low = (static_cast<double>(n) - 0.5) * std::numbers::pi / length + 1e-13;
    double high = static_cast<double>(n) * std::numbers::pi / length;
    const auto isPositive = [&](double x) { return std::sin(x * length) + 2.0 * x * std::cos(x * length) > 0.0; };
    const bool atLow = isPositive(low);
    for (int round = 0; round < 100; ++round) {
      const double middle = 0.5 * (low + high);
      (isPositive(middle) == atLow ? low : high) = middle;
    }
    const double root = 0.5 * (low + high);
    sum += std::sin(root * height) * std::sin(root * length) * std::exp(-root * root * time) /
           (1.0 + length / 2.0 + 2.0 * root * root * length);
  }
  return steadyPart - 4.0 * (after - before) * std::exp((length - height) / 2.0) * std::exp(-time / 4.0) * sum;
}

CaseResult gardner(const Data&) {
  // α 0.1/cm, Ks 1 cm/h, θs − θr 0.34, 100 cm
  const SoilLayer soil{0.06, 0.4, 0.1, 2.0, 24.0, 1e-9, SoilLayer::Function::Gardner};
  CaseResult result;
  for (const auto& [before, after] : {std::pair(0.1, 0.9), {0.9, 0.1}}) {
    auto solver = columnOf(soil, std::vector<double>(200, 0.5), -10.0);
    bool isDone = letPass(solver, 1000.0, {.rain = before * 24.0, .bottom = SoilBorders::Bottom::Head}, 1e-3);
    double hours = 0.0;
    LargestError worst;
    Picture picture{after > before ? "wetting" : "drying", "height above the water table, cm", "head, cm", {}};
    for (const double until : {1.0, 5.0, 10.0, 20.0, 50.0}) {
      isDone = isDone && letPass(solver, (until - hours) / 24.0,
                                 {.rain = after * 24.0, .bottom = SoilBorders::Bottom::Head}, 1e-5);
      hours = until;
      Curve ours{std::to_string(std::lround(hours)) + " h", false, {}};
      Curve theirs{ours.name + ", exact", true, {}};
      for (std::size_t cell = 0; cell < solver.cellCount(); ++cell) {
        const double height = (static_cast<double>(cell) + 0.5) * 0.5;
        const double expected =
            std::log(relativeConductivity(0.1 * height, 0.1 * hours / 0.34, 10.0, before, after)) / 0.1;
        worst.add(isDone ? std::abs(solver.state().heads[cell] - expected) : NAN);
        ours.points.emplace_back(height, solver.state().heads[cell]);
        theirs.points.emplace_back(height, expected);
      }
      picture.curves.push_back(std::move(ours));
      picture.curves.push_back(std::move(theirs));
    }
    result.rows.push_back({"flow from " + std::to_string(before).substr(0, 3) + " to " +
                               std::to_string(after).substr(0, 3) + " cm/h, heads, cm",
                           worst.value(), 0.1, ""});
    result.pictures.push_back(std::move(picture));
  }
  return result;
}

constexpr double kVelocity = 5.0;
constexpr double kDispersion = 5.0;

/// c/c₀ where the flow brings c₀ (Lindstrom et al. 1967) or the surface keeps it (Ogata & Banks 1961).
double breakthrough(bool hasFlow, double x, double t, double retardation) {
  const double width = 2.0 * std::sqrt(kDispersion * retardation * t);
  const double ahead = (retardation * x - kVelocity * t) / width;
  const double behind = (retardation * x + kVelocity * t) / width;
  // e^(vx/D) erfc(behind), whose factors go beyond all numbers
  const double reflected =
      std::erfc(behind) > 0.0 ? std::exp(kVelocity * x / kDispersion + std::log(std::erfc(behind))) : 0.0;
  if (!hasFlow) {
    return 0.5 * std::erfc(ahead) + 0.5 * reflected;
  }
  const double v2 = kVelocity * kVelocity * t / (kDispersion * retardation);
  return 0.5 * std::erfc(ahead) + std::sqrt(v2 / std::numbers::pi) * std::exp(-ahead * ahead) -
         0.5 * (1.0 + kVelocity * x / kDispersion + v2) * reflected;
}

CaseResult solutes(const Data&) {
  struct Run {
    bool hasFlow;
    double retardation, decay;
    std::vector<double> times;  // one of 30 days: the steady state
  };
  CaseResult result;
  constexpr double kHeight = 0.1;  // a tenth of the dispersivity
  constexpr double kContent = 0.4;
  for (const Run& run : {Run{true, 1.0, 0.0, {2, 4, 6}}, Run{true, 2.0, 0.0, {2, 4, 6}}, Run{false, 1.0, 0.0, {4}},
                         Run{true, 1.0, 0.1, {30}}, Run{true, 1.0, 0.5, {30}}}) {
    const SoilLayer soil{0.0, kContent, 0.04, 1.6, kVelocity * kContent, 1e-9};
    auto water = columnOf(soil, std::vector<double>(600, kHeight), 0.0);
    environment::SoluteTransport transport({{.rainConcentration = 1.0,
                                             .dispersivity = kDispersion / kVelocity,
                                             .sorption = kContent * (run.retardation - 1.0),
                                             .decayRate = run.decay}},
                                           water, !run.hasFlow);
    double day = 0.0;
    bool isDone = true;
    LargestError worst;
    const std::string subject = std::string(run.hasFlow ? "flow" : "surface") + " R" +
                                std::to_string(run.retardation).substr(0, 1) +
                                (run.decay > 0.0 ? " decay " + std::to_string(run.decay).substr(0, 3) : "");
    for (const double until : run.times) {
      while (until - day > 1e-12 && isDone) {
        const std::vector<double> before = water.state().contents;
        const double passed = water.advance(until - day, {.hasTopHead = true}, {1e-9, 1e-3});
        isDone = passed > 0.0 && transport.follow(passed, before);
        day += passed;
      }
      Curve ours{subject + " day " + std::to_string(std::lround(day)), false, {}};
      Curve theirs{ours.name + ", exact", true, {}};
      for (double x = kHeight / 2.0; x < 45.0; x += kHeight) {
        const auto cell = water.cellCount() - 1 - static_cast<std::size_t>(x / kHeight);
        const double u = kVelocity * std::sqrt(1.0 + 4.0 * run.decay * kDispersion / (kVelocity * kVelocity));
        const double expected =
            run.decay > 0.0 ? 2.0 * kVelocity / (kVelocity + u) * std::exp((kVelocity - u) * x / (2.0 * kDispersion))
                            : breakthrough(run.hasFlow, x, day, run.retardation);
        ours.points.emplace_back(x, transport.concentration(0, cell, water.contentOf(cell)));
        theirs.points.emplace_back(x, expected);
        worst.add(isDone ? std::abs(ours.points.back().second - expected) : NAN);
      }
      result.across = "depth, cm";
      result.up = "concentration, parts of that at the surface";
      result.curves.push_back(std::move(ours));
      result.curves.push_back(std::move(theirs));
    }
    result.rows.push_back({std::string(run.hasFlow ? "flow brings c₀" : "surface keeps c₀") + ", retardation " +
                               std::to_string(run.retardation).substr(0, 1) + ", decay " +
                               std::to_string(run.decay).substr(0, 3) + "/day, c/c₀",
                           worst.value(), 0.01, ""});
  }
  return result;
}

constexpr std::array kSoilCases{
    Case{"m2.1-sand", "infiltration into sand (Schnepf et al. 2020; Vanderborght et al. 2005), cells of 0.5 cm", true,
         infiltrationIntoSand},
    Case{"m2.1-loam", "the same into loam", true, infiltrationIntoLoam},
    Case{"m2.1-clay", "the same into clay", true, infiltrationIntoClay},
    Case{"m2.2", "evaporation from a bare soil (Schnepf et al. 2020), graded cells", true, evaporation},
    Case{"steady", "steady flow above a water table: dh/dz = q/K − 1, cells of 1 cm", true, steady},
    Case{"gardner", "transient flow in Gardner's soil (Srivastava & Yeh 1991), cells of 0.5 cm", true, gardner},
    Case{"solutes", "fronts of solutes (Lindstrom et al. 1967; Ogata & Banks 1961; van Genuchten & Alves 1982)", true,
         solutes},
};

}  // namespace

std::span<const Case> soilCases() {
  return kSoilCases;
}

}  // namespace espalier::validation
