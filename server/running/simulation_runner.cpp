#include "server/running/simulation_runner.h"

#include <algorithm>
#include <new>
#include <utility>

#include "engine/core/check.h"
#include "server/log.h"
#include "server/remote/limits.h"
#include "server/running/limit_errors.h"
#include "server/running/turn_meter.h"

namespace espalier::server {

SimulationRunner::SimulationRunner(std::unique_ptr<HostedSimulation> hosted, RunnerServices services)
    : id_(hosted->record().id),
      services_(std::move(services)),
      hosted_(std::move(hosted)),
      strings_(*services_.account, MemoryKind::Strings),
      environments_(*services_.account, MemoryKind::Environments),
      models_(*services_.account, MemoryKind::Compiling) {
  services_.account->addSimulations(1);
  publishInformation();
}

SimulationRunner::~SimulationRunner() {
  leaveAccount();
}

void SimulationRunner::leaveAccount() {
  if (isCounted_.exchange(false)) {
    services_.account->addSimulations(-1);
  }
}

void SimulationRunner::publishInformation() {
  if (hosted_ == nullptr) {
    return;
  }
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
  // memory that the turn has reserved is now counted where it is
  if (meter_ != nullptr) {
    meter_->giveBack();
  }
  strings_.set(hosted_->stringBytes());
  environments_.set(hosted_->environmentBytes());
  models_.set(hosted_->modelBytes());
  Productions productions;
  if (auto uses = simulation.productionUses()) {
    productions = {simulation.programs(), std::move(uses)};
  }
  const std::lock_guard lock(mutex_);
  information_ = std::move(information);
  std::swap(productions_, productions);
}

SimulationRunner::Productions SimulationRunner::productions() const {
  const std::lock_guard lock(mutex_);
  return productions_;
}

protocol::SimulationInformation SimulationRunner::information() const {
  const std::lock_guard lock(mutex_);
  auto information = information_;
  information.isRunning = hasSteps();
  return information;
}

bool SimulationRunner::isRunning() const {
  const std::lock_guard lock(mutex_);
  return hasSteps();
}

bool SimulationRunner::hasSteps() const {
  // a request for information is a command too, and no step
  const auto isStepping = [](const auto& command) { return command->lane == Lane::Step && !command->isAnswered; };
  return (current_ != nullptr && isStepping(current_)) || std::any_of(queue_.begin(), queue_.end(), isStepping);
}

void SimulationRunner::replace(std::unique_ptr<HostedSimulation> other) {
  {
    const std::lock_guard lock(mutex_);
    hosted_.swap(other);
  }
  milliseconds_ = 0.0;
  lastError_.clear();
  publishState(true);
}

void SimulationRunner::publishEndOf(Command& command) {
  command.isAnswered = true;
  publishInformation();
}

std::optional<protocol::Error> SimulationRunner::closed() const {
  const std::lock_guard lock(mutex_);
  return closed_;
}

void SimulationRunner::reopen(const std::optional<protocol::Error>& reason) {
  const std::lock_guard lock(mutex_);
  closed_ = reason;
}

std::optional<std::string> SimulationRunner::saveAtEnd() {
  {
    const std::lock_guard lock(mutex_);
    if (isScheduled_) {
      return "the simulation still computes: after the restart it is at its last saved step";
    }
    if (hosted_ == nullptr) {
      return std::nullopt;  // it is on disk
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
                        .limit = std::chrono::seconds(callSeconds()),
                        .onLimit = [self, turn = turnCount_ + 1] { self->giveUpTurn(turn); }};
  if (isAtEndOfTurn) {
    services_.pool->postAtEnd(std::move(task));
  } else {
    services_.pool->post(std::move(task));
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
    if (hosted_ != nullptr) {
      hosted_->setCancelled(false);
    }
  }
  bool wantsMore = false;
  runGuarded(*command, wantsMore);
  lastUse_ = std::chrono::steady_clock::now();
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
    interrupt();
  }
}

void SimulationRunner::interrupt() {
  if (hosted_ != nullptr) {
    hosted_->setCancelled(true);
  }
  if (meter_ != nullptr) {
    meter_->stop();
  }
}

std::optional<protocol::Error> SimulationRunner::activate() {
  if (!isPassive_) {
    return std::nullopt;
  }
  const protocol::Error failure{
      protocol::ErrorCode::Limit, "The server has not enough memory to read the simulation from the data folder.", {}};
  try {
    auto loaded = services_.load(id_);
    if (!loaded) {
      return std::move(loaded.error());
    }
    const std::lock_guard lock(mutex_);
    hosted_ = std::move(*loaded);
    isPassive_ = false;
    return std::nullopt;
  } catch (const std::bad_alloc&) {
    return failure;
  } catch (const core::WorkStopped&) {
    return failure;
  }
}

bool SimulationRunner::makePassive() {
  // its memory is not of the turn that needs room
  const core::WorkMeter::Scope scope(nullptr);
  std::unique_ptr<HostedSimulation> resting;
  std::shared_ptr<Viewers> viewers;
  {
    const std::lock_guard lock(mutex_);
    const bool isIdle = !isScheduled_ && queue_.empty() && !closed_ && hosted_ != nullptr;
    const bool isWatched = viewers_ != nullptr && viewers_->exist();
    if (!isIdle || isWatched || !hosted_->canBePassive()) {
      return false;
    }
    resting = std::move(hosted_);
    productions_ = {};
    viewers = std::move(viewers_);
    isPassive_ = true;
    strings_.set(0);
    environments_.set(0);
    models_.set(0);
  }
  return true;
}

protocol::Error SimulationRunner::reasonOf(protocol::Error error) const {
  if (meter_ == nullptr || !meter_->isRefused()) {
    return error;
  }
  protocol::Error refusal = services_.account->memoryError();
  if (hosted_ != nullptr) {
    refusal.message += " The simulation stays at step " + std::to_string(hosted_->simulation().completedSteps()) + ".";
  }
  return refusal;
}

bool SimulationRunner::hasRoomNow() {
  return meter_ != nullptr && meter_->isRefused() && services_.makeRoom(*this) && meter_->tryAgain();
}

void SimulationRunner::advance(Command& command, bool& wantsMore) {
  std::optional<protocol::Error> error;
  while (command.needsSimulation && (error = activate())) {
    if (!hasRoomNow()) {
      command.fail(reasonOf(std::move(*error)));
      return;
    }
  }
  wantsMore = command.advance(*this, command);
  if (!command.isAnswered) {
    publishInformation();
  }
}

void SimulationRunner::runGuarded(Command& command, bool& wantsMore) {
  TurnMeter meter(*services_.account, MemoryKind::Strings);
  // cancelling reaches it while this turn runs
  const auto setMeter = [this](TurnMeter* present) {
    const std::lock_guard lock(mutex_);
    meter_ = present;
  };
  setMeter(&meter);
  const core::WorkMeter::Scope scope(&meter);
  std::optional<protocol::Error> failure;
  std::string bug;
  try {
    advance(command, wantsMore);
  } catch (const std::bad_alloc&) {
    failure = {protocol::ErrorCode::Limit,
               "The server has not enough memory for this. Use a smaller model or fewer steps.",
               {}};
  } catch (const core::WorkStopped&) {
    const std::uint64_t step = information().step;
    const std::string stays = "The simulation stays at step " + std::to_string(step) + ".";
    failure = command.isOverLimit
                  ? callSecondsError(callSeconds(), stays, step)
                  : protocol::Error{protocol::ErrorCode::Cancelled, "Cancelled; the simulation is as it was.", {}};
  } catch (const std::exception& exception) {
    bug = exception.what();
  }
  if (failure && !command.isAnswered) {
    command.fail(reasonOf(std::move(*failure)));
  }
  setMeter(nullptr);
  if (bug.empty()) {
    return;
  }
  // a bug of ours closes this simulation and nothing else
  services_.log->error("closed after an internal error: " + bug, {.simulation = id_});
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
    interrupt();
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
      interrupt();
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
    Viewers::Options options{
        .simulation = id_, .account = services_.account, .limits = services_.limits, .askLatest = {}};
    options.askLatest = [weak = weak_from_this()] {
      if (const auto self = weak.lock()) {
        self->catchUp();
      }
    };
    viewers_ = std::make_shared<Viewers>(std::move(options), *services_.pool, *services_.log);
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
