#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/simulation/simulation.h"
#include "engine/turtle/environment_process.h"
#include "protocol/errors.h"
#include "protocol/framing.h"
#include "protocol/messages.h"
#include "server/remote/environment_link.h"
#include "server/remote/failure_policy.h"
#include "server/remote/remote_permissions.h"
#include "server/running/simulation_trace.h"

namespace espalier::server {

class OfferedEnvironments;
struct Metrics;

/// The services of the server for a simulation and its environment.
struct EnvironmentServices {
  OfferedEnvironments* offered = nullptr;
  const RemotePermissions* permissions = nullptr;                // outlives the simulations; null: nothing is permitted
  std::function<void(const std::function<void()>&)> runWaiting;  // lets another worker compute
  std::chrono::milliseconds connectTimeout{5'000};
  std::chrono::milliseconds stepTimeout{60'000};
  protocol::FrameLimits frames;  // of what environments that are dialled or spawned send
  std::string galleryFolder;
  Metrics* metrics = nullptr;  // null: nothing is counted
  TraceFolder traces;
  std::optional<protocol::BoundsRecord> bounds;  // told to environments in other processes
  FailureSink onFailure;                         // called when an environment with a policy has failed
  unsigned threads = 1;                          // of one step
};

struct BuiltEnvironment {
  std::unique_ptr<turtle::EnvironmentProcess> process;  // null: none
  std::vector<std::shared_ptr<EnvironmentLink>> links;  // to other processes, for interrupting
  std::vector<std::string> names;                       // of the entries, for people: honda, offered:mylight
  std::vector<std::string> processNames;                // by which queries address them, as many
  simulation::EnvironmentOrigin origin;                 // for snapshots: how a command line makes it again
  std::vector<core::Diagnostic> warnings;               // of environment files
};

/// Makes the environment of a simulation from the `environment` array of simulation.create. `isAbsenceTolerated`:
/// entries in other processes may be away (simulations loaded from disk). Besides the built-in processes there are the
/// types `offered` {name}, `tcp` {address}, `stdio` {name} or {command}, `gallery` {model}: the specification (`.e`) of
/// a gallery folder, and `field` {main, files}: a specification with the files that it names, as texts. An entry in
/// another process may have a `policy`: fail (the default), keep, or fallback:NAME of a built-in. Every way to a
/// simulation comes through here, so it is the one place that asks `services.permissions`: an entry that names a
/// command or an address without permission is error 1003, and no entry has been reached then.
[[nodiscard]] protocol::Expected<BuiltEnvironment> buildEnvironment(const std::string& environmentJson,
                                                                    core::Compatibility compatibility,
                                                                    bool isAbsenceTolerated,
                                                                    const EnvironmentServices& services);

/// The `environment` array of a simulation as peers may read it: processes of the server whole, those in other
/// processes by type and name alone, because addresses, commands and what they are sent may be secret.
[[nodiscard]] std::string readableEnvironment(const std::string& environmentJson);

}  // namespace espalier::server
