// The parts of `espalier sweep`: plans, designs, tables, measures of branching and shape, Slurm's arrays.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "clients/espalier/sweep/designs.h"
#include "clients/espalier/sweep/module_pattern.h"
#include "clients/espalier/sweep/plan.h"
#include "clients/espalier/sweep/run_table.h"
#include "clients/espalier/sweep/shape_measures.h"
#include "clients/espalier/sweep/slurm_job.h"
#include "clients/espalier/sweep/tree_measures.h"
#include "engine/core/streams.h"
#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"

namespace espalier::command::sweep_test {
namespace {

std::string problemOf(const std::string& json) {
  const Result<Plan> plan = readPlan(json);
  return plan ? "" : plan.error();
}

const std::string kMeasures = R"("measures":{"n":{"count":"*"}})";

TEST(Plan, NamesEveryMistakeWithItsPlaceAndTheNearestName) {
  EXPECT_EQ(
      problemOf(R"({"modle":"a","measures":{"h":{"plant":"hight"}}})"),
      "model: missing: give a model folder, an L-system file or the name of a gallery model\n"
      "measures.h.plant: there is no 'hight'. Did you mean 'height'? Available: height, lowest, extentX, extentY, "
      "extentZ, spread, length, segments, woodArea, woodVolume, organs, leafArea, silhouetteTop, silhouetteFront, "
      "silhouetteSide, sky, symmetry, stability, branching.\n"
      "modle: there is no such member. Did you mean 'model'? Available: $schema, title, model, object, view, "
      "dialect, compatibility, environment, world, stepDuration, defines, limits, steps, seed, answered, parameters, "
      "runs, replicates, measures, files.");
  EXPECT_NE(problemOf(R"({"model":"a","measures":{"n":{"cuont":"A"}}})").find("Did you mean 'count'?"),
            std::string::npos);
  EXPECT_NE(problemOf(R"({"model":"a","runs":{"design":"sobl","count":4},)" + kMeasures + "}")
                .find("there is no design 'sobl'. Did you mean 'sobol'?"),
            std::string::npos);
  EXPECT_NE(problemOf(R"({"model":"a"})").find("measures: missing"), std::string::npos);
  EXPECT_EQ(problemOf(R"({"model":"a","measures":{"h":"height"}})"),
            "measures.h: expected a measure such as {\"plant\": \"height\"}, found \"height\"");
  EXPECT_NE(problemOf(R"({"model":"a","model":"b",)" + kMeasures + "}").find("an object has 'model' twice"),
            std::string::npos);
  EXPECT_NE(problemOf("{").find("the plan is not valid JSON"), std::string::npos);
  EXPECT_EQ(problemOf(R"({"model":)" + std::string(200'000, '[') + std::string(200'000, ']') + "}"),
            "the plan is not valid JSON: brackets are nested deeper than 64");
  EXPECT_NE(problemOf(R"({"model":"a","parameters":{"R":{"log":[0,1]}},)" + kMeasures + "}")
                .find("parameters.R.log: both numbers must be above 0"),
            std::string::npos);
  EXPECT_NE(problemOf(R"({"model":"a","runs":{"design":"sobol"},)" + kMeasures + "}").find("runs.count: missing"),
            std::string::npos);
  EXPECT_NE(problemOf(R"j({"model":"a","measures":{"q":{"quantile":2,"value":"l","of":"F(l)"}}})j")
                .find("measures.q.quantile: expected a number from 0 to 1"),
            std::string::npos);
}

TEST(Plan, HasTheSameTextWhateverItsLayout) {
  const std::string json = R"({"model":"a",)" + kMeasures + "}";
  EXPECT_EQ(readPlan(json)->text, readPlan(" \n" + json + "\n")->text);
}

// the normal quantiles are those of Python's statistics.NormalDist().inv_cdf
TEST(Distribution, HasTheQuantilesOfItsKind) {
  using Kind = Distribution::Kind;
  const Distribution normal{.kind = Kind::Normal, .first = 0.0, .second = 1.0};
  EXPECT_NEAR(normal.quantile(0.975), 1.959963984540054, 1e-15);
  EXPECT_NEAR(normal.quantile(1e-10), -6.361340902404056, 1e-14);
  EXPECT_NEAR(normal.quantile(1e-20), -9.262340089798408, 1e-14);
  EXPECT_NEAR(normal.quantile(0.4), -0.2533471031357997, 1e-15);
  const Distribution log{.kind = Kind::Log, .first = 0.01, .second = 100.0};
  EXPECT_NEAR(log.quantile(0.5), 1.0, 1e-12);
  const Distribution integer{.kind = Kind::Integer, .first = 2.0, .second = 4.0};
  EXPECT_EQ(integer.quantile(0.0), 2.0);
  EXPECT_EQ(integer.quantile(0.34), 3.0);
  EXPECT_EQ(integer.quantile(1.0), 4.0);
  const Distribution discrete{.kind = Kind::Discrete, .values = {5.0, 7.0}};
  EXPECT_EQ(discrete.quantile(0.49), 5.0);
  EXPECT_EQ(discrete.quantile(1.0), 7.0);
}

// the points of Joe & Kuo's own program, which SciPy prints too
TEST(Designs, SobolPointsAreThoseOfJoeAndKuo) {
  const DesignPoints points = sobolPoints(6, 3, std::nullopt);
  const std::vector<double> expected{0,    0,    0,    0.5,   0.5,   0.5,   0.75,  0.25,  0.25,
                                     0.25, 0.75, 0.75, 0.375, 0.375, 0.625, 0.875, 0.875, 0.125};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(points.values[i], expected[i], 0x1.0p-32);
  }
}

// every column of 2^k points has one point in each of 2^k equal parts
TEST(Designs, EverySobolColumnFillsEveryPartOnceAlsoWhenShifted) {
  for (const std::optional<std::uint64_t> shift : {std::optional<std::uint64_t>(), std::optional<std::uint64_t>(7)}) {
    const DesignPoints points = sobolPoints(64, kSobolColumns, shift);
    for (std::size_t column = 0; column < kSobolColumns; ++column) {
      std::set<int> parts;
      for (std::size_t i = 0; i < 64; ++i) {
        parts.insert(static_cast<int>(points.values[i * kSobolColumns + column] * 64.0));
      }
      EXPECT_EQ(parts.size(), 64U) << column;
    }
  }
}

TEST(Designs, LatinHypercubeHasOnePointInEachStratum) {
  const DesignPoints points = latinHypercube(50, 4, 3);
  for (std::size_t column = 0; column < 4; ++column) {
    std::set<int> strata;
    for (std::size_t i = 0; i < 50; ++i) {
      strata.insert(static_cast<int>(points.values[i * 4 + column] * 50.0));
    }
    EXPECT_EQ(strata.size(), 50U);
  }
  EXPECT_NE(points.values, latinHypercube(50, 4, 4).values);
}

TEST(Designs, SaltelliExchangesOneColumnAtATime) {
  const DesignPoints points = saltelliPoints(3, 2, std::nullopt);
  ASSERT_EQ(points.count(), 3U * 4U);
  for (std::size_t i = 0; i < 3; ++i) {
    const double* const a = points.values.data() + i * 8;
    const double* const b = a + 6;
    EXPECT_EQ((std::vector<double>{a[2], a[3]}), (std::vector<double>{b[0], a[1]}));
    EXPECT_EQ((std::vector<double>{a[4], a[5]}), (std::vector<double>{a[0], b[1]}));
  }
}

// Morris 1991: each walk changes every factor once by p / (2 (p - 1)) and stays in [0, 1]
TEST(Designs, MorrisWalksChangeEveryFactorOnce) {
  constexpr std::size_t kFactors = 5;
  const DesignPoints points = morrisPoints(20, kFactors, 6, 9);
  ASSERT_EQ(points.count(), 20U * (kFactors + 1));
  bool goesDown = false;
  for (std::size_t walk = 0; walk < 20; ++walk) {
    std::set<std::size_t> changed;
    for (std::size_t step = 1; step <= kFactors; ++step) {
      const double* const row = points.values.data() + (walk * (kFactors + 1) + step) * kFactors;
      for (std::size_t i = 0; i < kFactors; ++i) {
        EXPECT_GE(row[i], 0.0);
        EXPECT_LE(row[i], 1.0);
        const double change = row[i] - *(row + i - kFactors);
        if (change != 0.0) {
          EXPECT_NEAR(std::abs(change), 0.6, 1e-12);
          goesDown = goesDown || change < 0.0;
          changed.insert(i);
        }
      }
      EXPECT_EQ(changed.size(), step);
    }
  }
  EXPECT_TRUE(goesDown);
}

Result<RunTable> runsOf(const std::string& plan, const std::string& csv, std::vector<std::string>* names = nullptr) {
  core::MemoryFileProvider files;
  files.add("a/runs.csv", csv);
  Result<Plan> read = readPlan(plan);
  EXPECT_TRUE(read) << read.error();
  Result<RunTable> table = makeRuns(*read, "a", files);
  if (names != nullptr) {
    names->clear();
    for (const SweepParameter& parameter : read->parameters) {
      names->push_back(parameter.name);
    }
  }
  return table;
}

TEST(RunTable, ReadsTablesAndNamesTheLineOfAMistake) {
  const std::string plan = R"({"model":"a","runs":{"table":"runs.csv"},)" + kMeasures + "}";
  std::vector<std::string> names;
  const Result<RunTable> table = runsOf(plan, "# measured\nR,seed,\"W\"\n1.5,3,2\n1.5,4,2\n", &names);
  ASSERT_TRUE(table) << table.error();
  EXPECT_EQ(names, (std::vector<std::string>{"R", "W"}));
  EXPECT_EQ(table->values, (std::vector<double>{1.5, 2, 1.5, 2}));
  EXPECT_EQ(table->seeds, (std::vector<std::uint64_t>{3, 4}));
  EXPECT_EQ(runsOf(plan, "R\n1\n2\n1\n").error(),
            "a/runs.csv:4: the row repeats a/runs.csv:2. Remove it, give it another seed, or ask for 'replicates'");
  EXPECT_EQ(runsOf(plan, "R\tW\n1\tnan\n").error(),
            "a/runs.csv:2: 'nan' in the column 'W' is not a number: give a finite number in every cell");
  EXPECT_EQ(runsOf(plan, "R\n").error(),
            "a/runs.csv: the table has no rows: give a line of names, and a line of numbers for each run");
  EXPECT_EQ(runsOf(plan, "R,W\n1\n").error(),
            "a/runs.csv:2: the line has 1 values, and the first line 2 names: give a value for each name");
  const std::string named = R"({"model":"a","parameters":{"R":{}},"runs":{"table":"runs.csv"},)" + kMeasures + "}";
  EXPECT_EQ(runsOf(named, "R,Rr\n1,2\n").error(),
            "a/runs.csv: there is no parameter 'Rr'. Did you mean 'R'? Available: seed, R.");
}

TEST(RunTable, ReplicatesHaveCommonSeedsUnlessThePlanSaysOtherwise) {
  const std::string begin = R"({"model":"a","runs":{"rows":[{"R":1},{"R":2}]},"replicates":{"count":2,"seed":5)";
  const Result<RunTable> common = runsOf(begin + "}," + kMeasures + "}", "");
  EXPECT_EQ(common->seeds, (std::vector<std::uint64_t>{5, 6, 5, 6}));
  EXPECT_EQ(common->values, (std::vector<double>{1, 1, 2, 2}));
  const Result<RunTable> own = runsOf(begin + R"(,"common":false},)" + kMeasures + "}", "");
  EXPECT_EQ(own->seeds, (std::vector<std::uint64_t>{5, 6, 7, 8}));
}

TEST(RunTable, AGridHasEveryCombinationAndTheLastParameterChangesFastest) {
  const Result<RunTable> table = runsOf(
      R"({"model":"a","parameters":{"R":{"uniform":[0,2]},"n":{"integer":[1,2]}},"runs":{"design":"grid","levels":3},)" +
          kMeasures + "}",
      "");
  EXPECT_EQ(table->values, (std::vector<double>{0, 1, 0, 2, 1, 1, 1, 2, 2, 1, 2, 2}));
}

TEST(RunTable, LevelsOfANormalDistributionAreTheMiddlesOfEqualParts) {
  const std::string begin = R"({"model":"a","parameters":{"R":{"normal":[10,2]}},"runs":{"design":)";
  const Distribution normal{.kind = Distribution::Kind::Normal, .first = 10.0, .second = 2.0};
  std::set<double> levels;
  for (const double probability : {0.125, 0.375, 0.625, 0.875}) {
    levels.insert(normal.quantile(probability));
  }
  // the first and the last level of other distributions are their ends, which are infinite here
  const Result<RunTable> grid = runsOf(begin + R"("grid","levels":4},)" + kMeasures + "}", "");
  ASSERT_TRUE(grid) << grid.error();
  EXPECT_EQ(grid->values, std::vector<double>(levels.begin(), levels.end()));
  const Result<RunTable> morris = runsOf(begin + R"("morris","trajectories":40,"levels":4},)" + kMeasures + "}", "");
  ASSERT_TRUE(morris) << morris.error();
  EXPECT_EQ(std::set<double>(morris->values.begin(), morris->values.end()), levels);
}

TEST(RunTable, AGridTooLargeIsRefusedBeforeItIsMade) {
  // 2^40 points of 40 switches
  std::string parameters;
  for (int i = 0; i < 40; ++i) {
    parameters += (i == 0 ? "\"P" : ",\"P") + std::to_string(i) + "\":{\"integer\":[0,1]}";
  }
  const Result<RunTable> table = runsOf(
      R"({"model":"a","parameters":{)" + parameters + R"(},"runs":{"design":"grid","levels":2},)" + kMeasures + "}",
      "");
  ASSERT_FALSE(table);
  EXPECT_EQ(table.error(), "the grid has more than 25000000 points: give fewer levels, or a latin-hypercube");
}

TEST(RunTable, SlicesHaveEveryRunOnce) {
  std::vector<int> seen(21);
  for (const char* const text : {"1/3", "2/3", "3/3"}) {
    const Result<Slice> slice = readSlice(text);
    for (std::uint64_t run = 1; run <= 20; ++run) {
      seen[run] += slice->has(run) ? 1 : 0;
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), 20);
  for (const char* const text : {"0/3", "4/3", "3", "a/b", "1/3x"}) {
    EXPECT_FALSE(readSlice(text)) << text;
  }
}

std::shared_ptr<const language::Program> compiled(const std::string& axiom) {
  core::MemoryFileProvider files;
  files.add("m.l", "Lsystem: 1\nderivation length: 0\nAxiom: " + axiom + "\nA --> A\nendlsystem\n");
  language::CompileInput input;
  input.modelFile = "m.l";
  return language::compile(input, files).program;
}

TEST(ModulePattern, MeansModulesByNameAndParameters) {
  const auto program = compiled("F(1,2)F(1)?E(1)");
  EXPECT_EQ(ModulePattern::read("F")->typesOf(*program)[program->findType("F", 1)], true);
  EXPECT_EQ(ModulePattern::read("F(l,w)")->typesOf(*program)[program->findType("F", 1)], false);
  EXPECT_EQ(ModulePattern::read("?E(x)")->typesOf(*program)[program->findType("E", 1)], true);
  EXPECT_EQ(ModulePattern::read("F(l,w)")->problemIn(*program), "");
  EXPECT_EQ(ModulePattern::read("F(a,b,c)")->problemIn(*program),
            "the module 'F' has 2 or 1 parameters in the model, and F(a,b,c) names 3");
  EXPECT_NE(ModulePattern::read("G")->problemIn(*program).find("the model has no module 'G'"), std::string::npos);
  for (const char* const text : {"", "F(", "F(l,l)", "F(1)", "F(l) --> G"}) {
    EXPECT_FALSE(ModulePattern::read(text)) << text;
  }
}

// A[B[C]D]E[F]G: the stem A E G; B D stands on A, C on B, F on E
TEST(TreeMeasures, CountsAxesByOrderAsAnMtgHasThem) {
  const auto program = compiled("A[B[C]D]E[F]G");
  simulation::Simulation plant(program, std::vector<turtle::PlantPlacement>(1), nullptr, {});
  ASSERT_FALSE(plant.rewind());
  const TreeMeasures tree(*program, plant.string(), {});
  const auto value = [&](const char* name, std::optional<std::uint64_t> order = std::nullopt) {
    const auto& names = treeMeasureNames();
    return tree.value(static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin()), order);
  };
  EXPECT_EQ(value("vertices"), 7.0);
  EXPECT_EQ(value("axes"), 4.0);
  EXPECT_EQ(value("axes", 1), 2.0);
  EXPECT_EQ(value("vertices", 1), 3.0);
  EXPECT_EQ(value("vertices", 2), 1.0);
  EXPECT_EQ(value("tips"), 4.0);
  EXPECT_EQ(value("maximumOrder"), 2.0);
  EXPECT_EQ(value("depth"), 3.0);
  EXPECT_EQ(value("verticesPerAxis", 0), 3.0);
  // C and D make B 2; F and G make E 2; B and E make A 3
  EXPECT_EQ(value("strahler"), 3.0);
  EXPECT_TRUE(std::isnan(value("verticesPerAxis", 9)));
  EXPECT_TRUE(std::isnan(value("maximumOrder", 9)));
}

turtle::Scene stemWithALeaf() {
  turtle::Scene scene;
  scene.lineStyle = files::LineStyle::Cylinder;
  turtle::Segment stem;
  stem.start = {0, 0, 0};
  stem.end = {0, 2, 0};
  stem.startWidth = stem.endWidth = 0.5;
  scene.segments.push_back(stem);
  turtle::Polygon leaf;
  leaf.vertices = {{0, 2, 0}, {3, 2, 0}, {3, 2, 2}, {0, 2, 2}};
  scene.polygons.push_back(leaf);
  return scene;
}

TEST(ShapeMeasures, OfACylinderAndARectangle) {
  ShapeMeasures shape(stemWithALeaf(), {});
  const auto value = [&](const char* name) {
    const auto& names = shapeMeasureNames();
    return shape.value(static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin()));
  };
  EXPECT_DOUBLE_EQ(value("height"), 2.0);
  EXPECT_DOUBLE_EQ(value("length"), 2.0);
  EXPECT_DOUBLE_EQ(value("extentX"), 3.0);
  EXPECT_DOUBLE_EQ(value("spread"), std::hypot(3.0, 2.0));
  EXPECT_DOUBLE_EQ(value("leafArea"), 6.0);
  EXPECT_NEAR(value("woodArea"), 3.14159265358979 * 0.5 * 2.0, 1e-12);
  EXPECT_NEAR(value("woodVolume"), 3.14159265358979 * 0.0625 * 2.0, 1e-12);
  // the rectangle, and the part of the stem beside it; 512 cells in 3 units
  EXPECT_NEAR(value("silhouetteTop"), 6.0 + 0.75 * 3.14159265358979 * 0.0625, 0.1);
  // the stem is 2 by 0.5, with half discs at its ends
  EXPECT_NEAR(value("silhouetteFront"), 1.0 + 3.14159265358979 * 0.0625, 0.05);
}

