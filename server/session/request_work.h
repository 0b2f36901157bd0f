#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "protocol/errors.h"
#include "server/running/simulation_runner.h"
#include "server/session/methods.h"

namespace espalier::server {

class Interruption;

/// The simulation's runner. Null after an error was answered: there is no such simulation, or it is damaged.
[[nodiscard]] std::shared_ptr<SimulationRunner> findRunner(const Request& request, const std::string& simulation);

/// Runs `work` on a worker, within the memory of the session's account. An exception becomes the answer. The work ends
/// when the request is cancelled, the connection is lost, or the call takes longer than callSeconds: pollWork() throws
/// then, and `interruption`, when given, says so too.
void runOnWorker(const Request& request, std::function<void(const Request&)> work,
                 std::shared_ptr<Interruption> interruption = nullptr);

/// The same for a list of what the server has. An account gets it also when it may take and compute no more: to see
/// what it can delete.
void listOnWorker(const Request& request, std::function<void(const Request&)> work);

/// A command of one turn. Its result, as JSON, or its error answers the request.
using TurnWork = std::function<protocol::Expected<std::string>(SimulationRunner&)>;
[[nodiscard]] std::shared_ptr<Command> makeCommand(const Request& request, TurnWork work);

/// Has the work done in the simulation's next turn, and answers the request. For what costs little, and for saving.
void doInTurn(const Request& request, std::shared_ptr<SimulationRunner> runner, TurnWork work);

/// The same, unless the account of the caller or that of the simulation may compute no more. So a caller cannot compute
/// at the expense of another.
void computeInTurn(const Request& request, std::shared_ptr<SimulationRunner> runner, TurnWork work);

/// The reason for that, or nothing.
[[nodiscard]] std::optional<protocol::Error> cpuProblemOf(Session& session, const SimulationRunner& runner);

}  // namespace espalier::server
