#pragma once

#include <memory>

#include "protocol/envelope.h"
#include "protocol/messages.h"
#include "server/running/simulation_runner.h"

namespace espalier::server {

class Session;

// What the simulation.* methods do on a worker. The commands answer the request `id` of the session exactly once.

using SessionPointer = std::shared_ptr<Session>;

/// Compiles, builds, saves and answers. On a worker.
void createSimulation(Session& session, const protocol::MessageId& id, protocol::CreateParams params,
                      Interruption& interruption);

[[nodiscard]] std::shared_ptr<Command> makeStepCommand(SessionPointer session, const protocol::MessageId& id,
                                                       protocol::StepParams params);
/// Ends what steps now, between two steps; it is answered as truncated.
[[nodiscard]] std::shared_ptr<Command> makePauseCommand(SessionPointer session, const protocol::MessageId& id,
                                                        protocol::NameParams params);
[[nodiscard]] std::shared_ptr<Command> makeSetCommand(SessionPointer session, const protocol::MessageId& id,
                                                      protocol::SetParams params);
[[nodiscard]] std::shared_ptr<Command> makeEditCommand(SessionPointer session, const protocol::MessageId& id,
                                                       protocol::EditParams params);
/// A second simulation in the state of this one.
[[nodiscard]] std::shared_ptr<Command> makeForkCommand(SessionPointer session, const protocol::MessageId& id,
                                                       protocol::ForkParams params);
[[nodiscard]] std::shared_ptr<Command> makeGetCommand(SessionPointer session, const protocol::MessageId& id,
                                                      protocol::GetParams params);
[[nodiscard]] std::shared_ptr<Command> makeResetCommand(SessionPointer session, const protocol::MessageId& id,
                                                        protocol::ResetParams params);
[[nodiscard]] std::shared_ptr<Command> makeSaveCommand(SessionPointer session, const protocol::MessageId& id,
                                                       protocol::SaveParams params);
[[nodiscard]] std::shared_ptr<Command> makeRestoreCommand(SessionPointer session, const protocol::MessageId& id,
                                                          protocol::RestoreParams params);
/// Answers with the stream's name, then sends the first frame.
[[nodiscard]] std::shared_ptr<Command> makeTraceCommand(SessionPointer session, const protocol::MessageId& id,
                                                        protocol::TraceParams params);
[[nodiscard]] std::shared_ptr<Command> makeStreamOpenCommand(SessionPointer session, const protocol::MessageId& id,
                                                             std::shared_ptr<Stream> stream);
/// Gives up what runs, ends the streams, removes it from disk, answers.
void deleteSimulation(Session& session, const protocol::MessageId& id, const std::shared_ptr<SimulationRunner>& runner);

}  // namespace espalier::server
