// Benchmark M1.1 of Schnepf et al. 2020: root systems that an L-system grows beside measured ones, by the traits of
// `espalier traits`; Fitter's topology. Lengths in cm, steps of a day.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "clients/espalier/roots/root_system.h"
#include "clients/espalier/roots/root_traits.h"
#include "clients/espalier/validation/reference_table.h"
#include "clients/espalier/validation/validation.h"
#include "engine/core/check.h"
#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/export/text/rsml.h"

namespace espalier::validation {

namespace {

using roots::RootTraits;

// seen from the side; the page docs/validation.md has it, too
constexpr const char* kRootModel = R"(/* A root system seen from the side. Lengths in cm; a step is a day. */
Lsystem: 1
derivation length: DAYS
Axiom: [+(180)T(0,0,BASE)][+(180)N(0)][+(180)N(0)][+(180)N(0)]
/* first-order root: its day, how far it is turned from the vertical, way to the next lateral */
T(t,a,r) --> S((t==0)*SEEDLING+LENGTH*(exp(-RATE*t/LENGTH)-exp(-RATE*(t+1)/LENGTH)),a,r,t+1)
/* seminal roots begin later, beside it */
N(t) : t < SEMINAL --> N(t+1)
N(t) : * { a=60*(ran(1)-0.5); } --> +(a)T(0,a,BASE)
/* a lateral appears DELAY days after its tissue; some bear laterals of their own */
P(t) : t+1 < DELAY --> P(t+1)
P(t) : * { m=exp(nran(0,VARIATION)); } --> K(0,m)
L(t,m) : t==SECOND && ran(1) < PART --> [+(60)M]K(t,m)
L(t,m) --> K(t,m)
M --> F(RATESECOND)M
decomposition
maximum depth: 100
S(x,a,r,t) : x < r --> F(x)T(t,a,r-x)
S(x,a,r,t) : * { s=2*(ran(1)<0.5)-1; b=TROPISM*a+nran(0,BEND); d=DISTANCE*(0.5+ran(1)); } --> F(r)[+(70*s)P(0)]+(b-a)S(x-r,b,d,t)
K(t,m) --> F(LATERAL*m*(exp(-RATELATERAL*t/LATERAL)-exp(-RATELATERAL*(t+1)/LATERAL)))L(t+1,m)
endlsystem
)";

// a lateral more in each step
constexpr const char* kHerringbone = "Lsystem: 1\nderivation length: 1\nAxiom: FA\nA --> [+F]FA\nendlsystem\n";

// two branches in each step
constexpr const char* kDichotomous =
    "Lsystem: 1\nderivation length: 1\nAxiom: A\nA --> F[+A]A\nhomomorphism\nA --> F\nendlsystem\n";

using Macros = std::vector<std::pair<std::string, std::string>>;

struct Species {
  std::string name;  // in the table
  int days;
  Macros rates;
};

const std::array<Species, 2>& species() {
  static const std::array<Species, 2> kSpecies{Species{"lupin",
                                                       11,
                                                       {{"SEEDLING", "6"},
                                                        {"LENGTH", "52"},
                                                        {"RATE", "5.4"},
                                                        {"BASE", "2"},
                                                        {"DISTANCE", "0.25"},
                                                        {"TROPISM", "0.9"},
                                                        {"BEND", "19.5"},
                                                        {"SEMINAL", "99"},
                                                        {"DELAY", "2"},
                                                        {"LATERAL", "1.8"},
                                                        {"RATELATERAL", "0.62"},
                                                        {"VARIATION", "0.4"},
                                                        {"SECOND", "6"},
                                                        {"PART", "0.6"},
                                                        {"RATESECOND", "0.35"}}},
                                               Species{"maize",
                                                       8,
                                                       {{"SEEDLING", "1.5"},
                                                        {"LENGTH", "60"},
                                                        {"RATE", "4.9"},
                                                        {"BASE", "2"},
                                                        {"DISTANCE", "0.2"},
                                                        {"TROPISM", "0.9"},
                                                        {"BEND", "8"},
                                                        {"SEMINAL", "5"},
                                                        {"DELAY", "2"},
                                                        {"LATERAL", "3"},
                                                        {"RATELATERAL", "0.5"},
                                                        {"VARIATION", "0.4"},
                                                        {"SECOND", "99"},
                                                        {"PART", "0"},
                                                        {"RATESECOND", "0"}}}};
  return kSpecies;
}

std::shared_ptr<const language::Program> compiled(const std::string& text, Macros macros) {
  core::MemoryFileProvider files;
  files.add("roots.l", text);
  language::CompileInput input;
  input.modelFile = "roots.l";
  input.defines = std::move(macros);
  const language::CompileResult result = language::compile(input, files);
  ESPALIER_CHECK(result.program != nullptr && result.diagnostics.entries().empty());
  return result.program;
}

/// How far the traits of a scene are from those of its file in the Root System Markup Language, relative.
double lostInMarkup(const turtle::Scene& scene, const RootTraits& traits) {
  core::StringSink sink;
  const files::ViewSettings view;
  const auto problem =
      turtle::writeRsml({.scene = scene, .view = view, .lengthUnit = "cm"}, {"roots.rsml", sink, {}, {}});
  ESPALIER_CHECK(!problem.has_value());
  const auto read = roots::readRsml(sink.text());
  ESPALIER_CHECK(read.has_value());
  const RootTraits again = roots::traitsOf(*read, 1);
  LargestError most;
  const auto compare = [&](double before, double after) { most.add(std::abs(after - before) / std::max(before, 1.0)); };
  compare(traits.length, again.length);
  compare(traits.height, again.height);
  compare(traits.width, again.width);
  compare(static_cast<double>(traits.magnitude), static_cast<double>(again.magnitude));
  compare(static_cast<double>(traits.altitude), static_cast<double>(again.altitude));
  compare(static_cast<double>(traits.pathLength), static_cast<double>(again.pathLength));
  compare(static_cast<double>(traits.orders.size()), static_cast<double>(again.orders.size()));
  for (const auto& [order, axes] : traits.orders) {
    const auto found = again.orders.find(order);
    const bool isThere = found != again.orders.end();
    compare(static_cast<double>(axes.number), isThere ? static_cast<double>(found->second.number) : NAN);
    compare(axes.length, isThere ? found->second.length : NAN);
  }
  return most.value();
}

/// The traits of a plant after each of its steps, from 0. `lost` takes what a file of the last step loses.
std::vector<RootTraits> grow(const std::shared_ptr<const language::Program>& program, std::uint64_t seed, int steps,
                             LargestError* lost = nullptr) {
  simulation::SimulationOptions options;
  options.seed = seed;
  options.hasSeed = true;
  options.derivationLength = static_cast<std::uint64_t>(steps);
  simulation::Simulation plant(program, {turtle::PlantPlacement{}}, nullptr, std::move(options));
  std::vector<RootTraits> traits;
  for (auto failure = plant.rewind(); traits.size() <= static_cast<std::size_t>(steps); failure = plant.step()) {
    ESPALIER_CHECK(!failure.has_value());
    const auto scene = plant.scene();
    ESPALIER_CHECK(scene.has_value());
    traits.push_back(roots::traitsOf(roots::rootsOf(*scene), 1));
    if (lost != nullptr && traits.size() > static_cast<std::size_t>(steps)) {
      lost->add(lostInMarkup(*scene, traits.back()));
    }
  }
  return traits;
}

double lateralsOf(const RootTraits& traits) {
  double number = 0.0;
  for (const auto& [order, axes] : traits.orders) {
    number += order > 1 ? static_cast<double>(axes.number) : 0.0;
  }
  return number;
}

struct Trait {
  const char* name;    // of the picture
  const char* column;  // of the table
  const char* up;
  double (*of)(const RootTraits&);
};
constexpr std::array kTraits{
    Trait{"length", "length", "total length, cm", [](const RootTraits& traits) { return traits.length; }},
    Trait{"laterals", "number_lateral", "number of laterals", lateralsOf},
    Trait{"height", "height", "height, cm", [](const RootTraits& traits) { return traits.height; }}};

/// Compares the mean of a trait with the measured plants: the range of the last day, and curves of all days.
void compareTrait(const Trait& trait, const Species& kind, const std::vector<double>& means,
                  const ReferenceTable* measured, Picture& picture, CaseResult& result) {
  Curve ours{kind.name, false, {}};
  for (std::size_t day = 1; day < means.size(); ++day) {
    ours.points.emplace_back(static_cast<double>(day), means[day]);
  }
  picture.curves.push_back(std::move(ours));
  if (measured == nullptr) {
    return;
  }
  Curve theirs{kind.name + ", measured", true, {}, true};
  double low = HUGE_VAL;
  double high = -HUGE_VAL;
  for (std::size_t row = 0; row < measured->rowCount(); ++row) {
    if (measured->text(row, "species") != kind.name) {
      continue;
    }
    const double value = measured->number(row, trait.column);
    theirs.points.emplace_back(measured->number(row, "day"), value);
    if (measured->number(row, "day") == kind.days) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  picture.curves.push_back(std::move(theirs));
  result.rows.push_back({kind.name + ", " + trait.up + " on day " + std::to_string(kind.days) +
                             ", from the middle of the range of the measured plants, in halves of the range",
                         std::abs(means.back() - 0.5 * (low + high)) / (0.5 * (high - low)), 1.0, ""});
}

void compareGrowth(const ReferenceTable* measured, CaseResult& result) {
  constexpr int kSeeds = 100;
  std::vector<Picture> pictures;
  for (const Trait& trait : kTraits) {
    pictures.push_back({trait.name, "day", trait.up, {}});
  }
  LargestError lost;
  for (const Species& kind : species()) {
    Macros macros = kind.rates;
    macros.emplace_back("DAYS", std::to_string(kind.days));
    const auto program = compiled(kRootModel, std::move(macros));
    std::array<std::vector<double>, kTraits.size()> means;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      const auto traits = grow(program, static_cast<std::uint64_t>(seed), kind.days, &lost);
      for (std::size_t k = 0; k < kTraits.size(); ++k) {
        means[k].resize(traits.size(), 0.0);
        for (std::size_t day = 0; day < traits.size(); ++day) {
          means[k][day] += kTraits[k].of(traits[day]) / kSeeds;
        }
      }
    }
    for (std::size_t k = 0; k < kTraits.size(); ++k) {
      result.rows.push_back({kind.name + ", " + kTraits[k].up + ", mean of " + std::to_string(kSeeds) + " plants",
                             means[k].back(), std::nullopt, ""});
      compareTrait(kTraits[k], kind, means[k], measured, pictures[k], result);
    }
  }
  result.rows.push_back(
      {"traits of the same plants from RSML files that Espalier wrote, relative", lost.value(), 1e-9, ""});
  result.pictures = std::move(pictures);
}

/// Main roots with one lateral at each of their points: a magnitude μ makes the path length (μ² + 3μ − 2)/2 (Fitter
/// 1987).
void compareTopology(const ReferenceTable* measured, CaseResult& result) {
  constexpr int kTips = 300;
  const auto traits = grow(compiled(kHerringbone, {}), 1, kTips - 1);
  LargestError formula;
  for (int tips = 1; tips <= kTips; ++tips) {
    const RootTraits& grown = traits[static_cast<std::size_t>(tips) - 1];
    formula.add(std::abs(static_cast<double>(grown.magnitude) - tips));
    formula.add(std::abs(static_cast<double>(grown.altitude) - tips));
    formula.add(std::abs(static_cast<double>(grown.pathLength) - 0.5 * (tips * tips + 3.0 * tips - 2.0)));
  }
  result.rows.push_back(
      {"herringbones of 1 to 300 tips, magnitude, altitude and path length", formula.value(), 0.0, ""});
  // 2^k tips, each k + 1 links from the collar (Fitter 1987)
  constexpr int kBranchings = 9;
  LargestError dichotomous;
  double tips = 1.0;
  double links = 1.0;
  for (const RootTraits& grown : grow(compiled(kDichotomous, {}), 1, kBranchings)) {
    dichotomous.add(std::abs(static_cast<double>(grown.magnitude) - tips));
    dichotomous.add(std::abs(static_cast<double>(grown.altitude) - links));
    dichotomous.add(std::abs(static_cast<double>(grown.pathLength) - tips * links));
    tips *= 2.0;
    links += 1.0;
  }
  result.rows.push_back({"dichotomous trees of 1 to 512 tips, the same", dichotomous.value(), 0.0, ""});
  if (measured == nullptr) {
    return;
  }
  LargestError ofPlants;
  int count = 0;
  for (std::size_t row = 0; row < measured->rowCount(); ++row) {
    const double magnitude = measured->number(row, "magnitude");
    if (measured->number(row, "number_first") != 1.0 || magnitude != measured->number(row, "altitude")) {
      continue;
    }
    if (magnitude < 1.0 || magnitude > kTips || magnitude != std::floor(magnitude)) {
      measured->refuse(row, "the magnitude " + measured->text(row, "magnitude") +
                                " is no number of tips from 1 to 300. Write the number of root tips there");
    }
    const RootTraits& grown = traits[static_cast<std::size_t>(magnitude) - 1];
    ofPlants.add(std::abs(static_cast<double>(grown.pathLength) - measured->number(row, "path_length")));
    ++count;
  }
  result.rows.push_back({"path length of the " + std::to_string(count) +
                             " measured plants with one first-order root and magnitude = altitude",
                         ofPlants.value(), 0.0, ""});
}

CaseResult architecture(const Data& data) {
  CaseResult result;
  const auto measured = ReferenceTable::read(data, "m1_root_traits.tsv", result.missing);
  compareTopology(measured ? &*measured : nullptr, result);
  compareGrowth(measured ? &*measured : nullptr, result);
  return result;
}

constexpr std::array kArchitectureCases{
    Case{"m1.1", "grown root systems beside measured ones (Schnepf et al. 2020); topology (Fitter 1987)", true,
         architecture},
};

}  // namespace

std::span<const Case> architectureCases() {
  return kArchitectureCases;
}

}  // namespace espalier::validation
