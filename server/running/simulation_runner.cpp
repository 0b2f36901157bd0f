#include "server/running/simulation_runner.h"

#include <algorithm>
#include <new>
#include <utility>

#include "engine/core/check.h"
#include "server/log.h"
#include "server/remote/limits.h"

namespace espalier::server {

SimulationRunner::SimulationRunner(std::unique_ptr<HostedSimulation> hosted, WorkerPool& pool, const Log& log,
                                   const ServerLimits& limits)
    : id_(hosted->record().id),
      hosted_(std::move(hosted)),
      pool_(&pool),
      log_(&log),
      callSeconds_(limits.callSeconds),
      streamBytesBound_(limits.streamBytes) {
  publishInformation();
}

void SimulationRunner::publishInformation() {
  const simulation::Simulation& simulation = hosted_->simulation();
  const SimulationRecord& record = hosted_->record();
  protocol::SimulationInformation information;
  information.simulation = id_;
  information.name = record.create.name;
  information.step = simulation.completedSteps();
  information.derivationLength = simulation.derivationLength();
  information.seed = record.seed;
  information.plants = static_cast<std::uint32_t>(simulation.plantCount());
  information.isFinished = simulation.isFinished();
  information.isSaved = hosted_->isSaved();
  information.environment = hosted_->environmentNames();
  information.lastError = lastError_;
  stringBytes_ = simulation.statistics().bytes;
  const std::lock_guard lock(mutex_);
  information_ = std::move(information);
}

protocol::SimulationInformation SimulationRunner::information() const {
  const std::lock_guard lock(mutex_);
  auto information = information_;
  // a request for this information is a command too, and no step
  const auto isStepping = [](const auto& command) { return command->lane == Lane::Step && !command->isAnswered; };
  information.isRunning =
      (current_ != nullptr && isStepping(current_)) || std::any_of(queue_.begin(), queue_.end(), isStepping);
  return information;
}

void SimulationRunner::publishEndOf(Command& command) {
  command.isAnswered = true;
  publishInformation();
}

bool SimulationRunner::isClosing() const {
  const std::lock_guard lock(mutex_);
  return closed_.has_value();
}

std::optional<std::string> SimulationRunner::saveAtEnd() {
  {
    const std::lock_guard lock(mutex_);
    if (isScheduled_) {
      return "the simulation still computes: after the restart it is at its last saved step";
    }
  }
  if (hosted_->record().create.save.every == 0) {
    return std::nullopt;
  }
  const auto error = hosted_->keep();
  return error ? std::optional(error->message) : std::nullopt;
}

void SimulationRunner::submit(std::shared_ptr<Command> command) {
  std::optional<protocol::Error> refusal;
  {
    const std::lock_guard lock(mutex_);
    if (closed_) {
      refusal = closed_;
    } else {
      queue_.push_back(std::move(command));
      schedule(false);
    }
  }
  if (refusal) {
    command->fail(*refusal);
  }
}

void SimulationRunner::schedule(bool isAtEndOfTurn) {
  if (isScheduled_ || queue_.empty()) {
    return;
  }
  isScheduled_ = true;
  const Command& next = *queue_.front();
  const auto self = shared_from_this();
  WorkerPool::Task task{.run = [self] { self->takeTurn(); },
                        .lane = next.lane,
                        .owner = next.owner,
                        .limit = std::chrono::seconds(callSeconds_),
                        .onLimit = [self, turn = turnCount_ + 1] { self->giveUpTurn(turn); }};
  if (isAtEndOfTurn) {
    pool_->postAtEnd(std::move(task));
  } else {
    pool_->post(std::move(task));
  }
}

void SimulationRunner::takeTurn() {
  std::shared_ptr<Command> command;
  {
    const std::lock_guard lock(mutex_);
    ++turnCount_;
    if (queue_.empty()) {
      isScheduled_ = false;
      return;
    }
    command = std::move(queue_.front());
    queue_.pop_front();
    current_ = command;
    command->isOverLimit = false;
    hosted_->setCancelled(false);
  }
  bool wantsMore = false;
  runGuarded(*command, wantsMore);
  const std::lock_guard lock(mutex_);
  current_.reset();
  if (wantsMore) {
    queue_.push_back(std::move(command));
  }
  isScheduled_ = false;
  schedule(true);
}

void SimulationRunner::giveUpTurn(std::uint64_t turn) {
  const std::lock_guard lock(mutex_);
  if (current_ != nullptr && turnCount_ == turn) {
    current_->isOverLimit = true;
    hosted_->setCancelled(true);
  }
}

void SimulationRunner::runGuarded(Command& command, bool& wantsMore) {
  std::string bug;
  try {
    wantsMore = command.advance(*this, command);
    if (!command.isAnswered) {
      publishInformation();
    }
    return;
  } catch (const std::bad_alloc&) {
    command.fail({protocol::ErrorCode::Limit,
                  "The server has not enough memory for this. Use a smaller model or fewer steps.",
                  {}});
    return;
  } catch (const std::exception& exception) {
    bug = exception.what();
  }
  // a bug of ours closes this simulation and nothing else
  log_->error("closed after an internal error: " + bug, {.simulation = id_});
  const protocol::Error error{protocol::ErrorCode::Internal,
                              "Espalier has a bug: " + bug + ". This simulation is closed; please report it.",
                              {}};
  command.fail(error);
  close(error, false);
  endStreams(error.message);
}

void SimulationRunner::cancel(const std::shared_ptr<Command>& command) {
  const std::lock_guard lock(mutex_);
  command->isCancelled = true;
  if (current_ == command) {
    hosted_->setCancelled(true);
  }
}

void SimulationRunner::close(const protocol::Error& reason, bool isInterrupting) {
  std::deque<std::shared_ptr<Command>> dropped;
  {
    const std::lock_guard lock(mutex_);
    closed_ = reason;
    dropped.swap(queue_);
    if (isInterrupting && current_ != nullptr) {
      current_->isCancelled = true;
      hosted_->setCancelled(true);
    }
  }
  for (const auto& command : dropped) {
    command->fail(reason);
  }
}

void SimulationRunner::closeWith(std::shared_ptr<Command> last, const protocol::Error& reason) {
  close(reason, true);
  const std::lock_guard lock(mutex_);
  queue_.push_back(std::move(last));
  schedule(false);
}

std::size_t SimulationRunner::pauseWaiting() {
  const std::lock_guard lock(mutex_);
  std::size_t count = 0;
  for (const auto& command : queue_) {
    command->isPaused = true;
    count += command->lane == Lane::Step ? 1U : 0U;
  }
  return count;
}

Viewers& SimulationRunner::viewers() {
  const std::lock_guard lock(mutex_);
  if (viewers_ == nullptr) {
    Viewers::Options options{.simulation = id_, .streamBytes = streamBytesBound_, .askLatest = {}};
    options.askLatest = [weak = weak_from_this()] {
      if (const auto self = weak.lock()) {
        self->catchUp();
      }
    };
    viewers_ = std::make_shared<Viewers>(std::move(options), *pool_, *log_);
  }
  return *viewers_;
}

std::uint64_t SimulationRunner::streamBytes() const {
  const std::lock_guard lock(mutex_);
  return viewers_ == nullptr ? 0 : viewers_->bytes();
}

void SimulationRunner::addStream(std::shared_ptr<Stream> stream) {
  viewers().add(stream);
  handOver(true, std::move(stream));
}

void SimulationRunner::publishState(bool isDue) {
  // only the worker that owns the simulation sets it
  if (viewers_ == nullptr) {
    return;
  }
  simulation::Simulation& simulation = hosted_->simulation();
  if (!viewers_->exist()) {
    simulation.followChanges(false);
    hosted_->recordQueries(false);
  } else if (viewers_->takeState(simulation.completedSteps(), simulation.statistics().bytes, isDue)) {
    handOver(isDue, nullptr);
  }
}

void SimulationRunner::handOver(bool isDue, std::shared_ptr<Stream> first) {
  simulation::Simulation& simulation = hosted_->simulation();
  // queries and changes are noted only when a viewer wants them
  hosted_->recordQueries(viewers_->wantQueries());
  simulation.followChanges(viewers_->wantDifferences());
  // the queries of the last step, not of a step before a reset or of one that failed
  auto queries = hosted_->lastQueries();
  const bool isOfLastStep = queries != nullptr && queries->queries.step + 1 == simulation.completedSteps();
  viewers_->handOver({.plants = simulation.takeView(),
                      .milliseconds = milliseconds_,
                      .queries = isOfLastStep ? std::move(queries) : nullptr,
                      .isDue = isDue,
                      .first = std::move(first)});
}

void SimulationRunner::catchUp() {
  {
    const std::lock_guard lock(mutex_);
    if (isCatchingUp_ || closed_ || viewers_ == nullptr) {
      return;
    }
    isCatchingUp_ = true;
  }
  const auto command = std::make_shared<Command>();
  command->advance = [](SimulationRunner& runner, Command&) {
    {
      const std::lock_guard lock(runner.mutex_);
      runner.isCatchingUp_ = false;
    }
    runner.publishState(false);
    return false;
  };
  command->fail = [](const protocol::Error&) {};
  submit(command);
}

void SimulationRunner::endStreams(const std::string& reason) {
  std::shared_ptr<Viewers> viewers;
  {
    const std::lock_guard lock(mutex_);
    viewers = viewers_;
  }
  if (viewers != nullptr) {
    viewers->end(reason);
  }
}

}  // namespace espalier::server
