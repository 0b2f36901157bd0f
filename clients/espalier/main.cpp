#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "engine/core/check.h"
#include "engine/core/diagnostic.h"

int main(int argumentCount, char** arguments) {
  using namespace espalier::command;
  CLI::App program{
      "Espalier derives L-systems (the cpfg dialect) and grows plants in an environment.\n"
      "Results go to standard output, everything else to standard error.\n"
      "Exit status: 0 success, 1 the command failed, 2 wrong command line.",
      "espalier"};
  program.require_subcommand(1);
  program.set_version_flag("--version", "espalier " ESPALIER_VERSION);
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
  addInfer(program, status);
  addLanguageServer(program, status);
  addField(program, status);
  addReplay(program, status);
  addConformance(program, status);
  addServe(program, status);
  addEnvironment(program, status);
  addConnect(program, status);
  addStatus(program, status);
  addLoad(program, status);
  addToken(program, status);

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