TEST(ShapeMeasures, ASilhouetteIsSeenAlongItsAxis) {
  // upright rectangles of 2 across x and 3 across z
  turtle::Scene scene;
  turtle::Polygon leaf;
  leaf.vertices = {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};
  scene.polygons.push_back(leaf);
  leaf.vertices = {{0, 0, 0}, {0, 0, 3}, {0, 1, 3}, {0, 1, 0}};
  scene.polygons.push_back(leaf);
  ShapeMeasures shape(std::move(scene), {});
  const auto value = [&](const char* name) {
    const auto& names = shapeMeasureNames();
    return shape.value(static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin()));
  };
  EXPECT_NEAR(value("silhouetteFront"), 2.0, 0.05);
  EXPECT_NEAR(value("silhouetteSide"), 3.0, 0.05);
  EXPECT_NEAR(value("silhouetteTop"), 0.0, 0.05);
}

TEST(ShapeMeasures, AProfileDividesLinesAmongItsBins) {
  const ShapeMeasures shape(stemWithALeaf(), {});
  EXPECT_EQ(shape.profile(0, false, 4, 4.0), (std::vector<double>{1.0, 1.0, 0.0, 0.0}));
  const std::vector<double> leaf = shape.profile(3, false, 4, 4.0);
  EXPECT_EQ(leaf, (std::vector<double>{0.0, 0.0, 6.0, 0.0}));
  // by the distance from the axis: the stem is on it; the middles of the two triangles are at (2, 2/3) and (1, 4/3)
  EXPECT_EQ(shape.profile(0, true, 4, 4.0), (std::vector<double>{2.0, 0.0, 0.0, 0.0}));
  EXPECT_EQ(shape.profile(3, true, 4, 4.0), (std::vector<double>{0.0, 3.0, 3.0, 0.0}));
}

