#include <chrono>

#include "protocol/codec.h"
#include "server/remote/translation/translate.h"
#include "server/running/limit_errors.h"
#include "server/server_core.h"
#include "server/session/request_work.h"
#include "server/session/session.h"

namespace espalier::server {
namespace {

using protocol::ErrorCode;

protocol::Error cancelledError(std::uint64_t step) {
  protocol::JsonWriter data;
  data.beginObject().key("step").integer(step).endObject();
  return {ErrorCode::Cancelled, "Cancelled; the simulation stays at step " + std::to_string(step) + ".", data.take()};
}

/// A step command's state between turns.
struct StepProgress {
  protocol::StepParams params;
  std::uint64_t madeSteps = 0;
  std::uint64_t queries = 0;
  std::uint64_t answers = 0;
  double milliseconds = 0.0;
  std::optional<std::chrono::steady_clock::time_point> told;  // the last time that the caller heard how far it is
};

// how often a caller hears of its progress, and how full its outbox may be for it
constexpr std::chrono::milliseconds kProgressInterval{100};
constexpr std::size_t kProgressOutbox = 1'000'000;

/// Says how far a call is, when the caller asked for it.
void tellProgress(SimulationRunner& runner, Session& session, const protocol::MessageId& id, StepProgress& progress) {
  const auto now = std::chrono::steady_clock::now();
  if (!progress.params.wantsProgress || (progress.told && now - *progress.told < kProgressInterval) ||
      session.outboxBytes() > kProgressOutbox) {
    return;
  }
  progress.told = now;
  simulation::Simulation& simulation = runner.hosted().simulation();
  protocol::JsonWriter params;
  params.beginObject().key("id").raw(protocol::toText(id)).key("step").integer(simulation.completedSteps());
  params.key("made").integer(progress.madeSteps).key("modules").integer(simulation.statistics().modules);
  session.notify("$/progress", params.endObject().take());
}

protocol::StepResult resultOf(SimulationRunner& runner, const StepProgress& progress, bool isTruncated) {
  simulation::Simulation& simulation = runner.hosted().simulation();
  protocol::StepResult result;
  result.step = simulation.completedSteps();
  result.isFinished = simulation.isFinished();
  result.isTruncated = isTruncated;
  result.isSaved = runner.hosted().isSaved();
  result.statistics = toStatistics(simulation.statistics(), progress.milliseconds);
  if (progress.madeSteps > 0) {
    result.statistics.queries = progress.queries;
    result.statistics.answers = progress.answers;
  }
  return result;
}

/// Answers with the state, the warnings of the steps, and what the model has printed.
void answerWithState(SimulationRunner& runner, Session& session, const protocol::MessageId& id,
                     const StepProgress& progress, bool isTruncated) {
  if (auto warnings = runner.hosted().takeWarnings(); !warnings.empty()) {
    session.warn(id, std::move(warnings));
  }
  protocol::StepResult result = resultOf(runner, progress, isTruncated);
  result.printed = runner.hosted().takePrinted();
  session.respond(id, protocol::encode(result));
}

/// The error of a step, with what the model has printed before it.
protocol::Error withPrinted(SimulationRunner& runner, protocol::Error error) {
  if (const std::string printed = runner.hosted().takePrinted(); !printed.empty()) {
    protocol::JsonWriter data;
    data.beginObject().key("printed").text(printed);
    const std::string_view others = error.data.size() > 2 ? std::string_view(error.data).substr(1) : "}";
    error.data = data.view() + (others == "}" ? "" : ",") + std::string(others);
  }
  return error;
}

bool isDone(const simulation::Simulation& simulation, const StepProgress& progress) {
  return simulation.isFinished() || (progress.params.until ? simulation.completedSteps() >= *progress.params.until
                                                           : progress.madeSteps >= progress.params.steps);
}

/// One turn: one step. Returns whether there is more to do.
bool advanceSteps(SimulationRunner& runner, Command& command, Session& session, const protocol::MessageId& id,
                  StepProgress& progress) {
  simulation::Simulation& simulation = runner.hosted().simulation();
  if (command.isCancelled) {
    runner.publishEndOf(command);
    session.respondError(id, cancelledError(simulation.completedSteps()));
    return false;
  }
  const bool isAtEnd = isDone(simulation, progress);
  if (isAtEnd || command.isPaused) {
    runner.publishEndOf(command);
    answerWithState(runner, session, id, progress, !isAtEnd);
    return false;
  }
  if (const auto problem = cpuProblemOf(session, runner)) {
    runner.publishEndOf(command);
    session.respondError(id, *problem);
    return false;
  }
  double milliseconds = 0.0;
  const std::uint64_t before = simulation.completedSteps();
  auto error = runner.hosted().step(milliseconds);
  while (error && runner.hasRoomNow()) {
    // a step that is complete only waits to be saved
    error = simulation.completedSteps() > before ? runner.hosted().keep() : runner.hosted().step(milliseconds);
  }
  const bool isMade = simulation.completedSteps() > before;
  if (isMade) {
    const simulation::StepStatistics& statistics = simulation.statistics();
    ++progress.madeSteps;
    progress.queries += statistics.queries;
    progress.answers += statistics.answers;
    progress.milliseconds += milliseconds;
    runner.setMilliseconds(milliseconds);
  }
  if (error && command.isCancelled) {
    runner.setLastError({});
    runner.publishEndOf(command);
    session.respondError(id, cancelledError(simulation.completedSteps()));
    return false;
  }
  if (error) {
    const std::uint64_t stays = simulation.completedSteps();
    const protocol::Error reason =
        command.isOverLimit ? callSecondsError(runner.callSeconds(),
                                               "The simulation stays at step " + std::to_string(stays) + ".", stays)
        : isMade            ? *error
                            : runner.reasonOf(*error);
    runner.setLastError(reason.message);
    runner.publishEndOf(command);
    session.respondError(id, withPrinted(runner, reason));
    if (isMade) {
      runner.publishState(true);
    }
    return false;
  }
  runner.setLastError(runner.hosted().traceProblem());
  const bool isLast = isDone(simulation, progress);
  if (isLast || runner.isClosing()) {
    // the controller first, viewers after
    runner.publishEndOf(command);
    answerWithState(runner, session, id, progress, !isLast);
    runner.publishState(true);
    return false;
  }
  runner.publishState(true);
  tellProgress(runner, session, id, progress);
  return true;
}

std::shared_ptr<Command> makeStepCommand(const Request& request, protocol::StepParams params) {
  auto command = std::make_shared<Command>();
  command->lane = Lane::Step;
  command->owner = request.session.id();
  const auto progress = std::make_shared<StepProgress>();
  progress->params = std::move(params);
  const std::weak_ptr<Session> weak = request.session.weak_from_this();
  command->advance = [weak, id = request.id, progress](SimulationRunner& runner, Command& self) {
    const auto owner = weak.lock();
    return owner != nullptr && advanceSteps(runner, self, *owner, id, *progress);
  };
  command->fail = [weak, id = request.id](const protocol::Error& error) {
    if (const auto owner = weak.lock()) {
      owner->respondError(id, error);
    }
  };
  return command;
}

}  // namespace

namespace methods {

void simulationStep(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::StepParams params) {
  request.session.submit(request.id, std::move(runner), makeStepCommand(request, std::move(params)));
}

void simulationRun(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::StepParams params) {
  params.until = params.until.value_or(UINT64_MAX);
  simulationStep(request, std::move(runner), std::move(params));
}

void simulationPause(const Request& request, std::shared_ptr<SimulationRunner> runner, protocol::SimulationParams) {
  // the steps that wait for a turn are answered as truncated
  doInTurn(request, std::move(runner), [](SimulationRunner& self) -> protocol::Expected<std::string> {
    const std::size_t paused = self.pauseWaiting();
    protocol::JsonWriter result;
    result.beginObject().key("step").integer(self.hosted().simulation().completedSteps());
    return result.key("paused").integer(std::uint64_t{paused}).endObject().take();
  });
}

}  // namespace methods
}  // namespace espalier::server
