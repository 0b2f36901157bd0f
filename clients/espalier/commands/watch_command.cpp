#include <CLI/CLI.hpp>
#include <chrono>
#include <csignal>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "clients/espalier/commands/commands.h"
#include "clients/espalier/messages.h"
#include "clients/espalier/model_loading.h"
#include "clients/espalier/output/outputs.h"
#include "engine/core/hash.h"
#include "server/remote/disk_files.h"
#include "server/remote/partial_file.h"

namespace espalier::command {
namespace {

constexpr auto kPollInterval = std::chrono::milliseconds(150);

volatile std::sig_atomic_t interruptions = 0;  // SIGINT and SIGTERM received so far

// the first signal ends the watch between two steps, the second ends the program at once
void interrupt(int signal) {
  interruptions = interruptions + 1;
  if (interruptions > 1) {
    server::removePartialFilesAtSignal(signal);
    std::raise(signal);
  }
}

/// Files of the disk, with the content that each had when it was last read.
class WatchedFiles final : public core::FileProvider {
 public:
  [[nodiscard]] std::optional<std::string> read(const std::string& name) override {
    std::optional<std::string> content = files_.read(name);
    hashes_[name] = hashOf(content);
    return content;
  }

  /// Whether the content of a file has changed since it was read, or a missing file exists now.
  [[nodiscard]] bool haveChanged() {
    for (const auto& [name, hash] : hashes_) {
      if (hashOf(files_.read(name)) != hash) {
        return true;
      }
    }
    return false;
  }

  void forget() { hashes_.clear(); }
  [[nodiscard]] std::size_t count() const { return hashes_.size(); }

 private:
  static std::optional<std::uint64_t> hashOf(const std::optional<std::string>& content) {
    if (!content) {
      return std::nullopt;
    }
    core::Hasher hasher;
    hasher.bytes(*content);
    return hasher.value();
  }

  server::DiskFileProvider files_;
  std::map<std::string, std::optional<std::uint64_t>> hashes_;  // nothing: there was no such file
};

struct WatchOptions {
  ModelOptions model;
  OutputOptions outputs;
};

// grows the model once and writes it; an error is printed and does not end the watch
void draw(const WatchOptions& options, WatchedFiles& files) {
  ModelOptions model = options.model;
  std::optional<LoadedModel> loaded = loadModel(model, files);
  if (!loaded) {
    return;
  }
  simulation::Simulation simulation(loaded->programs, loaded->plants, std::move(loaded->environment.process),
                                    std::move(loaded->simulationOptions));
  std::optional<core::SimulationError> failure = simulation.rewind();
  const std::optional<std::uint64_t> last =
      failure ? std::nullopt : server::lastStepOf(loaded->folder, model.steps, simulation);
  while (!failure && interruptions == 0 && !server::isOver(simulation, last)) {
    failure = simulation.step();
  }
  if (failure) {
    printError(formatSimulationError(*failure));
  } else if (interruptions == 0) {
    static_cast<void>(OutputWriter(options.outputs, model.isQuiet).write(simulation));
  }
}

int watch(const WatchOptions& options) {
  if (const int status = checkOutputs(options.outputs); status != kSuccess) {
    return status;
  }
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  WatchedFiles files;
  while (interruptions == 0) {
    files.forget();
    // watch the model itself, also when it does not exist yet
    static_cast<void>(files.read(options.model.model));
    draw(options, files);
    if (interruptions == 0 && !options.model.isQuiet) {
      printNote("watching " + std::to_string(files.count()) + (files.count() == 1 ? " file" : " files") + "; press Ctrl-C to end");
    }
    while (interruptions == 0 && !files.haveChanged()) {
      std::this_thread::sleep_for(kPollInterval);
    }
  }
  return kSuccess;
}

}  // namespace

void addWatch(CLI::App& program, int& status) {
  CLI::App* command = program.add_subcommand("watch", "Redraw a model whenever one of its files changes");
  command->footer(
      "The command watches every file of the model. It prints the errors of a file and tries again after the next "
      "change.\n"
      "A model that draws random numbers looks different each time; --seed prevents this. Ctrl-C ends the command.\n"
      "Examples:\n"
      "  espalier watch tree.l -o tree.png --seed 1\n"
      "  espalier watch lilac -o lilac.png -o lilac.glb");
  auto options = std::make_shared<WatchOptions>();
  addReadingOptions(*command, options->model, true);
  addRunningOptions(*command, options->model);
  addOutputOptions(*command, options->outputs, true);
  command->callback([options, &status] {
    options->outputs.picture.threads = options->model.threadCount();
    status = watch(*options);
  });
}

}  // namespace espalier::command
