#include <cmath>
#include <utility>

#include "engine/core/check.h"
#include "engine/core/number_text.h"
#include "engine/simulation/simulation_implementation.h"
#include "engine/turtle/guarded_call.h"
#include "engine/turtle/scene/geometry.h"

namespace espalier::simulation {

void Simulation::Implementation::answerPass() {
  if (!isStarted_) {
    core::SimulationError error;
    error.code = core::SimulationErrorCode::Model;
    error.message = "The simulation has not been started. Rewind it or restore a snapshot first.";
    throw core::SimulationFailure(std::move(error));
  }
  if (isAnswered_) {
    return;
  }
  statistics_.queries = 0;
  statistics_.answers = 0;
  statistics_.iterations = 0;
  queries_.clear();
  forgetLife();
  if (models_.hasQueries()) {
    interpretForQueries();
  }
  if (environment_) {
    consultEnvironment();
  }
  writeLifeReplies();
  isAnswered_ = true;
}

void Simulation::Implementation::interpretForQueries() {
  queryOffsets_.clear();
  forgetLife();
  turtle::EnvironmentNeeds needs = description_.needs;
  needs.position = needs.position || models_.hasLifeQueries();
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    const PlantOrigin& origin = members_[plant].origin;
    if (!members_[plant].isAlive() || !programOf(plant).hasQueries) {
      continue;
    }
    StepUndo& undo = undo_[plant];
    undo.variables.copyFrom(plants_[plant]);
    undo.hasVariables = true;
    turtle::InterpretationOutput output;
    output.queries = &queries_;
    output.needs = needs;
    output.queryParameterOffsets = &queryOffsets_;
    output.changes = &undo.changes;
    const std::size_t firstQuery = queries_.size();
    models_.interpreter(origin.model)
        .interpret(*derivations_[plant], plants_[plant], static_cast<std::uint32_t>(plant), origin.placement, output);
    models_.toCommonSymbols(origin.model, firstQuery, queries_);
  }
  statistics_.queries = queries_.size();
  if (models_.hasLifeQueries()) {
    takeLifeQueries();
  }
}

void Simulation::Implementation::measureGeometry() {
  turtle::Scene scene;
  turtle::InterpretationOutput output;
  output.scene = &scene;
  if (auto error = draw(std::move(output))) {
    throw core::SimulationFailure(std::move(*error));
  }
  auto geometry = std::make_shared<turtle::Geometry>();
  const auto symbolOf = [this](std::uint32_t plant, std::uint64_t module) {
    return models_.commonSymbol(members_[plant].origin.model,
                                programOf(plant).symbolOf[plants_[plant].string.types()[module]]);
  };
  turtle::appendGeometry(std::move(scene), models_.view(), symbolOf, *geometry);
  queries_.geometry = std::move(geometry);
}

void Simulation::Implementation::consultEnvironment() {
  // the reference transmits nothing in a step without queries
  const bool needsGeometry = description_.needs.geometry;
  if (queries_.size() == 0 && (!needsGeometry || isCompatible())) {
    tickEnvironment();
    return;
  }
  // replies that had arrived when the step failed are not asked for twice
  const bool hasKept = pending_.hasReplies && pending_.replies.values.size() == queries_.parameters.size();
  if (!hasKept) {
    pending_.hasReplies = false;
    exchange();
    pending_.hasReplies = true;
  }
  statistics_.answers = 0;
  writeReplies(pending_.replies);
}

void Simulation::Implementation::exchangeOnce(std::uint32_t iteration) {
  queries_.step = completedSteps_;
  queries_.timeDays = static_cast<double>(completedSteps_) * options_.world.stepDurationDays;
  queries_.iteration = iteration;
  pending_.replies.prepare(queries_);
  if (description_.needs.geometry) {
    measureGeometry();
  }
  const auto ask = [&] { return environment_->step(queries_, pending_.replies); };
  if (const auto error = turtle::guardedCall(description_.name, ask)) {
    if (options_.environmentPolicy == EnvironmentPolicy::Fail) {
      throw core::SimulationFailure(environmentFailure(*error));
    }
    pending_.replies.prepare(queries_);
  }
  requireFiniteReplies();
  statistics_.iterations = iteration + 1;
}

/// Asks the environment; when the coupling is iterated, again and again until its answers stay as they are. Afterwards
/// pending_.replies holds what all iterations set.
void Simulation::Implementation::exchange() {
  if (options_.coupling.iterations <= 1 || queries_.size() == 0) {
    exchangeOnce(0);
    return;
  }
  const std::string before = description_.isStateful ? environment_->save() : std::string();
  if (description_.isStateful && before.empty()) {
    throw core::SimulationFailure(
        environmentFailure({"environment '" + description_.name +
                                "' changes from step to step and cannot give its state back. Iterated coupling asks it "
                                "several times from the same state: let it save and restore, or do not iterate.",
                            false}));
  }
  const auto goBack = [&]() -> std::optional<turtle::EnvironmentError> {
    return description_.isStateful ? environment_->restore(before) : std::nullopt;
  };
  try {
    exchangeOnce(0);
    turtle::ReplyBatch all = pending_.replies;
    const std::vector<std::uint64_t> offsets = queryOffsets_;
    std::vector<double> sent = queries_.parameters;
    bool isSettled = hasSettled(sent, pending_.replies);
    for (std::uint32_t iteration = 1; iteration < options_.coupling.iterations && !isSettled; ++iteration) {
      if (const auto error = goBack()) {
        throw core::SimulationFailure(environmentFailure(*error));
      }
      // the same pass over strings that hold the answers
      rewindPass();
      writeReplies(all);
      queries_.clear();
      interpretForQueries();
      // the string is the same but for answers, which no homomorphism reads
      ESPALIER_CHECK(queryOffsets_ == offsets);
      sent = queries_.parameters;
      exchangeOnce(iteration);
      isSettled = hasSettled(sent, pending_.replies);
      for (std::size_t k = 0; k < all.values.size(); ++k) {
        if (pending_.replies.isSet[k] != 0) {
          all.values[k] = pending_.replies.values[k];
          all.isSet[k] = 1;
        }
      }
    }
    if (!isSettled && options_.messages) {
      options_.messages(core::MessageKind::Warning,
                        "step " + std::to_string(completedSteps_ + 1) + ": the answers of environment '" +
                            description_.name + "' did not settle in " + std::to_string(options_.coupling.iterations) +
                            " iterations; the last are used");
    }
    // as if they were the answers to the strings before
    rewindPass();
    queries_.clear();
    interpretForQueries();
    pending_.replies = std::move(all);
  } catch (...) {
    static_cast<void>(goBack());
    throw;
  }
}

