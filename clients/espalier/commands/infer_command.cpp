#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/number_option.h"
#include "engine/language/compiler.h"
#include "engine/language/inference/d0l_inference.h"
#include "engine/language/inference/inferred_model.h"
#include "engine/language/inference/step_strings.h"
#include "engine/simulation/simulation.h"
#include "server/remote/disk_files.h"

namespace espalier::command {
namespace {

using language::Inference;
using language::InferenceOutcome;
using language::StepStrings;

struct InferOptions {
  std::string file;
  std::string constants;
  double seconds = 10.0;
  bool mayErase = true;
  bool isQuiet = false;
};

// whether a model derives the strings that it was inferred from, step by step: the proof of the model
bool derivesTheStrings(const std::string& model, const StepStrings& steps) {
  core::MemoryFileProvider files;
  language::CompileInput input;
  input.modelFile = "inferred.l";
  files.add(input.modelFile, model);
  const language::CompileResult compiled = language::compile(input, files);
  if (!compiled.program) {
    return false;
  }
  simulation::Simulation simulation(compiled.program, {turtle::PlantPlacement{}}, nullptr, {});
  if (simulation.rewind()) {
    return false;
  }
  for (std::size_t step = 0; step < steps.strings.size(); ++step) {
    if ((step > 0 && simulation.step()) || simulation.stringText() != steps.text(steps.strings[step])) {
      return false;
    }
  }
  return true;
}

std::optional<StepStrings> readSteps(const InferOptions& options) {
  server::DiskFileProvider files;
  const std::optional<std::string> text = files.read(options.file);
  if (!text) {
    printError("the file '" + options.file + "' cannot be read");
    return std::nullopt;
  }
  core::DiagnosticList diagnostics;
  StepStrings steps = language::readStepStrings(options.file, *text, diagnostics);
  printDiagnostics(diagnostics.entries(), options.isQuiet);
  return diagnostics.hasErrors() ? std::nullopt : std::optional(std::move(steps));
}

std::string kindName(bool isBracketed) {
  return isBracketed ? "bracketed D0L-system" : "D0L-system";
}

// the result of the search, as a sentence for the first line of the model
std::string verdict(const Inference& found, const std::string& kind, std::size_t stringCount) {
  const std::string strings = std::to_string(stringCount) + " strings";
  switch (found.outcome) {
    case InferenceOutcome::One:
      return "the only " + kind + " that makes these " + strings;
    case InferenceOutcome::Several:
      return (found.hasAll ? "one of " : "one of at least ") + std::to_string(found.systems.size()) + " " + kind +
             "s that make these " + strings;
    case InferenceOutcome::Undecided:
      return "a " + kind + " that makes these " + strings + "; whether it is the only one is undecided";
    case InferenceOutcome::None:
      break;
  }
  return "no " + kind + " makes these " + strings;
}

int infer(const InferOptions& options) {
  const std::optional<StepStrings> steps = readSteps(options);
  if (!steps) {
    return kFailure;
  }
  language::InferenceOptions search;
  search.mayErase = options.mayErase;
  bool hasBrackets = false;
  for (std::size_t symbol = 0; symbol < steps->names.size(); ++symbol) {
    const std::string& name = steps->names[symbol];
    hasBrackets = hasBrackets || name == "[" || name == "]";
    if (options.constants.find(name) != std::string::npos) {
      search.constants.push_back(static_cast<std::uint16_t>(symbol));
    }
  }
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.seconds);
  search.mayContinue = [end] { return std::chrono::steady_clock::now() < end; };

  // first read brackets as branches, then as ordinary symbols
  search.isBracketed = hasBrackets;
  Inference found = language::inferD0l(*steps, search);
  if (hasBrackets && found.outcome == InferenceOutcome::None) {
    printNote("no bracketed D0L-system makes these strings; trying again with brackets as ordinary symbols");
    search.isBracketed = false;
    Inference plain = language::inferD0l(*steps, search);
    if (plain.outcome != InferenceOutcome::None) {
      found = std::move(plain);
    } else {
      found.firstMisfit = std::max(found.firstMisfit, plain.firstMisfit);
    }
  }
  const std::string kind = kindName(search.isBracketed && hasBrackets);

  if (found.systems.empty()) {
    if (found.outcome == InferenceOutcome::None) {
      printError("no D0L-system makes these strings: the string of step " + std::to_string(found.firstMisfit) +
                 " does not follow from those before it. Look there for a misprint, or for a context, a condition or "
                 "chance in the original model");
    } else {
      printError("undecided after " + std::to_string(options.seconds).substr(0, 4) +
                 " s: give more time with --seconds, more steps, or the symbols that never change with --constants");
    }
    return kFailure;
  }

  const std::string sentence = verdict(found, kind, steps->strings.size());
  const std::string model = language::inferredModelText(*steps, found.systems.front(), sentence);
  const bool isModel = derivesTheStrings(model, *steps);
  if (!options.isQuiet) {
    printNote(sentence + (found.outcome == InferenceOutcome::Several ? ". They differ in" : ""));
    if (found.outcome == InferenceOutcome::Several) {
      std::fputs(language::inferredDifferences(*steps, found.systems).c_str(), stderr);
      printNote("More steps, or --constants, can decide between them.");
    }
    if (!isModel) {
      printNote("Some symbols are not symbols of the cpfg language, so only the productions are printed.");
    }
  }
  std::fputs((isModel ? model : language::inferredProductions(*steps, found.systems.front())).c_str(), stdout);
  return kSuccess;
}

}  // namespace

void addInfer(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("infer", "Find the productions from the strings of successive steps");
  command->footer(
      "STEPS holds one string per line, with or without step numbers, as `espalier derive MODEL.l --every` prints "
      "them.\n"
      "Prints a model that derives these strings. Standard error says whether it is the only such D0L-system, one of\n"
      "several (and how they differ), or whether the time was too short to decide. With brackets, every successor is\n"
      "balanced. Exit status 1 when no D0L-system derives the strings, or none was found in time.\n"
      "Example: espalier infer steps.txt > model.l");
  auto options = std::make_shared<InferOptions>();
  command->add_option("STEPS", options->file, "Text file of strings, the axiom first")->required();
  command->add_option("--constants", options->constants, "Symbols that never change, such as '+-F'");
  addPositiveNumber(*command, "--seconds", "Time for the search, in seconds (10)", "seconds",
                    [options](double seconds) { options->seconds = seconds; });
  command->add_flag_callback(
      "--no-erasing", [options] { options->mayErase = false; }, "No production has an empty successor");
  command->add_flag("--quiet", options->isQuiet, "Print only the model");
  command->callback([options, &status] { status = infer(*options); });
}

}  // namespace espalier::command
