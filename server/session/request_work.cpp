#include "server/session/request_work.h"

#include <chrono>
#include <new>

#include "protocol/json_writer.h"
#include "server/running/limit_errors.h"
#include "server/running/turn_meter.h"
#include "server/server_core.h"
#include "server/session/session.h"

namespace espalier::server {

using protocol::ErrorCode;

std::shared_ptr<SimulationRunner> findRunner(const Request& request, const std::string& simulation) {
  ServerCore& core = request.session.core();
  auto runner = core.find(simulation);
  if (runner == nullptr) {
    const auto damaged = core.findDamaged(simulation);
    request.session.respondError(
        request.id,
        damaged ? *damaged
                : protocol::Error{
                      ErrorCode::NotFound,
                      "There is no simulation '" + simulation +
                          "' on this server: it was deleted, or the server was started again and had not kept it "
                          "(--data). simulation.list names those that are there.",
                      {}});
  }
  return runner;
}

namespace {

protocol::Error internalError(Session& session, const std::exception& exception) {
  session.core().log().error(std::string("internal error: ") + exception.what(), {.session = session.id()});
  return {ErrorCode::Internal, std::string("Espalier has a bug: ") + exception.what() + ". Please report it.", {}};
}

/// Runs `work` for an account; a failure is answered.
void runMetered(Session& session, const protocol::MessageId& id, const std::function<void(const Request&)>& work,
                Interruption& interruption) {
  TurnMeter meter(session.account(), MemoryKind::Compiling);
  const Interruption::Scope stopping(interruption, [&meter] { meter.stop(); });
  protocol::Error failure;
  try {
    const core::WorkMeter::Scope scope(&meter);
    work({session, id});
    return;
  } catch (const std::bad_alloc&) {
    failure = {ErrorCode::Limit, "The server has not enough memory for this. Use a smaller model.", {}};
  } catch (const core::WorkStopped&) {
    const std::uint32_t bound = session.core().limits().callSeconds;
    failure = interruption.reason() == Interruption::Reason::CallSeconds
                  ? callSecondsError(bound, "Nothing was made.", {})
                  : protocol::Error{ErrorCode::Cancelled, "Cancelled; nothing was made.", {}};
  } catch (const std::exception& exception) {
    failure = internalError(session, exception);
  }
  if (meter.isRefused()) {
    failure = session.account().memoryError();
  }
  meter.giveBack();
  session.respondError(id, failure);
}

}  // namespace

void runOnWorker(const Request& request, std::function<void(const Request&)> work,
                 std::shared_ptr<Interruption> interruption) {
  Session& session = request.session;
  if (const auto problem = session.account().cpuProblem()) {
    session.respondError(request.id, *problem);
    return;
  }
  if (interruption == nullptr) {
    interruption = std::make_shared<Interruption>();
  }
  session.onCancel(request.id, [interruption] { interruption->interrupt(Interruption::Reason::Cancelled); });
  WorkerPool::Task task;
  task.owner = session.id();
  task.limit = std::chrono::seconds(session.core().limits().callSeconds);
  task.onLimit = [interruption] { interruption->interrupt(Interruption::Reason::CallSeconds); };
  task.run = [weak = session.weak_from_this(), id = request.id, work = std::move(work), interruption] {
    if (const auto self = weak.lock()) {
      runMetered(*self, id, work, *interruption);
    }
  };
  session.core().pool().post(std::move(task));
}

void listOnWorker(const Request& request, std::function<void(const Request&)> work) {
  Session& session = request.session;
  auto run = [weak = session.weak_from_this(), id = request.id, work = std::move(work)] {
    const auto self = weak.lock();
    if (self == nullptr) {
      return;
    }
    try {
      work({*self, id});
    } catch (const std::bad_alloc&) {
      self->respondError(id,
                         {ErrorCode::Limit, "The server has not enough memory for this list. Ask again later.", {}});
    } catch (const std::exception& exception) {
      self->respondError(id, internalError(*self, exception));
    }
  };
  session.core().pool().post({.run = std::move(run), .owner = session.id()});
}

namespace {

/// The outcome of work that changes nothing when it fails. When it was refused memory, other simulations make room.
protocol::Expected<std::string> withRoom(SimulationRunner& runner, const TurnWork& work) {
  while (true) {
    try {
      auto outcome = work(runner);
      if (outcome || !runner.hasRoomNow()) {
        return outcome;
      }
    } catch (const std::bad_alloc&) {
      if (!runner.hasRoomNow()) {
        throw;
      }
    }
  }
}

}  // namespace

std::shared_ptr<Command> makeCommand(const Request& request, TurnWork work) {
  auto command = std::make_shared<Command>();
  command->owner = request.session.id();
  const std::weak_ptr<Session> weak = request.session.weak_from_this();
  command->advance = [weak, id = request.id, work = std::move(work)](SimulationRunner& runner, Command& self) {
    const auto owner = weak.lock();
    if (owner == nullptr) {
      return false;
    }
    const auto outcome = withRoom(runner, work);
    runner.publishEndOf(self);
    if (outcome) {
      owner->respond(id, *outcome);
    } else if (self.isOverLimit) {
      const std::uint64_t step = runner.information().step;
      owner->respondError(id, callSecondsError(runner.callSeconds(),
                                               "The simulation stays at step " + std::to_string(step) + ".", step));
    } else {
      owner->respondError(id, runner.reasonOf(outcome.error()));
    }
    return false;
  };
  command->fail = [weak, id = request.id](const protocol::Error& error) {
    if (const auto self = weak.lock()) {
      self->respondError(id, error);
    }
  };
  return command;
}

std::optional<protocol::Error> cpuProblemOf(Session& session, const SimulationRunner& runner) {
  auto problem = session.account().cpuProblem();
  return problem ? problem : runner.account().cpuProblem();
}

void computeInTurn(const Request& request, std::shared_ptr<SimulationRunner> runner, TurnWork work) {
  if (const auto problem = cpuProblemOf(request.session, *runner)) {
    request.session.respondError(request.id, *problem);
  } else {
    doInTurn(request, std::move(runner), std::move(work));
  }
}

void doInTurn(const Request& request, std::shared_ptr<SimulationRunner> runner, TurnWork work) {
  auto command = makeCommand(request, std::move(work));
  request.session.submit(request.id, std::move(runner), std::move(command));
}

}  // namespace espalier::server