/// No answer changes a parameter by more than the tolerance.
bool Simulation::Implementation::hasSettled(const std::vector<double>& sent, const turtle::ReplyBatch& replies) const {
  for (std::size_t k = 0; k < sent.size(); ++k) {
    if (replies.isSet[k] == 0) {
      continue;
    }
    // what the string will hold
    const double value =
        isCompatible() ? static_cast<double>(static_cast<float>(replies.values[k])) : replies.values[k];
    const double change = std::fabs(value - sent[k]);
    if (change > options_.coupling.tolerance) {
      return false;
    }
  }
  return true;
}

/// Back to before the interpretation pass, without giving up the step.
void Simulation::Implementation::rewindPass() {
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    undo_[plant].apply(plants_[plant]);
  }
}

void Simulation::Implementation::tickEnvironment() {
  // the reference transmits nothing in a step without queries, and time stands still for its environments
  if (isCompatible() || pending_.hasTicked) {
    return;
  }
  const auto tick = [&] { return environment_->tick(completedSteps_); };
  if (const auto error = turtle::guardedCall(description_.name, tick)) {
    if (options_.environmentPolicy == EnvironmentPolicy::Fail) {
      throw core::SimulationFailure(environmentFailure(*error));
    }
  }
  pending_.hasTicked = true;
}

void Simulation::Implementation::requireFiniteReplies() const {
  const turtle::ReplyBatch& replies = pending_.replies;
  for (std::size_t query = 0; query < queries_.size(); ++query) {
    for (std::uint64_t k = queries_.parameterOffset[query]; k < queries_.parameterOffset[query + 1]; ++k) {
      if (replies.isSet[k] == 0 || std::isfinite(replies.values[k])) {
        continue;
      }
      core::SimulationError error;
      error.code = core::SimulationErrorCode::NonFinite;
      error.step = completedSteps_ + 1;
      error.plant = queries_.plant[query];
      error.module = queries_.module[query];
      error.message = "step " + std::to_string(error.step) + ", plant " + std::to_string(error.plant) + ", module " +
                      std::to_string(*error.module) + " ('" + models_.symbolNames()[queries_.symbol[query]] +
                      "'): environment '" + description_.name + "' answered ";
      core::appendNumber(error.message, replies.values[k], core::NumberStyle::Shortest);
      error.message += " for parameter " + std::to_string(k - queries_.parameterOffset[query] + 1) + " of query " +
                       std::to_string(query) + ". Replies must be finite numbers: correct the environment.";
      throw core::SimulationFailure(std::move(error));
    }
  }
}

void Simulation::Implementation::writeReplies(const turtle::ReplyBatch& replies) {
  for (std::size_t query = 0; query < queries_.size(); ++query) {
    const std::uint64_t begin = queries_.parameterOffset[query];
    const std::uint64_t end = queries_.parameterOffset[query + 1];
    const std::uint32_t plant = queries_.plant[query];
    bool isAnswer = false;
    for (std::uint64_t k = begin; k < end; ++k) {
      if (replies.isSet[k] == 0) {
        continue;
      }
      isAnswer = true;
      if (queryOffsets_[query] == turtle::kTransientQuery) {
        continue;
      }
      writeReply(plant, queryOffsets_[query] + (k - begin), replies.values[k]);
    }
    statistics_.answers += isAnswer ? 1U : 0U;
  }
  if (replies.surplusCount > 0 && options_.messages) {
    options_.messages(core::MessageKind::Warning,
                      "environment '" + description_.name + "' gave " + std::to_string(replies.surplusCount) +
                          " more values than the communication modules have parameters; they are dropped");
  }
}

void Simulation::Implementation::writeReply(std::uint32_t plant, std::uint64_t offset, double value) {
  derivation::ModuleString& string = plants_[plant].string;
  undo_[plant].changes.push_back({offset, string.parameters()[offset]});
  string.setParameter(offset, isCompatible() ? static_cast<double>(static_cast<float>(value)) : value);
}

core::SimulationError Simulation::Implementation::environmentFailure(const turtle::EnvironmentError& error) const {
  core::SimulationError failure;
  failure.code = core::SimulationErrorCode::EnvironmentFailed;
  failure.step = isStarted_ ? completedSteps_ + 1 : 0;
  failure.isRetryable = error.isRetryable;
  failure.message = error.message;
  return failure;
}

}  // namespace espalier::simulation
