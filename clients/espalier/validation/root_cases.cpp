// Benchmarks of water in the xylem: M3.1 and M3.2 of Schnepf et al. 2020, closed forms of one root, size.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <string>

#include "clients/espalier/validation/reference_table.h"
#include "clients/espalier/validation/root_tables.h"
#include "clients/espalier/validation/validation.h"
#include "environment/hydraulics/hydraulic_tree.h"

namespace espalier::validation {

namespace {

using environment::HydraulicTree;

struct SingleRoot {
  double length, radius, kx, kr, soilHead, collar;
};

/// A root straight down in equal parts.
HydraulicTree straightRoot(const SingleRoot& root, std::uint32_t parts) {
  std::vector<HydraulicTree::Node> nodes(1);
  for (std::uint32_t i = 0; i < parts; ++i) {
    nodes.push_back({i, root.length / parts, -root.length / parts, root.radius, root.kx, root.kr, root.soilHead});
  }
  return HydraulicTree(std::move(nodes));
}

/// u = ψ − ψs obeys u'' = τ² u with u' = 1 at the tip (no flow, gravity) and the collar's head at the top.
double headOf(const SingleRoot& root, double depth) {
  const double tau = std::sqrt(2.0 * std::numbers::pi * root.radius * root.kr / root.kx);
  const double whole = std::cosh(tau * root.length);
  return root.soilHead + (root.collar - root.soilHead) * std::cosh(tau * (root.length - depth)) / whole +
         std::sinh(tau * depth) / (tau * whole);
}

CaseResult singleRoot(const Data&) {
  CaseResult result;
  const std::array<SingleRoot, 3> roots{SingleRoot{50, 0.2, 0.0432, 0.000173, -200, -1000},
                                        SingleRoot{50, 0.05, 0.00432, 0.00173, -200, -1000},
                                        SingleRoot{20, 0.02, 0.0004, 0.00411, -3000, -8000}};
  for (std::size_t k = 0; k < roots.size(); ++k) {
    LargestError worst;
    Curve ours{"parameters " + std::to_string(k + 1), false, {}};
    Curve theirs{ours.name + ", closed form", true, {}};
    for (const std::uint32_t parts : {1U, 10U, 500U}) {
      const auto flow = straightRoot(roots[k], parts).solve({.head = roots[k].collar});
      for (std::uint32_t i = 0; i <= parts; ++i) {
        const double depth = roots[k].length * i / parts;
        const double expected = headOf(roots[k], depth);
        worst.add(std::abs(flow.heads[i] / expected - 1.0));
        if (parts == 500) {
          ours.points.emplace_back(depth, flow.heads[i]);
          theirs.points.emplace_back(depth, expected);
        }
      }
    }
    result.rows.push_back({"parameters " + std::to_string(k + 1) + ", heads with 1, 10 and 500 segments, relative",
                           worst.value(), 1e-6,
                           k == 0 ? "DuMux 3.0e-4, OpenSimRoot 5.5e-4, R-SWMS 5.5e-5, SRI 2.6e-4" : ""});
    result.across = "depth, cm";
    result.up = "head in the xylem, cm";
    result.curves.push_back(std::move(ours));
    result.curves.push_back(std::move(theirs));
  }
  return result;
}

CaseResult conductance(const Data&) {
  // √(2πa kr kx) tanh(√(2πa kr/kx) L), without gravity (Landsberg & Fowkes 1978)
  CaseResult result;
  LargestError worst;
  for (const double length : {0.01, 1.0, 50.0, 4000.0}) {
    const double c = 2.0 * std::numbers::pi * 0.05 * 0.00173;
    const double expected = std::sqrt(c * 0.00432) * std::tanh(std::sqrt(c / 0.00432) * length);
    const auto flow = straightRoot({length, 0.05, 0.00432, 0.00173, 0.0, -1.0}, 3).solve({.head = -1.0});
    worst.add(std::abs(flow.conductances[0] / expected - 1.0));
  }
  result.rows.push_back({"roots of 0.01 to 4000 cm, relative", worst.value(), 1e-9, ""});
  LargestError ofBenchmarks;
  for (const SingleRoot& root : {SingleRoot{5, 0.2, 0.0432, 0.000173, 0, -1},
                                 {50, 0.2, 0.0432, 0.000173, 0, -1},
                                 {20, 0.02, 0.0004, 0.00411, 0, -1}}) {
    const double c = 2.0 * std::numbers::pi * root.radius * root.kr;
    const double expected = std::sqrt(c * root.kx) * std::tanh(std::sqrt(c / root.kx) * root.length);
    ofBenchmarks.add(std::abs(straightRoot(root, 7).solve({.head = -1.0}).conductances[0] / expected - 1.0));
  }
  result.rows.push_back({"the roots of the benchmarks, 5, 20 and 50 cm, relative", ofBenchmarks.value(), 1e-9, ""});
  return result;
}

/// Uptake fractions by depth against the published ones, and their picture.
void addFractions(const ReferenceTable& roots, const ReferenceTable& fractions, const HydraulicTree::Result& flow,
                  std::optional<double> tolerance, CaseResult& result) {
  std::vector<double> found(fractions.rowCount(), 0.0);
  for (std::size_t i = 0; i < roots.rowCount(); ++i) {
    const auto parent = parentOf(roots, i, "parent");
    const double depth = -0.5 * (roots.number(i, "z") + roots.number(parent.value_or(i), "z"));
    for (std::size_t row = 0; row < found.size(); ++row) {
      if (depth >= fractions.number(row, "depth_from") && depth < fractions.number(row, "depth_to")) {
        found[row] += flow.uptakeFractions[i];
      }
    }
  }
  LargestError most;
  Curve ours{"fraction", false, {}};
  Curve theirs{"fraction, published", true, {}};
  for (std::size_t row = 0; row < found.size(); ++row) {
    const double expected = fractions.number(row, "fraction");
    most.add(std::abs(found[row] - expected));
    const double depth = 0.5 * (fractions.number(row, "depth_from") + fractions.number(row, "depth_to"));
    ours.points.emplace_back(depth, found[row]);
    theirs.points.emplace_back(depth, expected);
  }
  result.rows.push_back({"standard uptake fractions by depth", most.value(), tolerance, ""});
  result.pictures.push_back({"fractions", "depth, cm", "part of the uptake from each cm", {ours, theirs}});
}

// flow out of the collar, cm³/day, and conductance, cm²/day, of the reference's joins and of those of DuMux and R-SWMS
constexpr double kCollarFlows[] = {1.363622, 1.371538};
constexpr double kConductances[] = {0.00467420, 0.00470172};

/// The heads of all nodes over their depth.
Curve headsByDepth(const std::string& name, bool isReference, const ReferenceTable& roots,
                   const std::function<double(std::size_t)>& headOfNode) {
  Curve curve{name, isReference, {}, true};
  for (std::size_t i = 0; i < roots.rowCount(); ++i) {
    curve.points.emplace_back(-roots.number(i, "z"), headOfNode(i));
  }
  return curve;
}

/// M3.2 with the joins and the heads that the table publishes.
void addPublishedJoins(const ReferenceTable& roots, const ReferenceTable* fractions, CaseResult& result) {
  for (const bool isAlternative : {false, true}) {
    const std::string join = isAlternative ? "_alternative" : "";
    const std::string name = isAlternative ? "joins of DuMux and R-SWMS" : "joins of the reference";
    const HydraulicTree tree = treeOf(roots, "parent" + join, {.kx = 0.0432, .kr = 1.728e-4, .soilHead = -200.0});
    const auto flow = tree.solve({.head = -500.0});
    LargestError worst;
    double uptake = 0.0;
    for (std::size_t i = 0; i < roots.rowCount(); ++i) {
      worst.add(std::abs(flow.heads[i] - roots.number(i, "head_a" + join)));
      uptake += flow.uptakes[i];
    }
    result.rows.push_back({name + ", heads of all nodes, cm", worst.value(), 0.01,
                           "nRMSE: DuMux 2e-6, R-SWMS 0.0019, SRI 0.008 at most"});
    result.rows.push_back(
        {name + ", uptake against collar flow, relative", std::abs(uptake / flow.collarFlows[0] - 1.0), 1e-10, ""});
    result.rows.push_back({name + ", collar flow against the published one, cm3/day",
                           std::abs(flow.collarFlows[0] - kCollarFlows[isAlternative ? 1 : 0]), 1e-6, ""});
    result.rows.push_back(
        {name + ", Krs, cm2/day", std::abs(flow.conductances[0] - kConductances[isAlternative ? 1 : 0]), 1e-8, ""});
    if (!isAlternative) {
      if (fractions != nullptr) {
        addFractions(roots, *fractions, flow, 1e-4, result);
      }
      result.across = "depth, cm";
      result.up = "head in the xylem, cm";
      result.curves.push_back(
          headsByDepth("head, published", true, roots, [&](std::size_t i) { return roots.number(i, "head_a"); }));
      result.curves.push_back(headsByDepth("head", false, roots, [&](std::size_t i) { return flow.heads[i]; }));
    }
  }
}

/// M3.2 with the joins of an RSML file, which publishes no heads: the flow is compared with that of the nearer joins.
void addJoinsOfMarkup(const ReferenceTable& roots, const ReferenceTable* fractions, CaseResult& result) {
  const auto flow = treeOf(roots, "parent", {.kx = 0.0432, .kr = 1.728e-4, .soilHead = -200.0}).solve({.head = -500.0});
  double uptake = 0.0;
  for (const double part : flow.uptakes) {
    uptake += part;
  }
  const auto toNearer = [](double value, const auto& published) {
    return std::min(std::abs(value / published[0] - 1.0), std::abs(value / published[1] - 1.0));
  };
  const std::string name = "joins of the RSML file";
  result.rows.push_back(
      {name + ", uptake against collar flow, relative", std::abs(uptake / flow.collarFlows[0] - 1.0), 1e-10, ""});
  // both kinds of joins differ by 0.6 %
  result.rows.push_back({name + ", collar flow against the published ones, relative",
                         toNearer(flow.collarFlows[0], kCollarFlows), 0.006, ""});
  result.rows.push_back(
      {name + ", Krs against the published ones, relative", toNearer(flow.conductances[0], kConductances), 0.006, ""});
  if (fractions != nullptr) {
    addFractions(roots, *fractions, flow, std::nullopt, result);
  }
  result.across = "depth, cm";
  result.up = "head in the xylem, cm";
  result.curves.push_back(headsByDepth("head", false, roots, [&](std::size_t i) { return flow.heads[i]; }));
}

CaseResult rootSystem(const Data& data) {
  CaseResult result;
  const auto roots = readRootTable(data, "m32_roots", result.missing);
  const auto fractions = ReferenceTable::read(data, "m32_uptake_fractions.tsv", result.missing);
  if (!roots) {
    return result;
  }
  (roots->isPublished ? addPublishedJoins : addJoinsOfMarkup)(roots->nodes, fractions ? &*fractions : nullptr, result);
  if (!roots->hasDays) {
    result.missing.emplace_back("the function 'emergence_time' in m32_roots.rsml");
  } else if (const auto ages = ReferenceTable::read(data, "root_conductivities.tsv", result.missing)) {
    const auto flow =
        treeOf(roots->nodes, "parent", {.soilHead = -200.0, .ages = &*ages, .day = 14.0}).solve({.head = -500.0});
    result.rows.push_back({"conductivities by age, collar flow, cm3/day", flow.collarFlows[0], std::nullopt, ""});
  }
  return result;
}

CaseResult millionSegments(const Data&) {
  // a main root with laterals of a hundred segments
  std::vector<HydraulicTree::Node> nodes(1);
  for (std::uint32_t lateral = 0; lateral < 10'000; ++lateral) {
    const auto base = static_cast<std::uint32_t>(nodes.size()) - (lateral == 0 ? 1 : 100);
    for (std::uint32_t i = 0; i < 100; ++i) {
      nodes.push_back(
          {i == 0 ? base : static_cast<std::uint32_t>(nodes.size() - 1), 0.1, -0.05, 0.05, 0.04, 1e-4, -200.0});
    }
  }
  const HydraulicTree tree(std::move(nodes));
  const auto begin = std::chrono::steady_clock::now();
  const auto flow = tree.solve({.head = -1000.0});
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  double uptake = 0.0;
  for (const double part : flow.uptakes) {
    uptake += part;
  }
  return {{{"uptake against collar flow, relative", std::abs(uptake / flow.collarFlows[0] - 1.0), 1e-8, ""},
           {"time of a solution, s", seconds.count(), 1.0, ""}},
          {},
          {},
          {},
          {}};
}

constexpr std::array kRootCases{
    Case{"m3.1", "heads in one root (Schnepf et al. 2020; Landsberg & Fowkes 1978)", true, singleRoot},
    Case{"m3.2", "heads and uptake in a lupine root system (Schnepf et al. 2020; Meunier et al. 2017)", true,
         rootSystem},
    Case{"root-conductance", "conductance of one root (Landsberg & Fowkes 1978)", true, conductance},
    Case{"million-segments", "a root system of a million segments", false, millionSegments},
};

}  // namespace

std::span<const Case> rootCases() {
  return kRootCases;
}

}  // namespace espalier::validation
