#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iterator>
#include <new>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/installation/version_text.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/reference_switches.h"
#include "engine/core/check.h"
#include "engine/core/diagnostic.h"
#include "engine/core/simulation_error.h"
#include "server/remote/partial_file.h"

namespace {

struct Command {
  std::string_view name;
  void (*add)(CLI::App& program, int& status);
};

// in the order of the help text
constexpr auto kCommands = std::to_array<Command>({
    {"derive", espalier::command::addDerive},
    {"run", espalier::command::addRun},
    {"export", espalier::command::addExport},
    {"watch", espalier::command::addWatch},
    {"check", espalier::command::addCheck},
    {"explain", espalier::command::addExplain},
    {"format", espalier::command::addFormat},
    {"growth", espalier::command::addGrowth},
    {"convert", espalier::command::addConvert},
    {"disassemble", espalier::command::addDisassemble},
    {"evolve", espalier::command::addEvolve},
    {"forest", espalier::command::addForest},
    {"sweep", espalier::command::addSweep},
    {"infer", espalier::command::addInfer},
    {"language-server", espalier::command::addLanguageServer},
    {"field", espalier::command::addField},
    {"points", espalier::command::addPoints},
    {"traits", espalier::command::addTraits},
    {"replay", espalier::command::addReplay},
    {"conformance", espalier::command::addConformance},
    {"validate", espalier::command::addValidate},
    {"serve", espalier::command::addServe},
    {"environment", espalier::command::addEnvironment},
    {"connect", espalier::command::addConnect},
    {"status", espalier::command::addStatus},
    {"load", espalier::command::addLoad},
    {"token", espalier::command::addToken},
    {"backup", espalier::command::addBackup},
    {"restore", espalier::command::addRestore},
    {"reference", espalier::command::addReference},
    {"self-test", espalier::command::addSelfTest},
});

// names the commands of a command that was given without one, as of `connect ADDRESS`, and the one that was meant
void suggestPart(const CLI::App& command, int argumentCount, char** arguments) {
  const auto parts = command.get_subcommands([](const CLI::App*) { return true; });
  std::vector<std::string> names;
  for (const CLI::App* part : parts) {
    names.push_back(part->get_name());
  }
  std::size_t positionals = 0;
  for (const CLI::Option* option : command.get_options()) {
    positionals += option->get_positional() ? 1 : 0;
  }
  std::string given;
  for (int i = 2; i < argumentCount && given.empty(); ++i) {
    const std::string_view word = arguments[i];
    if (word.starts_with('-')) {
      // the value of an option is the next word
      const CLI::Option* const option = command.get_option_no_throw(std::string(word));
      i += option != nullptr && option->get_items_expected_max() > 0 ? 1 : 0;
    } else if (positionals-- == 0) {
      given = word;
    }
  }
  const std::vector<std::string_view> all(names.begin(), names.end());
  espalier::command::printError((given.empty() ? "give a command behind '" + command.get_name() + "'. "
                                               : "there is no command '" + command.get_name() + " … " + given + "'. ") +
                                espalier::core::suggestName(given, all));
}

// an error of the options, with the page that lists them
void printUsageError(const CLI::Error& error, const CLI::App& program) {
  std::string page = program.get_name();
  for (const CLI::App* command = &program; !command->get_subcommands().empty();) {
    command = command->get_subcommands().front();
    page += " " + command->get_name();
    // as ADDRESS in `connect ADDRESS get`
    for (const CLI::Option* option : command->get_options()) {
      page += option->get_positional() && !command->get_subcommands().empty() ? " " + option->get_name(true) : "";
    }
  }
  std::string problem = error.what();
  problem.erase(problem.find_last_not_of('.') + 1);
  espalier::command::printError(problem + "; `" + page + " --help` lists the options");
}

// the commands that read models as cpfg does
constexpr std::array<std::string_view, 6> kModelCommands{"derive", "run", "export", "watch", "check", "disassemble"};

// Reports the first switch of cpfg's command line. False: there is none.
bool reportsReferenceSwitch(const CLI::App& command, int argumentCount, char** arguments) {
  for (int i = 2; i < argumentCount && std::string_view(arguments[i]) != "--"; ++i) {
    const std::string word = arguments[i];
    const std::string advice = espalier::command::adviceForReferenceSwitch(word);
    if (!advice.empty() && command.get_option_no_throw(word) == nullptr) {
      espalier::command::printError(advice);
      return true;
    }
  }
  return false;
}

// names the option for a file that stands behind the model, as in cpfg's command line
void suggestCompanionOption(int argumentCount, char** arguments) {
  for (int i = 2; i < argumentCount; ++i) {
    const std::string_view before = arguments[i - 1];
    const std::string advice = espalier::command::adviceForCompanion(arguments[i]);
    if (!advice.empty() && !before.starts_with("--")) {
      std::fprintf(stderr, "%s\n", advice.c_str());
      return;
    }
  }
}

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
    // the option's name in other servers
    const bool isAddress =
        (given == "--port" || given == "--host") && std::ranges::find(names, "--listen") != names.end();
    const std::string_view nearest =
        isAddress ? "--listen HOST:PORT" : espalier::core::nearestName(given, {names.begin(), names.end()});
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
  espalier::server::removePartialFilesAtSignals();
  int status = kSuccess;
  const auto named = std::find_if(kCommands.begin(), kCommands.end(), [&](const Command& command) {
    return argumentCount > 1 && command.name == arguments[1];
  });

