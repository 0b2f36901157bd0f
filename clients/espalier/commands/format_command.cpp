#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <variant>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_files.h"
#include "clients/espalier/model_loading.h"
#include "engine/language/dialects/dialect.h"
#include "engine/language/format/formatter.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

struct FormatOptions {
  ModelOptions model;
  bool isInPlace = false;
  bool isCheck = false;
};

int format(FormatOptions& options) {
  auto found = findModelFiles(options.model.model);
  if (const std::string* problem = std::get_if<std::string>(&found)) {
    printError(*problem);
    return kFailure;
  }
  const ModelFiles& modelFiles = std::get<ModelFiles>(found);
  language::CompileInput input;
  input.modelFile = modelFiles.model;
  input.viewFile = options.model.view.empty() ? modelFiles.view : options.model.view;
  input.compatibility = options.model.mode();
  for (const std::string& define : options.model.defines) {
    input.defines.push_back(splitDefine(define));
  }
  server::DiskFileProvider files;
  if (const auto foreign = language::translateForeign(input, files)) {
    printError("'" + input.modelFile + "' is written as " + std::string(foreign->dialect->title) +
               ": format lays out cpfg models. `espalier convert` makes one of it");
    return kFailure;
  }
  const std::string original = files.read(input.modelFile).value_or(std::string());
  const language::FormatResult result = language::format(input, files);
  if (!result.isCompiled) {
    printDiagnostics(result.diagnostics.entries(), true);
    printError("'" + input.modelFile + "' was not formatted: correct the errors first");
    return kFailure;
  }
  if (result.untouchedItems > 0 && !options.model.isQuiet) {
    printNote(input.modelFile + ": " + std::to_string(result.untouchedItems) +
              (result.untouchedItems == 1 ? " item was" : " items were") + " left as written");
  }
  const bool hasChanged = result.text != original;
  if (options.isCheck) {
    std::printf("%s: %s\n", input.modelFile.c_str(), hasChanged ? "would be changed" : "is formatted");
    return hasChanged ? kFailure : kSuccess;
  }
  if (!options.isInPlace) {
    std::fwrite(result.text.data(), 1, result.text.size(), stdout);
    return kSuccess;
  }
  if (hasChanged) {
    if (const auto problem = server::writeFileAtomically(input.modelFile, result.text)) {
      printError(*problem);
      return kFailure;
    }
  }
  return kSuccess;
}

}  // namespace

void addFormat(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("format", "Lay out a model's text anew");
  command->footer(
      "Writes the model on standard output with blanks in the same places everywhere: around ':', '-->', '<', '>' and\n"
      "operators, none before commas, blocks indented. Comments, directives, macros, line breaks and the spelling of\n"
      "keywords stay; included files are not touched. The result means exactly the same: this is checked, and an item "
      "that\n"
      "would change is left as it is.\n"
      "Examples:\n"
      "  espalier format tree.l --in-place\n"
      "  espalier format tree.l --check     exit status 1 when the file would be changed");
  auto options = std::make_shared<FormatOptions>();
  CLI::Option* inPlace =
      command->add_flag("--in-place", options->isInPlace, "Write the file instead of standard output");
  command->add_flag("--check", options->isCheck, "Write nothing; only say whether the file would be changed")
      ->excludes(inPlace);
  command->add_option("model", options->model.model, "The L-system file (.l), or a folder that holds exactly one")
      ->type_name("MODEL")
      ->required();
  command->add_option("--view", options->model.view, "View file; without it the .v beside the model with the same name")
      ->type_name("FILE.v");
  command->add_option("--define", options->model.defines, "A macro for the model's preprocessor. May be repeated")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  command->add_flag("--quiet", options->model.isQuiet, "Only results and errors");
  command->callback([options, &status] { status = format(*options); });
}

}  // namespace espalier::command
