#include "protocol/base64.h"
#include "protocol/codec.h"
#include "server/running/simulation_trace.h"
#include "server/server_core.h"
#include "server/session/request_work.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

std::string stateAfter(SimulationRunner& runner) {
  protocol::JsonWriter result;
  result.beginObject().key("step").integer(runner.hosted().simulation().completedSteps());
  result.key("seed").integer(runner.hosted().record().seed);
  result.key("finished").boolean(runner.hosted().simulation().isFinished());
  return result.endObject().take();
}

/// The answer to a change between steps, and a frame of it for the viewers.
protocol::Expected<std::string> changed(SimulationRunner& runner, std::optional<protocol::Error> error) {
  if (error) {
    return tl::unexpected(std::move(*error));
  }
  runner.setLastError({});
  runner.publishState(true);
  return stateAfter(runner);
}

/// Writes the state to disk; the answer brings the snapshot when it was asked for.
protocol::Expected<std::string> saveState(HostedSimulation& hosted, const protocol::SaveParams& params) {
  if (auto error = params.checkpoint.empty() ? hosted.keep() : hosted.saveCheckpoint(params.checkpoint)) {
    return tl::unexpected(std::move(*error));
  }
  protocol::JsonWriter result;
  result.beginObject().key("step").integer(hosted.simulation().completedSteps());
  result.key("saved").boolean(hosted.isSaved());
  if (!params.checkpoint.empty()) {
    result.key("checkpoint").text(params.checkpoint);
  }
  if (params.hasSnapshot) {
    result.key("snapshot").text(protocol::toBase64(hosted.snapshot()));
  }
  return result.endObject().take();
}

void deleteDamaged(const Request& request, const std::string& name) {
  if (const auto problem = request.session.core().removeDamaged(name)) {
    request.session.respondError(request.id, {protocol::ErrorCode::Storage, *problem, {}});
  } else {
    request.session.respond(request.id, "{}");
  }
}

}  // namespace

namespace methods {

void simulationSet(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::SetParams params) {
  computeInTurn(request, std::move(runner), [params = std::move(params)](SimulationRunner& self) {
    return changed(self, self.hosted().set(params.values));
  });
}

void simulationEdit(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::EditParams params) {
  computeInTurn(request, std::move(runner), [params = std::move(params)](SimulationRunner& self) {
    return changed(self, self.hosted().edit(params));
  });
}

void simulationReset(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::ResetParams params) {
  computeInTurn(request, std::move(runner),
                [seed = params.seed](SimulationRunner& self) { return changed(self, self.hosted().reset(seed)); });
}

void simulationRestore(const Request& request, std::shared_ptr<SimulationRunner> runner,
                       protocol::RestoreParams params) {
  computeInTurn(request, std::move(runner), [params = std::move(params)](SimulationRunner& self) {
    HostedSimulation& hosted = self.hosted();
    return changed(self, params.checkpoint.empty() ? hosted.restore(params.snapshot)
                                                   : hosted.restoreCheckpoint(params.checkpoint));
  });
}

void simulationSave(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::SaveParams params) {
  // also for an account that may compute no more: what it has is not lost
  doInTurn(request, std::move(runner),
           [params = std::move(params)](SimulationRunner& self) { return saveState(self.hosted(), params); });
}

void simulationTrace(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::TraceParams params) {
  computeInTurn(request, std::move(runner), [params](SimulationRunner& self) -> protocol::Expected<std::string> {
    HostedSimulation& hosted = self.hosted();
    if (auto error = hosted.setTraced(params.isTraced)) {
      return tl::unexpected(std::move(*error));
    }
    protocol::JsonWriter result;
    result.beginObject().key("step").integer(hosted.simulation().completedSteps());
    return result.key("traced").boolean(hosted.isTraced()).endObject().take();
  });
}

void simulationDelete(const Request& request, protocol::SimulationParams params) {
  ServerCore& core = request.session.core();
  if (core.findDamaged(params.simulation)) {
    runOnWorker(request, [name = params.simulation](const Request& self) { deleteDamaged(self, name); });
    return;
  }
  const auto runner = findRunner(request, params.simulation);
  if (runner == nullptr) {
    return;
  }
  // in the last turn: no later one writes the files again or adds a stream. Also when the caller is gone by then. Until
  // then nobody gets the identifier
  const auto command = makeCommand(request, {});
  command->advance = [&core, id = request.id, caller = request.session.weak_from_this(), before = runner->closed()](
                         SimulationRunner& self, Command& last) {
    const auto problem = core.store().remove(self.id());
    if (problem) {
      self.reopen(before);
    } else {
      self.endStreams("the simulation was deleted");
      if (!self.isOnDiskOnly()) {
        self.hosted().closeEnvironments();
        self.hosted().closeTrace();
      }
      SimulationTrace::removeAll(core.tracesOf(self.account()), self.id());
      core.remove(self.id());
    }
    self.publishEndOf(last);
    const auto session = caller.lock();
    if (session != nullptr && problem) {
      session->respondError(id, {protocol::ErrorCode::Storage, "Nothing was deleted: " + *problem, {}});
    } else if (session != nullptr) {
      session->respond(id, "{}");
    }
    return false;
  };
  command->needsSimulation = false;
  runner->closeWith(command, {protocol::ErrorCode::NotFound, "The simulation was deleted.", {}});
}

void simulationList(const Request& request, protocol::NoParams) {
  // there may be thousands
  listOnWorker(request, [](const Request& self) {
    const ServerCore& core = self.session.core();
    protocol::JsonWriter result;
    result.beginObject().key("simulations").beginArray();
    for (const auto& runner : core.all()) {
      write(result, runner->information());
    }
    for (const protocol::SimulationInformation& damaged : core.damaged()) {
      write(result, damaged);
    }
    self.session.respond(self.id, result.endArray().endObject().view());
  });
}

}  // namespace methods
}  // namespace espalier::server
