#include <cmath>
#include <utility>

#include "engine/core/number_text.h"
#include "engine/simulation/simulation_implementation.h"
#include "engine/turtle/geometry.h"

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
  queries_.clear();
  if (program_->hasQueries) {
    interpretForQueries();
  }
  if (environment_) {
    queries_.step = completedSteps_;
    queries_.timeDays = static_cast<double>(completedSteps_) * options_.world.stepDurationDays;
    consultEnvironment();
  }
  isAnswered_ = true;
}

void Simulation::Implementation::interpretForQueries() {
  queryOffsets_.clear();
  for (std::size_t plant = 0; plant < plants_.size(); ++plant) {
    StepUndo& undo = undo_[plant];
    undo.variables.copyFrom(plants_[plant]);
    undo.hasVariables = true;
    turtle::InterpretationOutput output;
    output.queries = &queries_;
    output.needs = description_.needs;
    output.queryParameterOffsets = &queryOffsets_;
    output.changes = &undo.changes;
    interpreter_.interpret(derivations_[plant], plants_[plant], static_cast<std::uint32_t>(plant), placements_[plant],
                           output);
  }
  statistics_.queries = queries_.size();
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
    return program_->symbolOf[plants_[plant].string.types()[module]];
  };
  turtle::appendGeometry(std::move(scene), program_->view, symbolOf, *geometry);
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
    pending_.replies.prepare(queries_);
    if (needsGeometry) {
      measureGeometry();
    }
    if (const auto error = environment_->step(queries_, pending_.replies)) {
      if (options_.environmentPolicy == EnvironmentPolicy::Fail) {
        throw core::SimulationFailure(environmentFailure(*error));
      }
      pending_.replies.prepare(queries_);
    }
    requireFiniteReplies();
    pending_.hasReplies = true;
  }
  writeReplies();
}

void Simulation::Implementation::tickEnvironment() {
  // the reference transmits nothing in a step without queries, and time stands still for its environments
  if (isCompatible() || pending_.hasTicked) {
    return;
  }
  if (const auto error = environment_->tick(completedSteps_)) {
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
                      std::to_string(*error.module) + " ('" + program_->symbols[queries_.symbol[query]].name +
                      "'): environment '" + description_.name + "' answered ";
      core::appendNumber(error.message, replies.values[k], core::NumberStyle::Shortest);
      error.message += " for parameter " + std::to_string(k - queries_.parameterOffset[query] + 1) + " of query " +
                       std::to_string(query) + ". Replies must be finite numbers: correct the environment.";
      throw core::SimulationFailure(std::move(error));
    }
  }
}

void Simulation::Implementation::writeReplies() {
  const turtle::ReplyBatch& replies = pending_.replies;
  for (std::size_t query = 0; query < queries_.size(); ++query) {
    const std::uint64_t begin = queries_.parameterOffset[query];
    const std::uint64_t end = queries_.parameterOffset[query + 1];
    const std::uint32_t plant = queries_.plant[query];
    const auto parameters = plants_[plant].string.mutableParameters();
    bool isAnswer = false;
    for (std::uint64_t k = begin; k < end; ++k) {
      if (replies.isSet[k] == 0) {
        continue;
      }
      isAnswer = true;
      if (queryOffsets_[query] == turtle::kTransientQuery) {
        continue;
      }
      const std::uint64_t offset = queryOffsets_[query] + (k - begin);
      undo_[plant].changes.push_back({offset, parameters[offset]});
      parameters[offset] =
          isCompatible() ? static_cast<double>(static_cast<float>(replies.values[k])) : replies.values[k];
    }
    statistics_.answers += isAnswer ? 1U : 0U;
  }
  if (replies.surplusCount > 0 && options_.messages) {
    options_.messages(core::MessageKind::Warning,
                      "environment '" + description_.name + "' gave " + std::to_string(replies.surplusCount) +
                          " more values than the communication modules have parameters; they are dropped");
  }
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
