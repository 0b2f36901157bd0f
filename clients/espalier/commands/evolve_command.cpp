#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/environment_loading.h"
#include "clients/espalier/evolution/evolution.h"
#include "clients/espalier/evolution/fitness.h"
#include "clients/espalier/evolution/fitness_process.h"
#include "clients/espalier/evolution/model_variants.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/number_option.h"
#include "clients/espalier/output/outputs.h"
#include "clients/espalier/world_file.h"
#include "engine/core/number_text.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kProcessPrefix = "stdio:";

struct EvolveOptions {
  ModelOptions model;
  std::vector<std::string> genes;
  bool variesProductions = false;
  std::uint64_t longestSuccessor = 40;
  std::string fitness{kUsualFitness};
  double judgeSeconds = 60.0;
  std::uint64_t populationCount = 40;
  std::uint64_t generationCount = 30;
  std::uint64_t eliteCount = 1;
  double mutation = 0.15;
  double crossover = 0.7;
  std::string folder;
  bool isResumed = false;
  OutputOptions outputs;
};

std::string numberText(double value) {
  std::string text;
  core::appendNumber(text, value, core::NumberStyle::Shortest);
  return text;
}

// NAME=LOW:HIGH
std::optional<Gene> readGene(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::size_t colon = text.find(':', equals == std::string::npos ? 0 : equals);
  if (equals == std::string::npos || equals == 0 || colon == std::string::npos) {
    return std::nullopt;
  }
  const auto low = core::parseNumber(std::string_view(text).substr(equals + 1, colon - equals - 1));
  const auto high = core::parseNumber(std::string_view(text).substr(colon + 1));
  if (!low || !high || !(*low < *high)) {
    return std::nullopt;
  }
  return Gene{text.substr(0, equals), *low, *high};
}

/// Grows and judges individuals, generation after generation, and writes the results.
class Evolution {
 public:
  explicit Evolution(EvolveOptions& options) : options_(options) {}

  int run() {
    if (!prepare()) {
      return kFailure;
    }
    std::optional<Generation> generation = begin();
    if (!generation) {
      return kFailure;
    }
    while (true) {
      if (!evaluate(*generation) || !report(*generation)) {
        return kFailure;
      }
      if (generation->number >= options_.generationCount) {
        break;
      }
      generation = nextGeneration(settings_, *generation);
    }
    return finish(*generation);
  }

 private:
  [[nodiscard]] std::string path(const std::string& name) const { return (fs::path(options_.folder) / name).string(); }
  [[nodiscard]] bool usesProcess() const { return options_.fitness.rfind(kProcessPrefix, 0) == 0; }

  bool prepare() {
    if (!usesProcess()) {
      if (const auto problem = FitnessFormula::read(options_.fitness, formula_)) {
        printError("--fitness: " + *problem + " Or give 'stdio:COMMAND', a program that judges plants");
        return false;
      }
    }
    server::DiskFileProvider files;
    std::shared_ptr<const language::Program> program = loadProgram(options_.model, files, &folder_);
    if (!program) {
      return false;
    }
    auto world = chooseWorld(options_.model, worldFileOf(options_.model), files);
    if (!world) {
      return false;
    }
    world_ = std::move(world->world);
    viewFile_ = program->viewFile;
    hasMadeView_ = !viewFile_.empty() && !files.read(viewFile_);
    std::vector<Gene> genes;
    for (const std::string& text : options_.genes) {
      genes.push_back(*readGene(text));
    }
    settings_.model = std::to_string(program->hash) + " " + options_.model.environment + " " +
                      (options_.model.steps ? std::to_string(*options_.model.steps) : std::string("-"));
    settings_.model += (world->text.empty() ? "" : " ") + world->text;
    auto variants = ModelVariants::make(program, std::move(genes), options_.variesProductions,
                                        static_cast<std::size_t>(options_.longestSuccessor));
    if (!variants) {
      printError(variants.error());
      return false;
    }
    variants_.emplace(std::move(*variants));
    settings_.fitness = options_.fitness;
    settings_.seed = options_.model.seed.value_or(1);
    settings_.populationCount = static_cast<std::size_t>(options_.populationCount);
    settings_.eliteCount = static_cast<std::size_t>(options_.eliteCount);
    settings_.mutationProbability = options_.mutation;
    settings_.crossoverProbability = options_.crossover;
    settings_.shape = variants_->shape();
    settings_.successors = variants_->successors();
    // every individual grows with the same seed, so that a genome keeps its fitness
    options_.model.seed = settings_.seed;
    if (usesProcess()) {
      auto process = FitnessProcess::start(options_.fitness.substr(kProcessPrefix.size()));
      if (!process) {
        printError("--fitness: " + process.error());
        return false;
      }
      process_ = std::move(*process);
    }
    return true;
  }

