#pragma once

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

/// How environments in other processes are treated unless their entry says otherwise.
struct RemoteOptions {
  std::string policy = "fail";  // fail, keep or fallback:NAME
  double timeoutSeconds = 0.0;  // of a step; 0: the default
};

struct LoadedEnvironment {
  std::unique_ptr<turtle::EnvironmentProcess> process;
  simulation::EnvironmentOrigin origin;   // its name and the files it was read from, to make it again from a snapshot
  std::vector<std::string> processNames;  // of several processes in one; empty: one that answers every query
  /// Hears of failures that a policy passed over: says so on standard error, and what else is put here.
  std::shared_ptr<server::FailureSink> onFailure;
};

/// Makes the environment that a command line names: `tcp://HOST:PORT`, `unix:PATH` and `stdio:COMMAND` are other
/// processes, `*.json`
/// is a configuration of one process or several, `*.so` a plug-in, `*.e` a field file, anything else the name of a
/// built-in process with its defaults. Writes what is wrong, and warnings unless `isQuiet`, to standard error; nothing
/// on an error.
[[nodiscard]] std::optional<LoadedEnvironment> loadEnvironment(const std::string& name,
                                                               core::Compatibility compatibility, bool isQuiet,
                                                               core::FileProvider& files,
                                                               const RemoteOptions& remote = {});

/// Warns on standard error about communication modules of the model that no process of `environment` answers. Null:
/// there is no environment.
void warnAboutUnansweredQueries(const language::Program& program, const LoadedEnvironment* environment, bool isQuiet);

}  // namespace espalier::command
