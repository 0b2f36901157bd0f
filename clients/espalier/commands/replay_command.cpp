#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "engine/simulation/trace.h"
#include "server/remote/trace_file.h"

namespace espalier::command {
namespace {

struct ReplayOptions {
  std::string trace;
  unsigned threads = 1;
  std::uint64_t eventBytes = server::maximumTraceEventBytes();
};

int replay(const ReplayOptions& options) {
  const auto source = server::TraceFileSource::open(options.trace);
  if (!source) {
    printError(source.error());
    return kFailure;
  }
  const auto outcome = simulation::replayTrace(**source, options.eventBytes, options.threads);
  if (!outcome) {
    printError("'" + options.trace + "': " + outcome.error());
    return kFailure;
  }
  const auto& result = *outcome;
  if (result.divergence) {
    printError("first divergence: " + result.divergence->message);
    return kFailure;
  }
  std::printf("%llu steps with %llu queries: the same as recorded\n", static_cast<unsigned long long>(result.steps),
              static_cast<unsigned long long>(result.queries));
  return kSuccess;
}

}  // namespace

void addReplay(CLI::App& program, int& status) {
  const auto options = std::make_shared<ReplayOptions>();
  CLI::App* command = program.add_subcommand("replay", "Repeat a recorded run without its environment, and compare");
  command->footer(
      "The trace holds the model, every query and every reply. The replay compares each query and each string with "
      "the\n"
      "recorded ones. It names the first difference: step, plant and module.\n"
      "Examples:\n"
      "  espalier derive tree.l --environment 'stdio:python3 light.py' --trace tree.trace\n"
      "  espalier replay tree.trace");
  command->add_option("TRACE", options->trace, "Trace file that --trace wrote")->required();
  command
      ->add_option(
          "--event-bytes", options->eventBytes,
          "Bytes that the questions and replies of one step, or the state at the start, may have in the trace;\n"
          "default: 256000000, or a quarter of the memory when that is less")
      ->type_name("N");
  command
      ->add_option("--threads", options->threads,
                   "Threads for the derivation; the result does not depend on their number")
      ->capture_default_str()
      ->check(CLI::Range(1U, 1024U));
  command->callback([options, &status] { status = replay(*options); });
}

}  // namespace espalier::command
