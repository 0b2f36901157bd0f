#include "server/session/request_work.h"

#include <chrono>
#include <new>

#include "protocol/json_writer.h"
#include "server/server_core.h"
#include "server/session/session.h"

namespace espalier::server {

using protocol::ErrorCode;

std::shared_ptr<SimulationRunner> findRunner(const Request& request, const std::string& simulation) {
  ServerCore& core = request.session.core();
  auto runner = core.find(simulation);
  if (runner == nullptr) {
    const auto damaged = core.findDamaged(simulation);
    request.session.respondError(request.id, damaged ? *damaged
                                                     : protocol::Error{ErrorCode::NotFound,
                                                                       "There is no simulation '" + simulation +
                                                                           "'. simulation.list names those there are.",
                                                                       {}});
  }
  return runner;
}

void runOnWorker(const Request& request, std::function<void(const Request&)> work,
                 std::shared_ptr<Interruption> interruption) {
  Session& session = request.session;
  WorkerPool::Task task;
  task.owner = session.id();
  if (interruption != nullptr) {
    session.onCancel(request.id, [interruption] { interruption->interrupt(Interruption::Reason::Cancelled); });
    task.limit = std::chrono::seconds(session.core().options().limits.callSeconds);
    task.onLimit = [interruption] { interruption->interrupt(Interruption::Reason::CallSeconds); };
  }
  task.run = [weak = session.weak_from_this(), id = request.id, work = std::move(work)] {
    const auto self = weak.lock();
    if (self == nullptr) {
      return;
    }
    try {
      work({*self, id});
    } catch (const std::bad_alloc&) {
      self->respondError(id, {ErrorCode::Limit, "The server has not enough memory for this. Use a smaller model.", {}});
    } catch (const std::exception& exception) {
      self->core().log().error(std::string("internal error: ") + exception.what(), {.session = self->id()});
      self->respondError(
          id,
          {ErrorCode::Internal, std::string("Espalier has a bug: ") + exception.what() + ". Please report it.", {}});
    }
  };
  session.core().pool().post(std::move(task));
}

std::shared_ptr<Command> makeCommand(const Request& request, TurnWork work) {
  auto command = std::make_shared<Command>();
  command->owner = request.session.id();
  const std::weak_ptr<Session> weak = request.session.weak_from_this();
  command->advance = [weak, id = request.id, work = std::move(work)](SimulationRunner& runner, Command& self) {
    const auto owner = weak.lock();
    if (owner == nullptr) {
      return false;
    }
    const auto outcome = work(runner);
    runner.publishEndOf(self);
    if (outcome) {
      owner->respond(id, *outcome);
    } else {
      owner->respondError(id, outcome.error());
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

void doInTurn(const Request& request, std::shared_ptr<SimulationRunner> runner, TurnWork work) {
  auto command = makeCommand(request, std::move(work));
  request.session.submit(request.id, std::move(runner), std::move(command));
}

protocol::Error callSecondsError(std::uint64_t bound, const std::string& outcome, std::optional<std::uint64_t> step) {
  protocol::JsonWriter data;
  data.beginObject().key("limit").text("callSeconds").key("value").integer(bound + 1).key("bound").integer(bound);
  if (step) {
    data.key("step").integer(*step);
  }
  return {ErrorCode::Limit,
          "callSeconds is limited to " + std::to_string(bound) + ", and this has computed longer. " + outcome +
              " Use a smaller model, or start the server with a higher --limit callSeconds=N.",
          data.endObject().take()};
}

}  // namespace espalier::server
