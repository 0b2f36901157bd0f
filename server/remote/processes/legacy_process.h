#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "engine/core/diagnostic.h"
#include "engine/core/streams.h"
#include "environment/base/process_entry.h"

namespace espalier::server {

struct LegacyProcessOptions {
  std::string executable;  // program and arguments, instead of those of the `.e` file; empty: those
  std::chrono::milliseconds stepTimeout{60'000};
};

/// A published environment program as an environment. It is started with pipes on its standard input and output, and
/// speaks as its `.e` file says (Mech 1997, "Modeling and Simulation of the Interaction of Plants with the Environment
/// using L-systems and their Extensions", appendix on the communication library). The program runs in the folder of
/// `fieldFile` and is started with the first queries. Every number is exchanged as text, with the formats of the file.
/// Geometry of following modules is not sent. A file that names another communication type than pipes is handed to the
/// program as a copy that names pipes.
///
/// A program that ends early, is silent beyond `stepTimeout` or answers wrongly fails the step. The next step starts it
/// anew. A program with memory has then lost its state, and the error says so. The state of such a program cannot be
/// saved and is not in snapshots.
///
/// Returns the process, or the errors in the file; warnings are appended.
[[nodiscard]] environment::ProcessOrErrors makeLegacyProcess(const std::string& fieldFile, core::FileProvider& files,
                                                             const LegacyProcessOptions& options,
                                                             std::vector<core::Diagnostic>& warnings);

/// Whether a path that begins in `folder` leads to an executable file.
[[nodiscard]] bool isProgramIn(const std::string& program, const std::string& folder);

/// The executable file of a command's program: a path from `folder`, or a name on the PATH. Empty: there is none.
[[nodiscard]] std::string findExecutable(const std::string& program, const std::string& folder);

}  // namespace espalier::server
