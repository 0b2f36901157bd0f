#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "engine/language/compiler.h"
#include "engine/language/dialects/dialect.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

struct ConvertOptions {
  std::string model;
  std::string dialect;
  std::string target;
  bool isQuiet = false;
};

int convert(const ConvertOptions& options) {
  server::DiskFileProvider files;
  language::CompileInput input;
  input.modelFile = options.model;
  input.dialect = options.dialect;
  const std::string file = language::splitEntry(options.model, files).file;
  const std::optional<std::string> text = files.read(file);
  if (!text) {
    printError("there is no file '" + file + "': give the name of a model, or FILE:ENTRY");
    return kFailure;
  }
  const std::optional<language::TranslatedModel> translated = language::translateForeign(input, files);
  if (!translated) {
    // the file is a cpfg model, or every command reads it as one
    const language::CompileResult compiled = language::compile(input, files);
    const bool isAnyModel = compiled.program != nullptr || language::hasLsystem(*text);
    if (!isAnyModel) {
      printDiagnostics(compiled.diagnostics.entries(), options.isQuiet);
      printError("'" + file + "' is a model of no dialect that is known, and nothing was converted: give --dialect");
      return kFailure;
    }
    if (!options.isQuiet) {
      printNote("'" + file + "' is already a cpfg model: it is written as it is");
    }
    std::fwrite(text->data(), 1, text->size(), stdout);
    return kSuccess;
  }
  printDiagnostics(translated->diagnostics.entries(), options.isQuiet);
  if (translated->diagnostics.hasErrors()) {
    return kFailure;
  }
  const language::CpfgModel& model = translated->model;
  if (!model.needs.empty()) {
    std::string needs;
    for (const std::string& need : model.needs) {
      needs += (needs.empty() ? "" : "; ") + need;
    }
    printError("'" + options.model + "' cannot be written for cpfg, which has no " + needs +
               ". Espalier runs the file without conversion");
    return kFailure;
  }
  if (!options.isQuiet) {
    for (const std::string& lost : model.lost) {
      printNote("missing in the text: " + lost);
    }
    for (const std::string& command : model.viewCommands) {
      printNote("for the view file: " + command);
    }
  }
  const std::string result = language::modelText(model, true).text();
  std::fwrite(result.data(), 1, result.size(), stdout);
  return kSuccess;
}

}  // namespace

void addConvert(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("convert", "Write a model of another dialect for cpfg");
  command->footer(
      "Prints the model as a cpfg text on standard output. The text needs no view file: each turn has its angle, and\n"
      "the axiom begins with the turtle's start. Standard error names every part that cpfg cannot express.\n"
      "Exit status 1 when cpfg cannot express the model at all.\n"
      "Examples:\n"
      "  espalier convert koch.lsv --to cpfg > koch.l\n"
      "  espalier convert fractint.l:Dragon --to cpfg");
  auto options = std::make_shared<ConvertOptions>();
  command->add_option("model", options->model, "The file, or FILE:ENTRY for one of several models in it")
      ->type_name("FILE")
      ->required();
  command->add_option("--to", options->target, "The language to write")
      ->check(CLI::IsMember({std::string(language::kCpfgDialect)}))
      ->required();
  const std::vector<std::string_view> names = language::dialectNames();
  command->add_option("--dialect", options->dialect, "Dialect of the file (default: recognised by its content)")
      ->check(CLI::IsMember(std::vector<std::string>(names.begin(), names.end())));
  command->add_flag("--quiet", options->isQuiet, "Print only the text and errors");
  command->callback([options, &status] { status = convert(*options); });
}

}  // namespace espalier::command