TEST(SlurmJob, SplitsAnArrayAtTheLimitOfTheCluster) {
  using Arrays = std::vector<std::pair<std::uint64_t, std::uint64_t>>;
  EXPECT_EQ(slurmArrays(64, 1000), (Arrays{{1, 64}}));
  EXPECT_EQ(slurmArrays(2500, 1000), (Arrays{{1, 1000}, {1001, 1000}, {2001, 500}}));
  const std::string script =
      slurmScript({.plan = "p.json", .output = "r.sqlite", .slices = 8, .options = {"--time=1:00"}}, "/bin/espalier");
  EXPECT_NE(script.find("#SBATCH --time=1:00\n"), std::string::npos);
  EXPECT_NE(script.find("sweep 'p.json' -o 'r'.part-$k.sqlite --slice $k/8"), std::string::npos);
  SlurmJob job{.plan = "p.json", .output = "r.sqlite", .slices = 8, .options = {}};
  EXPECT_EQ(slurmScript(job, "/bin/espalier").find("--world"), std::string::npos);
  job.world = "berlin.json";
  job.stepDuration = "1 h";
  EXPECT_NE(slurmScript(job, "/bin/espalier").find(" --world 'berlin.json' --step-duration '1 h'\n"),
            std::string::npos);
}

}  // namespace
}  // namespace espalier::command::sweep_test
