// The parts of `espalier evolve`: genes, measures of plants, generations.

#include "clients/espalier/evolution/evolution.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/files/view_settings.h"

namespace espalier::command::evolution_test {
namespace {

using core::Vec3;

turtle::Segment line(const Vec3& start, const Vec3& end, std::uint32_t parent = turtle::kNoParent) {
  turtle::Segment segment;
  segment.start = start;
  segment.end = end;
  segment.startWidth = segment.endWidth = 0.01;
  segment.parent = parent;
  return segment;
}

PlantMeasures measured(const std::vector<turtle::Segment>& segments) {
  turtle::Scene scene;
  scene.lineStyle = files::LineStyle::Cylinder;
  scene.segments.append(segments);
  return measurePlant(std::move(scene), {});
}

const std::vector<turtle::Segment> kStem{line({0, 0, 0}, {0, 2, 0})};

TEST(PlantMeasures, OfAStemAlone) {
  const PlantMeasures stem = measured(kStem);
  EXPECT_DOUBLE_EQ(stem.height, 2.0);
  EXPECT_DOUBLE_EQ(stem.length, 2.0);
  EXPECT_DOUBLE_EQ(stem.symmetry, 1.0);
  EXPECT_DOUBLE_EQ(stem.stability, 1.0);
  EXPECT_DOUBLE_EQ(stem.branching, 0.0);
  EXPECT_DOUBLE_EQ(stem.organs, 0.0);
}

TEST(PlantMeasures, SymmetryIsTheShareOfLengthWithItsMirrorImage) {
  std::vector<turtle::Segment> plant = kStem;
  plant.push_back(line({0, 2, 0}, {1, 3, 0}, 0));
  // the stem is its own image, the branch has none: 2 of 2 + sqrt 2
  EXPECT_NEAR(measured(plant).symmetry, 2.0 / (2.0 + std::sqrt(2.0)), 0.06);
  plant.push_back(line({0, 2, 0}, {-1, 3, 0}, 0));
  EXPECT_NEAR(measured(plant).symmetry, 1.0, 1e-12);
}

TEST(PlantMeasures, StabilityFallsWithTheDistanceOfTheCentre) {
  // an L of two lines of length 2: the centre of the upper one is 1 beside the base, that of both 1/2; the height is 2,
  // its half 1
  std::vector<turtle::Segment> plant = kStem;
  plant.push_back(line({0, 2, 0}, {2, 2, 0}, 0));
  EXPECT_NEAR(measured(plant).stability, 1.0 - 0.5 / 1.0, 1e-12);
}

TEST(PlantMeasures, BranchingIsTheShareOfForks) {
  std::vector<turtle::Segment> plant = kStem;
  plant.push_back(line({0, 2, 0}, {0, 3, 0}, 0));
  plant.push_back(line({0, 3, 0}, {1, 4, 0}, 1));
  plant.push_back(line({0, 3, 0}, {-1, 4, 0}, 1));
  EXPECT_DOUBLE_EQ(measured(plant).branching, 0.5);
}

TEST(PlantMeasures, LightIsTheGroundInTheShade) {
  // two level squares of side 1, one above the other with half of it over the other: they shade 1.5; the stem nothing
  // more
  turtle::Scene scene;
  scene.lineStyle = files::LineStyle::Cylinder;
  scene.segments.append(kStem);
  for (const auto& [x, y] : {std::pair{0.0, 1.0}, std::pair{0.5, 2.0}}) {
    turtle::Polygon square;
    square.vertices = {{x, y, 0}, {x + 1, y, 0}, {x + 1, y, 1}, {x, y, 1}};
    scene.polygons.push_back(square);
  }
  const PlantMeasures plant = measurePlant(std::move(scene), {});
  EXPECT_NEAR(plant.light, 1.5, 0.02);
  EXPECT_DOUBLE_EQ(plant.organs, 2.0);
}

TEST(PlantMeasures, SkyIsTheMeanOfFiveSides) {
  const auto skyOf = [](std::vector<core::Vec3> corners) {
    turtle::Scene scene;
    turtle::Polygon square;
    square.vertices = std::move(corners);
    scene.polygons.push_back(square);
    return measurePlant(std::move(scene), {}).sky;
  };
  // a level square is whole from above and cos 45 degrees of it from four sides
  EXPECT_NEAR(skyOf({{0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}}), (1.0 + 4.0 * std::sqrt(0.5)) / 5.0, 0.02);
  // one that stands across z has nothing to see but from before and behind
  EXPECT_NEAR(skyOf({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}), 2.0 * std::sqrt(0.5) / 5.0, 0.02);
}

TEST(PlantMeasures, AThickStemTakesNoMoreOfTheSkyThanATwig) {
  const auto stem = [](double width) {
    turtle::Segment segment = line({0, 0, 0}, {0, 2, 0});
    segment.startWidth = segment.endWidth = width;
    return measured({segment});
  };
  // lines count as green up to 1/128 of the extent
  EXPECT_DOUBLE_EQ(stem(1.0).sky, stem(2.0 / 128.0).sky);
  EXPECT_GT(stem(1.0).light, 4.0 * stem(0.1).light);
}

TEST(FitnessFormula, TheUsualOneDoesNotGrowWithThePlant) {
  FitnessFormula formula;
  ASSERT_EQ(FitnessFormula::read(kUsualFitness, formula), std::nullopt);
  const auto fitnessOf = [&](double scale, bool isMirrored) {
    std::vector<turtle::Segment> plant{line({0, 0, 0}, {0, 2 * scale, 0}),
                                       line({0, 2 * scale, 0}, {scale, 3 * scale, 0}, 0)};
    plant.push_back(line({0, 2 * scale, 0}, {isMirrored ? -scale : 0.4 * scale, 3 * scale, 0}, 0));
    for (turtle::Segment& segment : plant) {
      segment.startWidth = segment.endWidth = 0.01 * scale;
    }
    return formula(measured(std::move(plant)));
  };
  EXPECT_GT(fitnessOf(1.0, false), 0.0);
  EXPECT_NEAR(fitnessOf(8.0, false), fitnessOf(1.0, false), 1e-9);
  EXPECT_GT(fitnessOf(1.0, true), 1.3 * fitnessOf(1.0, false));
  EXPECT_EQ(formula(measured({line({0, 0, 0}, {0, 2, 0})})), 0.0) << "a line alone is no plant";
}

TEST(FitnessFormula, IsAProductOfPowers) {
  FitnessFormula formula;
  ASSERT_EQ(FitnessFormula::read("symmetry=2,light,length=-1", formula), std::nullopt);
  PlantMeasures plant;
  plant.symmetry = 0.5;
  plant.light = 3.0;
  plant.length = 2.0;
  EXPECT_DOUBLE_EQ(formula(plant), 0.25 * 3.0 / 2.0);
  plant.length = 0.0;
  EXPECT_EQ(formula(plant), 0.0) << "not infinite";
}

TEST(FitnessFormula, NamesWhatItCannotRead) {
  FitnessFormula formula;
  EXPECT_EQ(FitnessFormula::read("ligth", formula).value_or(""),
            "there is no measure 'ligth'. Did you mean 'light'? Available: height, light, sky, symmetry, stability, "
            "branching, length, extent, organs.");
  EXPECT_EQ(FitnessFormula::read("light=much", formula).value_or(""),
            "'much' is not a number: give an exponent, as in symmetry=2,light=1");
}

EvolutionSettings settingsOf(bool variesProductions) {
  EvolutionSettings settings;
  settings.seed = 5;
  settings.populationCount = 12;
  if (variesProductions) {
    settings.shape.predecessors = {"X", "F"};
    settings.shape.alphabet = {"X", "F", "+", "-"};
    settings.shape.longestSuccessor = 12;
    settings.successors = {{"F", "[", "+", "X", "]", "X"}, {"F", "F"}};
  } else {
    settings.shape.genes = {{"A", 10.0, 20.0}, {"B", -1.0, 0.0}};
  }
  return settings;
}

// a generation whose fitness is a number that everybody can compute
Generation judged(Generation generation) {
  for (Individual& individual : generation.individuals) {
    individual.isEvaluated = individual.hasGrown = true;
    individual.fitness = 0.0;
    for (const double value : individual.genome.values) {
      individual.fitness += value;
    }
    for (const Successor& successor : individual.genome.successors) {
      individual.fitness += static_cast<double>(std::count(successor.begin(), successor.end(), "F"));
    }
  }
  return generation;
}

TEST(Genome, StaysInItsRangesAndBalanced) {
  for (const bool variesProductions : {false, true}) {
    const EvolutionSettings settings = settingsOf(variesProductions);
    Generation generation = judged(firstGeneration(settings));
    for (int i = 0; i < 200; ++i) {
      for (const Individual& individual : generation.individuals) {
        for (std::size_t gene = 0; gene < settings.shape.genes.size(); ++gene) {
          ASSERT_GE(individual.genome.values[gene], settings.shape.genes[gene].low);
          ASSERT_LE(individual.genome.values[gene], settings.shape.genes[gene].high);
        }
        for (const Successor& successor : individual.genome.successors) {
          ASSERT_TRUE(isBalanced(successor));
          ASSERT_FALSE(successor.empty());
          ASSERT_LE(successor.size(), settings.shape.longestSuccessor);
        }
      }
      generation = judged(nextGeneration(settings, generation));
    }
  }
}

// children of BLX-0.5 are uniform in the interval of their parents, half of it wider on both sides (Eshelman & Schaffer
// 1993)
TEST(Genome, AChildLiesInTheWidenedIntervalOfItsParents) {
  GenomeShape shape;
  shape.genes = {{"A", -100.0, 100.0}};
  const Genome first{.values = {3.0}, .successors = {}};
  const Genome second{.values = {1.0}, .successors = {}};
  constexpr std::uint64_t kChildren = 4000;
  double sum = 0.0;
  double least = 100.0;
  double most = -100.0;
  for (std::uint64_t i = 0; i < kChildren; ++i) {
    GenomeRandom random(5, 1, i);
    const double value = crossed(shape, first, second, random).values.front();
    sum += value;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  EXPECT_GE(least, 0.0);
  EXPECT_LT(least, 0.02);
  EXPECT_LE(most, 4.0);
  EXPECT_GT(most, 3.98);
  // uniform in 0 to 4: the mean of 4000 has the standard deviation 0.018; four of them
  EXPECT_NEAR(sum / kChildren, 2.0, 0.073);
}

TEST(Genome, AsManyNumbersChangeAsTheProbabilitySaysByATenthOfTheirRange) {
  GenomeShape shape;
  Genome genome;
  constexpr std::size_t kGenes = 4000;
  for (std::size_t i = 0; i < kGenes; ++i) {
    shape.genes.push_back({"A" + std::to_string(i), -50.0, 50.0});
    genome.values.push_back(0.0);
  }
  GenomeRandom random(5, 1, 0);
  mutate(shape, genome, 0.15, random);
  double changed = 0.0;
  double squares = 0.0;
  for (const double value : genome.values) {
    changed += value != 0.0 ? 1.0 : 0.0;
    squares += value * value;
  }
  // 4000 draws of probability 0.15: 600, standard deviation 22.6; four of them
  EXPECT_NEAR(changed, 600.0, 91.0);
  // the range is 100 and its tenth 10; the deviation of 600 steps has the standard deviation 0.29
  EXPECT_NEAR(std::sqrt(squares / changed), 10.0, 1.2);
}

TEST(Evolution, BeginsWithTheModelItself) {
  const EvolutionSettings settings = settingsOf(true);
  EXPECT_EQ(firstGeneration(settings).individuals.front().genome.successors, settings.successors);
}

TEST(Evolution, KeepsTheFittestAndImproves) {
  for (const bool variesProductions : {false, true}) {
    const EvolutionSettings settings = settingsOf(variesProductions);
    Generation generation = judged(firstGeneration(settings));
    const double first = generation.individuals[fittest(generation)].fitness;
    double best = first;
    for (int i = 0; i < 40; ++i) {
      generation = judged(nextGeneration(settings, generation));
      const double now = generation.individuals[fittest(generation)].fitness;
      ASSERT_GE(now, best) << "the elite passes on";
      best = now;
    }
    // the greatest sums: 20 + 0, and 24 times F
    EXPECT_GT(best, variesProductions ? 14.0 : 19.9);
    EXPECT_GT(best, first);
  }
}

TEST(Evolution, ParentsAreTheFittestOfTheirTournaments) {
  EvolutionSettings settings = settingsOf(false);
  settings.eliteCount = 0;
  settings.mutationProbability = 0.0;
  settings.crossoverProbability = 0.0;
  // everybody is in each tournament, but for a chance of (11/12)^400
  settings.tournamentSize = 400;
  const Generation generation = judged(firstGeneration(settings));
  const Genome& best = generation.individuals[fittest(generation)].genome;
  for (const Individual& child : nextGeneration(settings, generation).individuals) {
    EXPECT_EQ(child.genome, best);
  }
}

TEST(Evolution, AChildIsACopyUnlessItsParentsCross) {
  EvolutionSettings settings = settingsOf(false);
  settings.eliteCount = 0;
  settings.mutationProbability = 0.0;
  settings.tournamentSize = 1;
  const Generation generation = judged(firstGeneration(settings));
  const auto copies = [&](double crossoverProbability) {
    settings.crossoverProbability = crossoverProbability;
    const Generation next = nextGeneration(settings, generation);
    return std::count_if(next.individuals.begin(), next.individuals.end(), [&](const Individual& child) {
      return std::any_of(generation.individuals.begin(), generation.individuals.end(),
                         [&](const Individual& parent) { return parent.genome == child.genome; });
    });
  };
  EXPECT_EQ(copies(0.0), 12);
  // only of a parent that crosses with itself, in one case of twelve
  EXPECT_LT(copies(1.0), 6);
}

TEST(Evolution, WhatFailedToGrowIsBelowEverything) {
  Individual failed;
  Individual poor;
  poor.hasGrown = true;
  poor.fitness = -1e300;
  EXPECT_TRUE(isFitter(poor, failed));
  EXPECT_FALSE(isFitter(failed, poor));
}

TEST(EvolutionFile, GivesBackWhatWasWritten) {
  for (const bool variesProductions : {false, true}) {
    const EvolutionSettings settings = settingsOf(variesProductions);
    const Generation generation = judged(nextGeneration(settings, judged(firstGeneration(settings))));
    const auto read = readEvolution(writeEvolution(settings, generation), settings);
    ASSERT_TRUE(read) << read.error();
    EXPECT_EQ(read->number, 1U);
    // the next one is made from it as if nothing had happened
    const Generation next = nextGeneration(settings, generation);
    const Generation again = nextGeneration(settings, *read);
    for (std::size_t i = 0; i < next.individuals.size(); ++i) {
      EXPECT_EQ(next.individuals[i].genome, again.individuals[i].genome);
    }
  }
}

TEST(EvolutionFile, SaysWhyItCannotGoOn) {
  EvolutionSettings settings = settingsOf(false);
  const std::string file = writeEvolution(settings, judged(firstGeneration(settings)));
  settings.seed = 6;
  EXPECT_EQ(readEvolution(file, settings).error(), "it was made with another seed: 5, now 6");
  settings.seed = 5;
  settings.model = "changed";
  EXPECT_EQ(readEvolution(file, settings).error(), "the model, its view or its environment has changed since");
  EXPECT_EQ(readEvolution("{", settings).error().rfind("it is damaged: ", 0), 0U);
  EXPECT_EQ(readEvolution(std::string(200'000, '[') + std::string(200'000, ']'), settings).error(),
            "it is damaged: brackets are nested deeper than 64");
}

}  // namespace
}  // namespace espalier::command::evolution_test
