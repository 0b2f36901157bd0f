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

/// The option --trace FILE of commands that make steps. It records the queries and replies of the environment.
class TraceOption {
 public:
  void addTo(CLI::App& command);

  /// Opens the file when the option is given, and puts the recorder before the environment. False: an error was
  /// printed.
  [[nodiscard]] bool open(LoadedEnvironment& environment);
  /// The run begins.
  void begin(simulation::Simulation& simulation);
  /// A step is complete.
  void complete(const simulation::Simulation& simulation);
  /// Ends the file. False: the file is not complete, and an error was printed.
  [[nodiscard]] bool close();

 private:
  std::string fileName_;                                 // empty: none
  std::unique_ptr<server::TraceFile> file_;              // null: none
  std::shared_ptr<simulation::TraceRecorder> recorder_;  // null: none
};

}  // namespace espalier::command