  // the first generation, or the last one of an earlier run
  std::optional<Generation> begin() {
    std::error_code error;
    fs::create_directories(options_.folder, error);
    if (!fs::is_directory(options_.folder, error)) {
      printError("cannot make the folder '" + options_.folder + "'");
      return std::nullopt;
    }
    server::DiskFileProvider files;
    const std::optional<std::string> text = files.read(path("evolution.json"));
    if (!options_.isResumed) {
      if (text) {
        printError("'" + options_.folder + "' holds an earlier run: continue it with --resume, or give another folder");
        return std::nullopt;
      }
      return firstGeneration(settings_);
    }
    if (!text) {
      printError("there is no earlier run in '" + path("evolution.json") + "': leave out --resume");
      return std::nullopt;
    }
    auto generation = readEvolution(*text, settings_);
    if (!generation) {
      printError("cannot continue from '" + path("evolution.json") + "': " + generation.error());
      return std::nullopt;
    }
    history_ = files.read(path("generations.csv")).value_or("");
    isReported_ = true;
    return std::move(*generation);
  }

  // a plant of a genome, grown to its last step
  [[nodiscard]] Result<std::unique_ptr<simulation::Simulation>> grow(const Genome& genome) const {
    server::DiskFileProvider files;
    const auto program = variants_->program(genome, files);
    if (!program) {
      return problem(program.error());
    }
    ModelOptions model = options_.model;
    model.isQuiet = true;
    std::unique_ptr<turtle::EnvironmentProcess> environment;
    if (!model.environment.empty()) {
      std::optional<LoadedEnvironment> loaded =
          loadEnvironment(model.environment, model.mode(), true, files, model.remote);
      if (!loaded) {
        return problem("its environment cannot be made");
      }
      environment = std::move(loaded->process);
    }
    simulation::SimulationOptions simulationOptions = simulationOptionsFor(model, **program);
    simulationOptions.threads = 1;
    simulationOptions.fileWriter = nullptr;
    simulationOptions.messages = {};
    simulationOptions.palette = folder_.palette;
    simulationOptions.world = world_;
    auto simulation = std::make_unique<simulation::Simulation>(*program, std::vector<turtle::PlantPlacement>(1),
                                                               std::move(environment), std::move(simulationOptions));
    if (const auto failure = simulation->rewind()) {
      return problem(formatSimulationError(*failure));
    }
    const std::optional<std::uint64_t> last = server::lastStepOf(folder_, model.steps, *simulation);
    while (!server::isOver(*simulation, last)) {
      if (const auto failure = simulation->step()) {
        return problem(formatSimulationError(*failure));
      }
    }
    return simulation;
  }

  // fills in the fitness of one individual; an error sentence when the run must end
  std::optional<std::string> evaluateOne(const Generation& generation, std::size_t number, Individual& individual) {
    individual.isEvaluated = true;
    const auto grown = grow(individual.genome);
    if (!grown) {
      noteFailure(grown.error());
      return std::nullopt;
    }
    const simulation::Simulation& simulation = **grown;
    auto scene = simulation.scene();
    if (!scene) {
      noteFailure(formatSimulationError(scene.error()));
      return std::nullopt;
    }
    turtle::Scene& drawn = *scene;
    individual.modules = simulation.string().size();
    individual.hasGrown = true;
    if (!process_) {
      individual.measures = measurePlant(std::move(drawn), simulation.program().view);
      individual.fitness = formula_(individual.measures);
      return std::nullopt;
    }
    individual.measures = measurePlant(turtle::Scene(drawn), simulation.program().view);
    const JudgedPlant plant{.generation = generation.number,
                            .individual = number,
                            .modules = individual.modules,
                            .shape = settings_.shape,
                            .genome = individual.genome,
                            .measures = individual.measures,
                            .scene = drawn,
                            .string = simulation.stringText()};
    const std::scoped_lock lock(judging_);
    if (hasJudgeFailed_) {
      return std::nullopt;  // the run ends with the first failure of the judge
    }
    const auto judged = process_->judge(plant, options_.judgeSeconds);
    if (!judged) {
      hasJudgeFailed_ = true;
      return judged.error();
    }
    individual.fitness = *judged;
    return std::nullopt;
  }

  void noteFailure(const std::string& problem) {
    const std::scoped_lock lock(judging_);
    if (firstFailure_.empty()) {
      firstFailure_ = problem;
    }
  }

