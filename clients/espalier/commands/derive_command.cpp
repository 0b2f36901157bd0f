#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/output/string_output.h"
#include "clients/espalier/time_limit.h"
#include "clients/espalier/trace_option.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

struct DeriveOptions {
  ModelOptions model;
  TraceOption trace;
  bool printsEveryStep = false;
  bool printsAnswered = false;
  bool printsHash = false;
  bool hasStatistics = false;
};

// sums of a run, in the units of --statistics
struct RunFigures {
  std::uint64_t queries = 0;
  double derivationMilliseconds = 0.0;
  double environmentMilliseconds = 0.0;
};

using Failure = std::optional<core::SimulationError>;

// runs one part of a step and adds its wall time
template <typename Part>
Failure timed(double& milliseconds, const Part& part) {
  const auto start = std::chrono::steady_clock::now();
  Failure outcome = part();
  milliseconds += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  return outcome;
}

/// Prints the strings of a simulation as the options ask for.
class StringPrinter {
 public:
  explicit StringPrinter(const DeriveOptions& options)
      : printsHash_(options.printsHash), writer_(options.model.threadCount()) {}

  // one line; for a forest one line for each living plant, after its number and a TAB. Or the hash of the state
  void print(const simulation::Simulation& simulation, const std::string& before) {
    if (printsHash_) {
      std::printf("%s%016llx\n", before.c_str(), static_cast<unsigned long long>(simulation.stateHash()));
      return;
    }
    const bool isForest = simulation.plantCount() > 1;
    for (std::size_t plant = 0; plant < simulation.plantCount(); ++plant) {
      if (simulation.plant(plant).isAlive()) {
        std::printf("%s%s", before.c_str(), isForest ? (std::to_string(plant) + "\t").c_str() : "");
        printString(writer_, simulation.program(plant), simulation.string(plant));
      }
    }
  }

  void printStep(const simulation::Simulation& simulation) {
    print(simulation, std::to_string(simulation.completedSteps()) + "\t");
  }

 private:
  bool printsHash_;
  derivation::TextWriter writer_;
};

// makes all steps, or the steps up to `last`, and prints the strings that the options ask for; a string with answers
// belongs to the step before
Failure runAllSteps(simulation::Simulation& simulation, DeriveOptions& options, const server::FolderSettings& folder,
                    RunFigures& figures) {
  if (Failure failure = simulation.rewind()) {
    return failure;
  }
  options.trace.begin(simulation);
  // --steps is the derivation length itself
  const std::optional<std::uint64_t> last =
      options.model.steps ? std::nullopt : server::lastStepOf(folder, std::nullopt, simulation);
  StringPrinter printer(options);
  const bool printsDerived = options.printsEveryStep && !options.printsAnswered;
  if (printsDerived) {
    printer.printStep(simulation);
  }
  while (!server::isOver(simulation, last)) {
    if (Failure failure = timed(figures.environmentMilliseconds, [&] { return simulation.answer(); })) {
      return failure;
    }
    if (options.printsAnswered) {
      printer.printStep(simulation);
    }
    if (Failure failure = timed(figures.derivationMilliseconds, [&] { return simulation.step(); })) {
      return failure;
    }
    options.trace.complete(simulation);
    figures.queries += simulation.statistics().queries;
    if (printsDerived) {
      printer.printStep(simulation);
    }
  }
  // with `environment display: before` the last string is answered too
  if (options.printsAnswered && simulation.program().view.hasEnvironmentDisplayBefore) {
    if (Failure failure = timed(figures.environmentMilliseconds, [&] { return simulation.answer(); })) {
      return failure;
    }
    printer.printStep(simulation);
  }
  if (!options.printsEveryStep) {
    printer.print(simulation, "");
  }
  return std::nullopt;
}

void printStatistics(const simulation::Simulation& simulation, const RunFigures& figures) {
  const simulation::StepStatistics& statistics = simulation.statistics();
  std::fflush(stdout);
  std::fprintf(stderr,
               "{\"steps\":%llu,\"modules\":%llu,\"parameters\":%llu,\"queries\":%llu,\"derivationMilliseconds\":%.3f,"
               "\"environmentMilliseconds\":%.3f,\"bytes\":%llu}\n",
               static_cast<unsigned long long>(simulation.completedSteps()),
               static_cast<unsigned long long>(statistics.modules),
               static_cast<unsigned long long>(statistics.parameters), static_cast<unsigned long long>(figures.queries),
               figures.derivationMilliseconds, figures.environmentMilliseconds,
               static_cast<unsigned long long>(statistics.bytes));
}

int derive(DeriveOptions& options) {
  server::DiskFileProvider files;
  std::optional<LoadedModel> loaded = loadModel(options.model, files);
  if (!loaded || !options.trace.open(loaded->environment)) {
    return kFailure;
  }
  simulation::Simulation simulation(loaded->programs, loaded->plants, std::move(loaded->environment.process),
                                    std::move(loaded->simulationOptions));
  const TimeLimit time(simulation, options.model.seconds());
  RunFigures figures;
  const Failure failure = runAllSteps(simulation, options, loaded->folder, figures);
  if (failure) {
    printError(formatSimulationError(time.explained(*failure)));
  }
  if (options.hasStatistics) {
    printStatistics(simulation, figures);
  }
  return options.trace.close() && !failure ? kSuccess : kFailure;
}

}  // namespace

void addDerive(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("derive", "Derive a model and print its string");
  command->footer(
      "Prints the string of the last step. With --every it prints one line for each step: its number, a TAB, the "
      "string.\n"
      "For a forest it prints one line for each living plant: its number, a TAB, its string. With --hash it prints the "
      "hash of the state instead.\n"
      "Examples:\n"
      "  espalier derive tree.l --every\n"
      "  espalier derive tiers.l --environment honda.json --steps 12\n"
      "  espalier derive plant.l --environment 'stdio:python3 my_environment.py'");
  auto options = std::make_shared<DeriveOptions>();
  addReadingOptions(*command, options->model, true);
  addRunningOptions(*command, options->model);
  CLI::Option* every = command->add_flag("--every", options->printsEveryStep, "Print the string of every step, from 0");
  command
      ->add_flag("--answered", options->printsAnswered,
                 "With --every: print each string after its queries are answered, instead of as derived")
      ->needs(every);
  command->add_flag(
      "--hash", options->printsHash,
      "Print the hash of the complete state (strings, variables, random numbers, environment) instead of\n"
      "the string. Equal hashes mean equal bits");
  options->trace.addTo(*command);
  command->add_flag("--statistics", options->hasStatistics,
                    "Print one JSON object with counts and times (ms) of the run on standard error");
  command->callback([options, &status] { status = derive(*options); });
}

}  // namespace espalier::command
