#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/installation/version_text.h"
#include "clients/espalier/messages.h"
#include "engine/core/check.h"
#include "engine/core/diagnostic.h"

namespace {

// names the option that was probably meant, of the command that was given
void suggestOption(const CLI::App& program, int argumentCount, char** arguments) {
  const CLI::App* command = &program;
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
  }
  std::vector<std::string> names;
  for (const CLI::Option* option : command->get_options()) {
    for (const std::string& name : option->get_lnames()) {
      names.push_back("--" + name);
    }
  }
  for (int i = 1; i < argumentCount; ++i) {
    const std::string given = std::string(arguments[i]).substr(0, std::string(arguments[i]).find('='));
    if (!given.starts_with("--") || std::find(names.begin(), names.end(), given) != names.end()) {
      continue;
    }
    const std::string_view nearest = espalier::core::nearestName(given, {names.begin(), names.end()});
    if (!nearest.empty()) {
      std::fprintf(stderr, "Did you mean %s?\n", std::string(nearest).c_str());
    }
    return;
  }
}

}  // namespace

int main(int argumentCount, char** arguments) {
  using namespace espalier::command;
  CLI::App program{
      "Espalier derives L-systems (the cpfg dialect) and grows plants in an environment.\n"
      "Results go to standard output, everything else to standard error.\n"
      "Exit status: 0 success, 1 the command failed, 2 wrong command line.",
      "espalier"};
  program.require_subcommand(1);
  const auto isVerbose = [&] {
    return std::any_of(arguments, arguments + argumentCount,
                       [](const char* word) { return std::string_view(word) == "--verbose"; });
  };
  program.set_version_flag("--version", [&] { return isVerbose() ? verboseVersionText() : versionLine(); });
  // read by --version, which ends the program before other options are
  bool isRead = false;
  program.add_flag("--verbose", isRead, "With --version: compiler, system, processor and folders, for reports");
  program.footer("`espalier COMMAND --help` explains a command. Start with: espalier derive MODEL.l --every");

  // a file that reaches the size limit is an error of that file and does not end the program
  std::signal(SIGXFSZ, SIG_IGN);
  int status = kSuccess;
  addDerive(program, status);
  addRun(program, status);
  addExport(program, status);
  addWatch(program, status);
  addCheck(program, status);
  addExplain(program, status);
  addFormat(program, status);
  addGrowth(program, status);
  addConvert(program, status);
  addDisassemble(program, status);
  addEvolve(program, status);
  addForest(program, status);
  addSweep(program, status);
  addInfer(program, status);
  addLanguageServer(program, status);
  addField(program, status);
  addTraits(program, status);
  addReplay(program, status);
  addConformance(program, status);
  addValidate(program, status);
  addServe(program, status);
  addEnvironment(program, status);
  addConnect(program, status);
  addStatus(program, status);
  addLoad(program, status);
  addToken(program, status);
  addBackup(program, status);
  addRestore(program, status);
  addSelfTest(program, status);

  // name a mistyped command before its options are read
  if (argumentCount > 1 && arguments[1][0] != '-') {
    std::vector<std::string> names;
    for (const CLI::App* command : program.get_subcommands({})) {
      names.push_back(command->get_name());
    }
    if (std::find(names.begin(), names.end(), arguments[1]) == names.end()) {
      printError(std::string("there is no command '") + arguments[1] + "'. " +
                 espalier::core::suggestName(arguments[1], {names.begin(), names.end()}));
      return kUsage;
    }
  }

  try {
    program.parse(argumentCount, arguments);
  } catch (const CLI::Success& helpOrVersion) {
    return program.exit(helpOrVersion);
  } catch (const CLI::ExtrasError& error) {
    program.exit(error);
    suggestOption(program, argumentCount, arguments);
    return kUsage;
  } catch (const CLI::ParseError& error) {
    program.exit(error);
    return kUsage;
  } catch (const espalier::core::InternalError& error) {
    printError(std::string("this is a bug of Espalier, please report it: ") + error.what());
    return kFailure;
  } catch (const std::bad_alloc&) {
    printError("out of memory: run fewer steps, or use a machine with more memory");
    return kFailure;
  } catch (const std::exception& error) {
    printError(std::string("this is a bug of Espalier, please report it: ") + error.what());
    return kFailure;
  }

  // a full disk or a closed pipe is a failure
  if (std::fflush(stdout) != 0) {
    printError("the results could not be written to standard output");
    return kFailure;
  }
  return status;
}
