#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "engine/language/dialects/dialect.h"
#include "engine/language/format/formatter.h"
#include "server/remote/disk_files.h"
#include "server/remote/models/model_files.h"

namespace espalier::command {
namespace {

struct FormatOptions {
  ModelOptions model;
  bool isInPlace = false;
  bool isCheck = false;
};

int format(FormatOptions& options) {
  const server::FoundModel found = server::findModelFiles(options.model.model);
  if (!found) {
    printError(found.error());
    return kFailure;
  }
  const server::ModelFiles& modelFiles = *found;
  language::CompileInput input;
  input.modelFile = modelFiles.model;
  input.viewFile = options.model.view.empty() ? modelFiles.view : options.model.view;
  input.compatibility = options.model.mode();
  for (const std::string& define : options.model.defines) {
    input.defines.push_back(splitDefine(define));
  }
  server::DiskFileProvider files;
  if (const auto foreign = language::translateForeign(input, files)) {
    // a file without text, or of a program that no dialect reads
    if (foreign->dialect == nullptr) {
      printDiagnostics(foreign->diagnostics.entries(), true);
      return kFailure;
    }
    printError("'" + input.modelFile + "' is written as " + std::string(foreign->dialect->title) +
               ": `espalier format` lays out cpfg models only. `espalier convert` translates the file to cpfg");
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
  CLI::App* command = program.add_subcommand("format", "Lay out the text of a model");
  command->footer(
      "Prints the model on standard output with uniform blanks: around ':', '-->', '<', '>' and operators, none "
      "before\n"
      "commas, blocks indented. Comments, directives, macros, line breaks and the spelling of keywords stay. Included\n"
      "files stay unchanged. The meaning stays the same: the command compiles both texts and compares them. It keeps "
      "an\n"
      "item unchanged when the new layout would change its meaning.\n"
      "Examples:\n"
      "  espalier format tree.l --in-place\n"
      "  espalier format tree.l --check     exit status 1 when the layout differs");
  auto options = std::make_shared<FormatOptions>();
  CLI::Option* inPlace = command->add_flag("--in-place", options->isInPlace, "Write the result into the file");
  command->add_flag("--check", options->isCheck, "Write nothing; report whether the layout would change")
      ->excludes(inPlace);
  command->add_option("model", options->model.model, "The L-system file (.l), or a folder that holds exactly one")
      ->type_name("MODEL")
      ->required();
  command
      ->add_option("--view", options->model.view,
                   "View file (default: the .v file beside the model with the same name)")
      ->type_name("FILE.v");
  command->add_option("--define", options->model.defines, "A macro for the model's preprocessor. May be repeated")
      ->type_name("NAME=VALUE")
      ->allow_extra_args(false);
  command->add_flag("--quiet", options->model.isQuiet, "Print only results and errors");
  command->callback([options, &status] { status = format(*options); });
}

}  // namespace espalier::command