  bool evaluate(Generation& generation) {
    std::atomic<std::size_t> next{0};
    std::optional<std::string> problem;
    const auto work = [&] {
      while (true) {
        const std::size_t number = next++;
        if (number >= generation.individuals.size()) {
          return;
        }
        Individual& individual = generation.individuals[number];
        if (individual.isEvaluated) {
          continue;
        }
        if (const auto failure = evaluateOne(generation, number, individual)) {
          const std::scoped_lock lock(judging_);
          problem = problem ? problem : failure;
          next = generation.individuals.size();
        }
      }
    };
    {
      std::vector<std::jthread> helpers;
      for (unsigned i = 1; i < options_.model.threadCount(); ++i) {
        helpers.emplace_back(work);
      }
      work();
    }
    if (problem) {
      printError("generation " + std::to_string(generation.number) + ": " + *problem +
                 ". Correct this and continue with --resume");
      return false;
    }
    const auto grown = std::count_if(generation.individuals.begin(), generation.individuals.end(),
                                     [](const Individual& individual) { return individual.hasGrown; });
    if (grown == 0) {
      printError("no plant of generation " + std::to_string(generation.number) +
                 " grew to its end. The first failed with:\n" + firstFailure_);
      return false;
    }
    return true;
  }

  // writes a line on standard error, a line of the table, a picture of the best, and the state for --resume
  bool report(const Generation& generation) {
    if (isReported_) {
      isReported_ = false;
      return true;
    }
    double sum = 0.0;
    double worst = INFINITY;
    std::size_t grown = 0;
    for (const Individual& individual : generation.individuals) {
      if (individual.hasGrown) {
        sum += individual.fitness;
        worst = std::min(worst, individual.fitness);
        ++grown;
      }
    }
    const Individual& best = generation.individuals[fittest(generation)];
    const double mean = sum / static_cast<double>(grown);
    const std::size_t failed = generation.individuals.size() - grown;
    addToHistory(generation.number, best, mean, worst, failed);
    if (!options_.model.isQuiet) {
      char line[200];
      std::snprintf(line, sizeof line, "generation %u: best %.6g, mean %.6g, worst %.6g%s", generation.number,
                    best.fitness, mean, worst, failed > 0 ? (", " + std::to_string(failed) + " failed").c_str() : "");
      printNote(line);
    }
    const auto grownBest = grow(best.genome);
    OutputOptions picture = options_.outputs;
    picture.files = {path("best.png")};
    picture.format.clear();
    const OutputWriter writer(picture, true);
    if (!writer.write(**grownBest, generation.number, 4)) {
      return false;
    }
    // write the state last: the files that it refers to are complete
    std::vector<std::pair<std::string, std::string>> written{{"generations.csv", history_},
                                                             {"best.l", bestText(generation)}};
    if (hasMadeView_) {
      written.emplace_back("best.v", variants_->viewText());
    }
    written.emplace_back("evolution.json", writeEvolution(settings_, generation));
    for (const auto& [name, content] : written) {
      if (const auto problem = server::writeFileAtomically(path(name), content)) {
        printError(*problem);
        return false;
      }
    }
    return true;
  }

  void addToHistory(std::uint32_t number, const Individual& best, double mean, double worst, std::size_t failed) {
    if (history_.empty()) {
      history_ = "generation,best,mean,worst,failed,modules";
      for (const std::string_view name : kMeasureNames) {
        history_ += "," + std::string(name);
      }
      for (const Gene& gene : settings_.shape.genes) {
        history_ += "," + gene.name;
      }
      for (const std::string& predecessor : settings_.shape.predecessors) {
        history_ += "," + predecessor;
      }
      history_ += "\n";
    }
    history_ += std::to_string(number) + "," + numberText(best.fitness) + "," + numberText(mean) + "," +
                numberText(worst) + "," + std::to_string(failed) + "," + std::to_string(best.modules);
    for (std::size_t i = 0; i < kMeasureNames.size(); ++i) {
      history_ += "," + numberText(measure(best.measures, i));
    }
    for (const double value : best.genome.values) {
      history_ += "," + numberText(value);
    }
    for (const Successor& successor : best.genome.successors) {
      history_ += ",\"";
      for (const std::string& module : successor) {
        history_ += module;
      }
      history_ += "\"";
    }
    history_ += "\n";
  }

  [[nodiscard]] std::string bestText(const Generation& generation) const {
    const Individual& best = generation.individuals[fittest(generation)];
    return variants_->text(best.genome, "the fittest of generation " + std::to_string(generation.number) + " by " +
                                            settings_.fitness + ": " + numberText(best.fitness));
  }

