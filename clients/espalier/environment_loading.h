#pragma once

#include <memory>
#include <string>

#include "engine/core/identifiers.h"
#include "engine/core/streams.h"
#include "engine/turtle/environment_process.h"

namespace espalier::command {

/// Makes the environment that a command line names: `tcp://HOST:PORT` and `stdio:COMMAND` are other processes, `*.json` is
/// a configuration of one process or several, `*.e` a field file, anything else the name of a built-in process with its
/// defaults. Writes what is wrong, and warnings unless `isQuiet`, to standard error; null on an error.
[[nodiscard]] std::unique_ptr<turtle::EnvironmentProcess> loadEnvironment(const std::string& name,
                                                                          core::Compatibility compatibility,
                                                                          bool isQuiet, core::FileProvider& files);

}  // namespace espalier::command
