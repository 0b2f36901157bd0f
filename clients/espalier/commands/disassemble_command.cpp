#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "engine/language/format/disassembler.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

int disassemble(ModelOptions& options) {
  server::DiskFileProvider files;
  const std::shared_ptr<const language::Program> program = loadProgram(options, files);
  if (!program) {
    return kFailure;
  }
  const std::string text = language::disassemble(*program, language::DisassemblyPlaces::Shown);
  std::fwrite(text.data(), 1, text.size(), stdout);
  return kSuccess;
}

}  // namespace

void addDisassemble(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("disassemble", "Print the code that a model is compiled to");
  command->footer(
      "For every L-system its blocks, axiom and productions; under each production the place and the line it was "
      "written\n"
      "on, then its condition and the parameters it makes. `slot 0` is the first formal parameter, `= 2` a constant;\n"
      "numbered lines are instructions of a stack machine: LoadSlot pushes a formal parameter, Constant a number, the\n"
      "others take their operands from the stack and push what they make.\n"
      "Example: espalier disassemble tree.l");
  auto options = std::make_shared<ModelOptions>();
  addReadingOptions(*command, *options, true);
  command->callback([options, &status] { status = disassemble(*options); });
}

}  // namespace espalier::command
