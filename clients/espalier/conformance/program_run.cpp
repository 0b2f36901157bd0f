#include "clients/espalier/conformance/program_run.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <utility>

namespace espalier::conformance {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kShownErrors = 200;  // characters of a program's standard error in a message

std::optional<std::string> readFile(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return stream ? std::optional(std::string(std::istreambuf_iterator<char>(stream), {})) : std::nullopt;
}

std::string fileWord(const fs::path& file) {
  std::error_code error;
  return quoted(fs::exists(file, error) ? file.string() : "");
}

/// A word of a command that names a file from the folder in which the user is, as `./run.sh`, gets its whole path: the
/// command runs in the folder of a case.
std::string withWholePaths(const std::string& command) {
  std::string result;
  for (std::size_t at = 0; at < command.size();) {
    const std::size_t end = std::min(command.find_first_of(" \t\n", at), command.size());
    const std::string word = command.substr(at, end - at);
    std::error_code error;
    const bool isFile = word.find('/') != std::string::npos && fs::is_regular_file(word, error);
    result += isFile ? quoted(fs::absolute(word, error).lexically_normal().string()) : word;
    const std::size_t next = std::min(command.find_first_not_of(" \t\n", end), command.size());
    result += command.substr(end, next - end);
    at = next;
  }
  return result;
}

std::string commandFor(std::string command, const ConformanceCase& entry, const fs::path& folder) {
  command = withWholePaths(command);
  if (command.find("{model}") == std::string::npos) {
    command += " {model}";
  }
  const std::pair<std::string, std::string> words[] = {{"{model}", fileWord(folder / "model.l")},
                                                       {"{view}", fileWord(folder / "model.v")},
                                                       {"{environment}", fileWord(folder / "model.e")},
                                                       {"{folder}", quoted(folder.string())},
                                                       {"{steps}", std::to_string(entry.steps)}};
  for (const auto& [name, word] : words) {
    for (std::size_t at = command.find(name); at != std::string::npos; at = command.find(name, at + word.size())) {
      command.replace(at, name.size(), word);
    }
  }
  return command;
}

std::string firstWordsOf(const std::string& errors) {
  const std::string line = errors.substr(0, errors.find('\n')).substr(0, kShownErrors);
  return line.empty() ? "" : ": " + line;
}

// the strings that a program prints; a sentence that begins with `the program` otherwise
std::optional<std::vector<std::string>> stringsOf(const std::string& command, const ConformanceCase& entry,
                                                  const fs::path& folder, const ProgramLimits& limits,
                                                  std::string& errors, std::string& problem) {
  const std::string expected = "; expected " + std::to_string(entry.steps + 1) +
                               " lines, one for each step from 0 on: its number, a TAB, and the string";
  const auto run = runProgram(commandFor(command, entry, folder), folder.string(), limits);
  if (!run) {
    problem = "the program " + run.error() + expected;
    return std::nullopt;
  }
  errors = run->errors;
  if (run->status != 0) {
    problem = "the program ends with status " + std::to_string(run->status) + ", expected 0" + firstWordsOf(errors);
    return std::nullopt;
  }
  auto strings = readSteps(run->output, problem);
  if (strings && strings->empty()) {
    problem = "the program prints nothing" + firstWordsOf(errors) + expected;
    return std::nullopt;
  }
  return strings;
}

}  // namespace

std::string runCase(const ConformanceCase& entry, const std::string& suite, const ProgramCommands& commands,
                    Deviation& largest) {
  const fs::path folder = fs::path(suite) / entry.name;
  const auto derivedFile = readFile(folder / "expected.txt");
  if (!derivedFile) {
    return "cannot read " + (folder / "expected.txt").string();
  }
  std::string problem;
  std::string log;
  const auto derived = stringsOf(commands.derived, entry, folder, commands.limits, log, problem);
  if (!derived) {
    return problem;
  }
  problem = compareSteps(*derived, *derivedFile, "derived", entry.tolerance, largest);
  if (!problem.empty()) {
    return problem;
  }
  const auto logFile = commands.printsLog ? readFile(folder / "expected-log.txt") : std::nullopt;
  if (logFile && *logFile != log) {
    return "log: expected\n" + *logFile + "actual\n" + log;
  }

  const auto answeredFile =
      entry.hasTurtleFile && !commands.answered.empty() ? readFile(folder / "expected-turtle.txt") : std::nullopt;
  if (!answeredFile) {
    return {};
  }
  const auto answered = stringsOf(commands.answered, entry, folder, commands.limits, log, problem);
  return answered ? compareSteps(*answered, *answeredFile, "answered", entry.tolerance, largest) : problem;
}

}  // namespace espalier::conformance
