#include "tests/conformance/suite.h"

#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "engine/language/compiler.h"
#include "engine/simulation/simulation.h"
#include "environment/published/published_environment.h"
#include "tests/support/disk_files.h"
#include "tests/support/places.h"

namespace espalier::test {
namespace {

// the result of a run of a case, one string per step
struct Recording {
  std::vector<std::string> derived;
  std::vector<std::string> answered;
  std::string log;
  std::string failure;  // empty: ran to its end
};

std::string firstMessage(const std::vector<core::Diagnostic>& diagnostics) {
  for (const core::Diagnostic& diagnostic : diagnostics) {
    if (diagnostic.severity == core::Severity::Error) {
      return core::formatDiagnostic(diagnostic);
    }
  }
  return "no error was given";
}

bool exists(const std::string& file) {
  return readFile(file).has_value();
}

std::string describe(const core::SimulationError& error) {
  return "step " + std::to_string(error.step) + ": " + error.message;
}

// steps a simulation to its end; with `answersFirst` the answers are taken apart from the step
void runSimulation(simulation::Simulation& simulation, bool isDisplayedBefore, bool answersFirst,
                   Recording& recording) {
  const auto failed = [&](const std::optional<core::SimulationError>& error) {
    if (error) {
      recording.failure = describe(*error);
    }
    return error.has_value();
  };
  if (failed(simulation.rewind())) {
    return;
  }
  recording.derived.push_back(simulation.stringText());
  while (!simulation.isFinished()) {
    if (answersFirst) {
      if (failed(simulation.answer())) {
        return;
      }
      recording.answered.push_back(simulation.stringText());
    }
    if (failed(simulation.step())) {
      return;
    }
    recording.derived.push_back(simulation.stringText());
  }
  if (answersFirst && isDisplayedBefore && !failed(simulation.answer())) {
    recording.answered.push_back(simulation.stringText());
  }
}

Recording record(const ConformanceCase& entry, core::Compatibility compatibility, bool answersFirst) {
  Recording recording;
  const std::string folder = casesFolder() + "/" + entry.name + "/";
  DiskFiles files;
  language::CompileInput input;
  input.modelFile = folder + "model.l";
  input.viewFile = exists(folder + "model.v") ? folder + "model.v" : "";
  input.compatibility = compatibility;
  const language::CompileResult compiled = language::compile(input, files);
  if (!compiled.program) {
    recording.failure = "does not compile: " + firstMessage(compiled.diagnostics.entries());
    return recording;
  }

  std::unique_ptr<turtle::EnvironmentProcess> process;
  if (exists(folder + "model.e")) {
    std::vector<core::Diagnostic> warnings;
    auto made = environment::makeFromEnvironmentFile(folder + "model.e", files, compatibility, warnings);
    if (!made) {
      recording.failure = "environment: " + firstMessage(made.error());
      return recording;
    }
    process = std::move(*made);
  }

  simulation::SimulationOptions options;
  options.messages = [&recording](core::MessageKind kind, std::string_view text) {
    if (kind == core::MessageKind::Printf) {
      recording.log += text;
    }
  };
  simulation::Simulation simulation(compiled.program, {turtle::PlantPlacement{}}, std::move(process),
                                    std::move(options));
  runSimulation(simulation, compiled.program->view.hasEnvironmentDisplayBefore, answersFirst, recording);
  return recording;
}

// compares recorded strings with a file of `step TAB string` lines
std::string compareWithFile(const std::vector<std::string>& strings, const std::string& file, const char* which,
                            const conformance::Tolerance& tolerance, Deviation& largest) {
  const std::optional<std::string> text = readFile(file);
  return text ? conformance::compareSteps(strings, *text, which, tolerance, largest) : "cannot read " + file;
}

}  // namespace

std::string casesFolder() {
  return sourceFolder() + "/tests/conformance/cases";
}

std::string listFile(const std::string& name) {
  return sourceFolder() + "/tests/conformance/" + name;
}

std::vector<ConformanceCase> readCases() {
  const std::optional<std::string> table = readFile(casesFolder() + "/cases.tsv");
  if (!table) {
    throw std::runtime_error("cannot read " + casesFolder() + "/cases.tsv");
  }
  const auto cases = conformance::readCases(*table);
  if (!cases) {
    throw std::runtime_error("a line of cases.tsv has too few columns");
  }
  return *cases;
}

std::map<std::string, std::string> readExceptions(const std::string& file) {
  const std::optional<std::string> text = readFile(file);
  if (!text) {
    throw std::runtime_error("cannot read " + file);
  }
  std::map<std::string, std::string> exceptions;
  std::istringstream lines(*text);
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') {
      continue;
    }
    const std::size_t blank = line.find(' ');
    exceptions[line.substr(0, blank)] = blank == std::string::npos ? "" : line.substr(blank + 1);
  }
  return exceptions;
}

std::string runCase(const ConformanceCase& entry, core::Compatibility compatibility, Deviation& largest) {
  const std::string folder = casesFolder() + "/" + entry.name + "/";

  // plain steps give the derived strings
  const Recording plain = record(entry, compatibility, false);
  if (!plain.failure.empty()) {
    return plain.failure;
  }
  std::string difference = compareWithFile(plain.derived, folder + "expected.txt", "derived", entry.tolerance, largest);
  if (!difference.empty()) {
    return difference;
  }
  if (plain.derived.size() != entry.steps + 1) {
    return "expected " + std::to_string(entry.steps) + " steps, actual " + std::to_string(plain.derived.size() - 1);
  }
  if (const auto log = readFile(folder + "expected-log.txt"); log && *log != plain.log) {
    return "log: expected\n" + *log + "actual\n" + plain.log;
  }

  // answering apart from deriving shows the strings with their answers and changes nothing else
  const Recording answered = record(entry, compatibility, true);
  if (!answered.failure.empty()) {
    return "when answered apart: " + answered.failure;
  }
  if (answered.derived != plain.derived) {
    return "answering apart from deriving changes the derived strings";
  }
  return entry.hasTurtleFile
             ? compareWithFile(answered.answered, folder + "expected-turtle.txt", "answered", entry.tolerance, largest)
             : std::string{};
}

std::string judge(const ConformanceCase& entry, const std::string& difference,
                  const std::map<std::string, std::string>& exceptions, const std::string& list) {
  if (exceptions.count(entry.name) == 0) {
    return difference;
  }
  return difference.empty() ? entry.name + " passes now: remove it from " + list : std::string{};
}

}  // namespace espalier::test