  // `espalier` and `espalier help` show what there is
  const std::string_view word = argumentCount > 1 ? arguments[1] : "help";
  const bool isHelp = word == "help";

  const auto isCommand = [](std::string_view name) {
    return std::any_of(kCommands.begin(), kCommands.end(),
                       [&](const Command& command) { return command.name == name; });
  };

  // name a mistyped command before its options are read
  const std::string_view asked = isHelp && argumentCount > 2 ? arguments[2] : word;
  if (!isCommand(asked) && asked != "help" && !asked.starts_with('-')) {
    std::error_code error;
    if (!isHelp && std::filesystem::exists(arguments[1], error)) {
      printError("'" + std::string(word) + "' is a file or folder, and a command stands before it: espalier run " +
                 std::string(word) + " -o plant.png");
      return kUsage;
    }
    std::vector<std::string_view> names;
    std::transform(kCommands.begin(), kCommands.end(), std::back_inserter(names),
                   [](const Command& command) { return command.name; });
    printError("there is no command '" + std::string(asked) + "'. " +
               espalier::core::suggestName(std::string(asked), names));
    return kUsage;
  }

  // making the options of all commands takes longer than deriving a small model
  for (auto command = kCommands.begin(); command != kCommands.end(); ++command) {
    if (named == kCommands.end() || command == named) {
      command->add(program, status);
    }
  }

  try {
    if (isHelp) {
      const CLI::App* const shown = isCommand(asked) ? program.get_subcommand(std::string(asked)) : &program;
      const std::string text = shown->help(shown == &program ? "" : program.get_name());
      std::fwrite(text.data(), 1, text.size(), argumentCount > 1 ? stdout : stderr);
      return argumentCount > 1 ? kSuccess : kUsage;
    }
    if (named != kCommands.end() && std::ranges::find(kModelCommands, named->name) != kModelCommands.end() &&
        reportsReferenceSwitch(*program.get_subcommand(std::string(named->name)), argumentCount, arguments)) {
      return kUsage;
    }
    program.parse(argumentCount, arguments);
  } catch (const CLI::Success& helpOrVersion) {
    return program.exit(helpOrVersion);
  } catch (const CLI::ExtrasError&) {
    // its own text has them in the reverse order
    std::vector<std::string> extras = program.remaining(true);
    std::ranges::reverse(extras);
    printUsageError(CLI::ExtrasError(extras), program);
    suggestOption(program, argumentCount, arguments);
    suggestCompanionOption(argumentCount, arguments);
    return kUsage;
  } catch (const CLI::ParseError& error) {
    const CLI::App* const given = named == kCommands.end() ? nullptr : program.get_subcommand(std::string(named->name));
    const bool lacksPart = std::string_view(error.what()).find("subcommand") != std::string_view::npos;
    if (lacksPart && given != nullptr && given->get_subcommands().empty()) {
      suggestPart(*given, argumentCount, arguments);
      return kUsage;
    }
    printUsageError(error, program);
    return kUsage;
  } catch (const espalier::core::InternalError& error) {
    printError(std::string("this is a bug of Espalier, please report it: ") + error.what());
    return kFailure;
  } catch (const std::bad_alloc&) {
    printError("out of memory: run fewer steps, or use a machine with more memory");
    return kFailure;
  } catch (const espalier::core::SimulationFailure& failure) {
    // outside of a simulation: a library that cannot be loaded
    printError(failure.what());
    return kFailure;
  } catch (const std::exception& error) {
    printError(std::string("this is a bug of Espalier, please report it: ") + error.what());
    return kFailure;
  }

  // a full disk or a closed pipe is a failure
  if (std::fflush(stdout) != 0) {
    const std::string reason = std::generic_category().message(errno);
    printError("the results could not be written to standard output: " + reason +
               ". Write them to a place with room, as `> FILE`");
    return kFailure;
  }
  return status;
}
