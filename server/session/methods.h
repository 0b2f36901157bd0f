#pragma once

#include <memory>

#include "protocol/envelope.h"
#include "protocol/messages.h"

namespace espalier::server {

class Session;
class SimulationRunner;

/// A request that a method answers exactly once, now or later. A notification needs no answer.
struct Request {
  Session& session;
  const protocol::MessageId& id;
  bool isNotification = false;
};

/// Carries out one message of a session that has said hello. Network thread.
void dispatch(Session& session, const protocol::Message& message);

// The handlers of protocol/methods.def:
//
//     void modelCheck(const Request&, protocol::ModelParams);                                        (needs Nothing)
//     void simulationStep(const Request&, std::shared_ptr<SimulationRunner>, protocol::StepParams);  (needs Simulation)
//
// They run on the network thread. Long work goes to a worker (request_work.h).
namespace methods {
#define ESPALIER_HANDLER_Nothing(HANDLER, PARAMS) void HANDLER(const Request& request, protocol::PARAMS params);
#define ESPALIER_HANDLER_Simulation(HANDLER, PARAMS) \
  void HANDLER(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::PARAMS params);
#define ESPALIER_SHARED_METHOD(NAME, PARAMS, HANDLER, NEEDS, ROLE, SUMMARY) ESPALIER_HANDLER_##NEEDS(HANDLER, PARAMS)
#define ESPALIER_SERVER_METHOD(NAME, PARAMS, HANDLER, NEEDS, ROLE, SUMMARY) ESPALIER_HANDLER_##NEEDS(HANDLER, PARAMS)
#define ESPALIER_SERVER_METHOD_OR_NOTIFICATION(NAME, PARAMS, HANDLER, NEEDS, ROLE, SUMMARY) \
  ESPALIER_HANDLER_##NEEDS(HANDLER, PARAMS)
#include "protocol/methods.def"
#undef ESPALIER_HANDLER_Nothing
#undef ESPALIER_HANDLER_Simulation
}  // namespace methods

}  // namespace espalier::server
