#pragma once

#include <memory>
#include <string>

#include "clients/espalier/environment_loading.h"
#include "engine/simulation/trace.h"
#include "server/remote/trace_file.h"

namespace CLI {
class App;
}

namespace espalier::command {

/// The option --trace FILE of commands that make steps: records the dialogue with the environment.
class TraceOption {
 public:
  void addTo(CLI::App& command);

  /// Opens the file when one was asked for and puts the recorder before the environment. False: an error was written.
  [[nodiscard]] bool open(LoadedEnvironment& environment);
  /// The run begins.
  void begin(simulation::Simulation& simulation);
  /// A step is complete.
  void complete(const simulation::Simulation& simulation);
  /// Ends the file. False: it is not complete, an error was written.
  [[nodiscard]] bool close();

 private:
  std::string fileName_;                                 // empty: none
  std::unique_ptr<server::TraceFile> file_;              // null: none
  std::shared_ptr<simulation::TraceRecorder> recorder_;  // null: none
};

}  // namespace espalier::command
