#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "engine/derivation/plan_text.h"
#include "engine/language/format/disassembler.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

int disassemble(ModelOptions& options, bool showsPlan) {
  server::DiskFileProvider files;
  const std::shared_ptr<const language::Program> program = loadProgram(options, files);
  if (!program) {
    return kFailure;
  }
  const std::string text =
      showsPlan ? derivation::planText(*program) : language::disassemble(*program, language::DisassemblyPlaces::Shown);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return kSuccess;
}

}  // namespace

void addDisassemble(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("disassemble", "Print the compiled code of a model");
  command->footer(
      "Prints the blocks, the axiom and the productions of every L-system. Each production is followed by its source\n"
      "line, its condition and the parameters of its successor. `slot 0` is the first formal parameter, `= 2` a "
      "constant.\n"
      "Numbered lines are instructions of a stack machine. LoadSlot pushes a formal parameter, Constant pushes a "
      "number.\n"
      "Every other instruction takes its operands from the stack and pushes its result.\n"
      "With --plan: for each production the way in which a step applies it to long strings, and why.\n"
      "Example: espalier disassemble tree.l");
  auto options = std::make_shared<ModelOptions>();
  addReadingOptions(*command, *options, true);
  auto showsPlan = std::make_shared<bool>(false);
  command->add_flag("--plan", *showsPlan, "Say how steps apply each production, and why, instead of its code");
  command->callback([options, showsPlan, &status] { status = disassemble(*options, *showsPlan); });
}

}  // namespace espalier::command