  int finish(const Generation& generation) {
    if (!options_.model.isQuiet) {
      const std::string view = viewFile_.empty() || hasMadeView_ ? "" : " --view " + viewFile_;
      printNote("wrote " + path("best.l") + " (fitness " +
                numberText(generation.individuals[fittest(generation)].fitness) + "), " + path("generations.csv") +
                " and a picture of the best plant of each generation. Draw it: espalier run " + path("best.l") + view +
                " --seed " + std::to_string(settings_.seed) + " -o best.glb");
    }
    return kSuccess;
  }

  EvolveOptions& options_;
  EvolutionSettings settings_;
  server::FolderSettings folder_;
  turtle::World world_;
  FitnessFormula formula_;
  std::optional<ModelVariants> variants_;
  std::unique_ptr<FitnessProcess> process_;
  std::mutex judging_;  // of process_, hasJudgeFailed_ and firstFailure_
  bool hasJudgeFailed_ = false;
  std::string firstFailure_;
  std::string history_;
  std::string viewFile_;      // of the model; empty: none
  bool hasMadeView_ = false;  // the dialect made the view; no such file exists
  bool isReported_ = false;   // the generation was read from a file and is complete
};

}  // namespace

void addEvolve(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("evolve", "Breed plants by a genetic algorithm");
  command->footer(
      "Varies numbers of a model, or the productions of a bracketed D0L-system. Fitter plants get more offspring.\n"
      "FOLDER receives best.l, a table of the generations, a picture of the best plant of each, and the state for\n"
      "--resume. The result depends on the seed and not on the number of threads.\n"
      "The fitness is a product of powers of measures: height, light (ground shaded from above), sky (the same from "
      "the\n"
      "whole sky), symmetry (bilateral, 0 to 1), stability (0 to 1), branching (0 to 1), length (of all lines), "
      "extent\n"
      "(greatest span), organs (number). The default fitness does not depend on the size of a plant.\n"
      "Examples:\n"
      "  espalier evolve tree.l --gene ANGLE=10:80 --gene RATIO=0.5:0.95 --fitness light=1,length=-0.5 -o bred\n"
      "  espalier evolve weed.l --productions --generations 50 -o bred\n"
      "  espalier evolve tree.l --gene ANGLE=10:80 --fitness 'stdio:python3 fitness.py' -o bred");
  auto options = std::make_shared<EvolveOptions>();
  addReadingOptions(*command, options->model, true);
  addRunningOptions(*command, options->model);
  CLI::Option* genes =
      command
          ->add_option("--gene", options->genes,
                       "Vary the number of this #define between LOW and HIGH. May be repeated")
          ->type_name("NAME=LOW:HIGH")
          ->allow_extra_args(false)
          ->check([](const std::string& text) {
            return readGene(text) ? std::string{} : "'" + text + "' is not a gene: give NAME=LOW:HIGH with LOW < HIGH";
          });
  command->add_flag("--productions", options->variesProductions, "Vary the productions")->excludes(genes);
  addWholeNumber(*command, "--longest", "Largest number of modules in a successor (40)", 1, 10'000,
                 [options](std::uint64_t count) { options->longestSuccessor = count; });
  command->add_option("--fitness", options->fitness, "Measures with exponents, or 'stdio:COMMAND'")
      ->capture_default_str();
  addPositiveNumber(*command, "--fitness-seconds", "Longest time of the fitness program for a plant, in seconds (60)",
                    "seconds", [options](double seconds) { options->judgeSeconds = seconds; });
  addWholeNumber(*command, "--population", "Plants in a generation (40)", 2, 1'000'000,
                 [options](std::uint64_t count) { options->populationCount = count; });
  addWholeNumber(*command, "--generations", "Number of the last generation; the first is 0 (30)", 0, 1'000'000,
                 [options](std::uint64_t count) { options->generationCount = count; });
  addWholeNumber(*command, "--elite", "Number of the best plants that stay unchanged in the next generation (1)", 0,
                 1'000'000, [options](std::uint64_t count) { options->eliteCount = count; });
  command->add_option("--mutation", options->mutation, "Probability that a gene changes (0.15)")
      ->check(numberFrom(0.0, 1.0));
  command->add_option("--crossover", options->crossover, "Probability that a child has two parents (0.7)")
      ->check(numberFrom(0.0, 1.0));
  command->add_option("-o,--output", options->folder, "Folder for the results")->required()->type_name("FOLDER");
  command->add_flag("--resume", options->isResumed, "Continue the run in FOLDER");
  command->callback([options, &status] {
    if (options->genes.empty() && !options->variesProductions) {
      throw CLI::RequiredError("--gene NAME=LOW:HIGH or --productions");
    }
    options->outputs.picture.widthPixels = 400;
    options->outputs.picture.heightPixels = 400;
    options->outputs.picture.threads = options->model.threadCount();
    status = Evolution(*options).run();
  });
}

}  // namespace espalier::command
