#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/conformance/program_run.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/number_option.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/gallery.h"

namespace espalier::command {
namespace {

namespace fs = std::filesystem;
using conformance::ConformanceCase;

struct ConformanceOptions {
  std::vector<std::string> names;  // parts of case names; empty: all
  std::set<std::string> kinds;     // empty: all
  std::string program;             // empty: this one
  std::string answered;            // the command for the strings with answers
  std::string folder;              // empty: the suite that came with the program
  double seconds = 10.0;
  bool printsLog = false;
  bool isQuiet = false;
  bool onlyLists = false;
};

bool isChosen(const ConformanceCase& entry, const ConformanceOptions& options) {
  const auto isPart = [&](const std::string& name) { return entry.name.find(name) != std::string::npos; };
  return (options.kinds.empty() || options.kinds.contains(entry.kind)) &&
         (options.names.empty() || std::ranges::any_of(options.names, isPart));
}

// the chosen cases, or nothing after the reason is printed
std::optional<std::vector<ConformanceCase>> chosenCases(const ConformanceOptions& options) {
  server::DiskFileProvider files;
  const std::string table = (fs::path(options.folder) / "cases.tsv").string();
  const auto text = options.folder.empty() ? std::nullopt : files.read(table);
  if (!text) {
    printError(options.folder.empty()
                   ? "the suite is not beside this program: name its folder with --cases FOLDER"
                   : "cannot read " + table + ": --cases takes the folder of a suite, with cases.tsv");
    return std::nullopt;
  }
  auto cases = conformance::readCases(*text);
  if (!cases) {
    printError(table + ": expected lines of case, kind, steps, tolerance, quirk and turtle, with a TAB between them");
    return std::nullopt;
  }
  for (const std::string& name : options.names) {
    const auto isPart = [&](const ConformanceCase& entry) { return entry.name.find(name) != std::string::npos; };
    if (std::ranges::none_of(*cases, isPart)) {
      printError("no case has '" + name + "' in its name: espalier conformance --list prints all cases");
      return std::nullopt;
    }
  }
  std::erase_if(*cases, [&](const ConformanceCase& entry) { return !isChosen(entry, options); });
  if (cases->empty()) {
    printError(
        "no case of this kind has one of these names: espalier conformance --list prints name and kind of all cases");
    return std::nullopt;
  }
  return cases;
}

/// A command that a shell could run; a variable of the shell may have been empty.
std::string problemOfCommand(const std::string& command) {
  return command.find_first_not_of(" \t\n") == std::string::npos ? "the command is empty: give the program to test"
                                                                 : "";
}

/// A program's bytes as one may print them: control characters could change the terminal.
std::string printable(std::string text) {
  std::ranges::replace_if(
      text, [](unsigned char c) { return (c < 0x20 && c != '\n' && c != '\t') || c == 0x7F; }, '?');
  return text;
}

conformance::ProgramCommands commandsOf(const ConformanceOptions& options) {
  conformance::ProgramCommands commands;
  commands.limits.time = std::chrono::milliseconds(static_cast<std::int64_t>(options.seconds * 1e3));
  commands.derived = options.program;
  commands.answered = options.answered;
  commands.printsLog = options.printsLog;
  if (options.program.empty()) {
    std::error_code error;
    const std::string derive = conformance::quoted(fs::read_symlink("/proc/self/exe", error).string()) +
                               " derive --every --quiet --compat cpfg {model}";
    commands = {.derived = derive, .answered = derive + " --answered", .printsLog = true, .limits = commands.limits};
  }
  return commands;
}

int list(const std::vector<ConformanceCase>& cases) {
  for (const ConformanceCase& entry : cases) {
    std::printf("%s\t%s\t%s\n", entry.name.c_str(), entry.kind.c_str(), entry.checks.c_str());
  }
  return kSuccess;
}

int runAll(const std::vector<ConformanceCase>& cases, const ConformanceOptions& options) {
  const conformance::ProgramCommands commands = commandsOf(options);
  std::size_t failed = 0;
  std::size_t leftOut = 0;
  std::string place;
  double share = 0.0;
  for (const ConformanceCase& entry : cases) {
    conformance::Deviation largest;
    const std::string difference = conformance::runCase(entry, options.folder, commands, largest);
    leftOut += entry.hasTurtleFile && commands.answered.empty() ? 1 : 0;
    if (largest.share > share) {
      share = largest.share;
      place = entry.name + ", " + largest.place;
    }
    failed += difference.empty() ? 0 : 1;
    if (!difference.empty()) {
      std::printf("failed %s: %s\n", entry.name.c_str(), printable(difference).c_str());
    } else if (!options.isQuiet) {
      std::printf("passed %s\n", entry.name.c_str());
    }
    std::fflush(stdout);
  }
  if (leftOut > 0 && !options.isQuiet) {
    printNote("of " + std::to_string(leftOut) +
              " cases the strings with answers are not compared: name a command for them with --answered");
  }
  if (share > 0.0) {
    std::printf("largest accepted deviation: %.3f of the tolerance in %s\n", share, place.c_str());
  }
  std::printf("%zu passed, %zu failed\n", cases.size() - failed, failed);
  return failed == 0 ? kSuccess : kFailure;
}

int runSuite(ConformanceOptions& options) {
  if (options.folder.empty()) {
    options.folder = server::conformanceOfProgram();
  } else {
    std::error_code error;
    options.folder = fs::absolute(options.folder, error).string();
  }
  const auto cases = chosenCases(options);
  if (!cases) {
    return kFailure;
  }
  return options.onlyLists ? list(*cases) : runAll(*cases, options);
}

}  // namespace

void addConformance(CLI::App& program, int& status) {
  CLI::App* command =
      program.add_subcommand("conformance", "Run the conformance suite of the cpfg dialect, with any program");
  command->footer(
      "Runs each case by a program, compares every string with the recorded one, and prints `passed` or `failed` with\n"
      "the first difference. The last line counts. Exit status 1 when a case fails.\n"
      "A program under test prints a line for each step from 0 on: its number, a TAB, and the string. In its command\n"
      "{model}, {view}, {environment}, {folder} and {steps} are replaced; without {model} the model is the last word.\n"
      "It runs in the folder of the case; a file as ./run.sh is the one of your folder.\n"
      "docs/conformance.md describes the suite.\n"
      "Examples:\n"
      "  espalier conformance\n"
      "  espalier conformance --program 'my-lsystem --steps {steps}' --kind deterministic\n"
      "  espalier conformance 101 cut --program './run.sh {model} {view}'");
  auto options = std::make_shared<ConformanceOptions>();
  command->add_option("case", options->names, "Parts of the names of cases (default: all)")->type_name("CASE");
  CLI::Option* tested = command->add_option(
      "--program", options->program,
      "Command that prints the derived strings of a model (default: this program with --compat cpfg)");
  tested->type_name("COMMAND")->check(problemOfCommand);
  command
      ->add_option("--answered", options->answered,
                   "Command that prints the strings after the interpretation of each step, with the answers of queries")
      ->type_name("COMMAND")
      ->check(problemOfCommand)
      ->needs(tested);
  command
      ->add_flag("--log", options->printsLog,
                 "The program prints what the model's printf writes, and nothing else, on standard error: compare it")
      ->needs(tested);
  command->add_option("--kind", options->kinds, "Only cases of this kind. May be repeated")
      ->check(CLI::IsMember({"deterministic", "stochastic", "random", "environment"}))
      ->expected(1)
      ->type_name("KIND");
  command->add_option("--cases", options->folder, "Folder of the suite (default: the one that came with the program)")
      ->type_name("FOLDER");
  command->add_option("--timeout", options->seconds, "Longest time of a run in seconds (10)")
      ->check(numberFrom(0.1, 86'400.0))
      ->type_name("SECONDS");
  command->add_flag("--quiet", options->isQuiet, "Print only failures and the count");
  command->add_flag("--list", options->onlyLists, "Print name, kind and purpose of the cases; run none");
  command->callback([options, &status] { status = runSuite(*options); });
}

}  // namespace espalier::command
