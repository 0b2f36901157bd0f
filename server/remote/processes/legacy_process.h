#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "environment/base/process_entry.h"

namespace espalier::server {

struct LegacyProcessOptions {
  std::string executable;  // program and arguments, instead of the field file's; empty: those
  std::chrono::milliseconds stepTimeout{60'000};
};

/// One of the field's existing environment programs as an environment: started with the pipes of its standard input
/// and output and spoken to as its `.e` file says (Mech 1997, "Modeling and Simulation of the Interaction of Plants
/// with the Environment using L-systems and their Extensions", appendix on the field's communication library). The
/// program runs in the folder of `fieldFile` and is started with the first queries; every number is
/// exchanged as text, with the formats of the file. Geometry of following modules is not sent.
///
/// A program that ends early, keeps silent beyond `stepTimeout` or answers with what is no answer fails the step; the
/// next step starts it anew, which for a program with a memory is not the state it had: the error says so. Such a
/// program cannot be saved; its state is not in snapshots.
///
/// Returns the process, or what is wrong with the file; warnings are appended.
[[nodiscard]] environment::ProcessOrErrors makeLegacyProcess(const std::string& fieldFile, core::FileProvider& files,
                                                             const LegacyProcessOptions& options,
                                                             std::vector<core::Diagnostic>& warnings);

/// Whether the program of a command can be started: a path that leads to an executable file from `folder`, or a name on
/// the PATH.
[[nodiscard]] bool isExecutableThere(const std::string& program, const std::string& folder);

}  // namespace espalier::server
