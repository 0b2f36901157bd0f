#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/core/streams.h"
#include "engine/language/program.h"
#include "engine/simulation/simulation.h"
#include "engine/turtle/environment_process.h"
#include "server/remote/failure_policy.h"

namespace espalier::command {

/// The source of an environment's name. All but the command line may come from strangers, whose programs are not
/// started and whose addresses are not dialled.
enum class EnvironmentSource : std::uint8_t { CommandLine, Folder, Snapshot };

/// Settings of environments in other processes, and of reading files of environments. The entry of an environment may
/// override policy, time and threads.
struct RemoteOptions {
  std::string policy = "fail";        // fail, keep or fallback:NAME
  double timeoutSeconds = 0.0;        // of a step; 0: the default
  bool allowsFolderPrograms = false;  // a file that nobody named may start programs and dial addresses
  bool isStrict = false;              // a warning about a file is an error
  unsigned threads = 1;               // of a built-in process that has the key `threads`
  bool keepsState = false;            // a snapshot is wanted, also when the environment dies
  EnvironmentSource source = EnvironmentSource::CommandLine;
};

struct LoadedEnvironment {
  std::unique_ptr<turtle::EnvironmentProcess> process;
  simulation::EnvironmentOrigin origin;   // its name and its files, to make it again from a snapshot
  std::vector<std::string> processNames;  // of a set of processes; empty: a single process answers every query
  /// Receives the failures that a policy tolerates. It prints them on standard error.
  std::shared_ptr<server::FailureSink> onFailure;
};

/// Whether a name is the file of a plug-in: `libceiling.so`, `./libceiling.so.1`.
[[nodiscard]] bool isPluginFile(const std::string& name);

/// A sentence when a name is a script, or a command that starts one, without `stdio:` before it: `ceiling.py`,
/// `python3 ceiling.py`. Else an empty text.
[[nodiscard]] std::string problemOfScriptName(const std::string& name);

/// Prints such a failure unless `isQuiet`.
[[nodiscard]] server::FailureSink failureNotes(bool isQuiet);

/// Makes the environment that a command line names: `tcp://HOST:PORT`, `unix:PATH` and `stdio:COMMAND` are other
/// processes, `*.json` is a configuration of one process or several, `*.so` a plug-in, `*.e` a published environment
/// file. Any other text is the name of a built-in process with its defaults. Prints errors, and warnings unless
/// `isQuiet`, on standard error. Returns nothing after an error.
[[nodiscard]] std::optional<LoadedEnvironment> loadEnvironment(const std::string& name,
                                                               core::Compatibility compatibility, bool isQuiet,
                                                               core::FileProvider& files,
                                                               const RemoteOptions& remote = {});

/// Warns on standard error about communication modules of the model that no process of `environment` answers. Null:
/// there is no environment. False: there is a warning, and `isStrict` forbids it.
[[nodiscard]] bool warnAboutUnansweredQueries(const language::Program& program, const LoadedEnvironment* environment,
                                              bool isQuiet, bool isStrict);

/// Warns when a model has no communication module that asks its environment. False: `isStrict` forbids it.
[[nodiscard]] bool warnAboutUnaskedEnvironment(const language::Program& program, bool isQuiet, bool isStrict);

}  // namespace espalier::command
