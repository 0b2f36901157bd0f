#include "engine/simulation/step/answer_pass.h"

#include <cmath>
#include <memory>
#include <numeric>
#include <string>
#include <utility>

#include "engine/core/check.h"
#include "engine/core/diagnostic.h"
#include "engine/core/number_text.h"
#include "engine/turtle/scene/geometry.h"

namespace espalier::simulation {
namespace {

constexpr std::uint64_t kLongString = 10'000;  // modules; a shorter one is interpreted as fast as it is compared
constexpr std::uint32_t kRest = 8;             // passes of a model that changes much, until it is tried again

std::uint64_t keptModules(const derivation::StepChanges& changes) {
  std::uint64_t sum = 0;
  for (const derivation::KeptModules& run : changes.kept()) {
    sum += run.modules;
  }
  return sum;
}

}  // namespace

void AnswerPass::run(std::uint64_t completedSteps) {
  completedSteps_ = completedSteps;
  parts_.statistics.queries = 0;
  parts_.statistics.answers = 0;
  parts_.statistics.iterations = 0;
  queries_.clear();
  parts_.births.clear();
  // the turtle goes through the strings, fills its query modules and collects the communication modules
  if (parts_.models.hasQueries()) {
    interpret();
  }
  // the environment answers them all at once; its replies go into the strings
  if (parts_.environment.exists()) {
    consultEnvironment();
  }
  // the simulation itself answers those that ask about seeds
  parts_.statistics.answers += parts_.births.writeReplies(parts_.population.states(), parts_.transaction);
}

void AnswerPass::interpret() {
  queryOffsets_.clear();
  parts_.births.clear();
  Population& population = parts_.population;
  // seeds need the turtle's position, whatever the environment needs
  turtle::EnvironmentNeeds needs = parts_.environment.description().needs;
  needs.position = needs.position || parts_.models.hasLifeQueries();
  // the changes of each string since the last pass
  const bool wasKnown = parts_.changes.isKnown(ChangeReader::Queries);
  parts_.changes.follow(ChangeReader::Queries, wantsChanges());
  const auto changes = parts_.changes.take(ChangeReader::Queries, population.states());
  stretches_.resize(population.states().size());
  std::uint64_t modules = 0;
  std::uint64_t kept = 0;
  for (std::size_t plant = 0; plant < population.states().size(); ++plant) {
    const PlantOrigin& origin = population.member(plant).origin;
    if (!population.member(plant).isAlive() || !population.program(plant).hasQueries) {
      continue;
    }
    // the turtle writes into the string and runs blocks: own the memory, and remember what to take back
    derivation::PlantState& state = population.states()[plant];
    population.derivation(plant).ownParameters(state);
    parts_.transaction.rememberVariables(plant, state);
    turtle::InterpretationOutput output;
    output.queries = &queries_;
    output.needs = needs;
    output.queryParameterOffsets = &queryOffsets_;
    output.changes = &parts_.transaction.changesOf(plant);
    const std::size_t firstQuery = queries_.size();
    turtle::Interpreter& interpreter = population.interpreter(plant);
    const auto number = static_cast<std::uint32_t>(plant);
    const std::uint64_t keptHere = keptModules(changes[plant]);
    // take over the queries of stretches that did not change, or interpret the whole string
    if (interpreter.mayTakeOver() && keptHere > state.string.size() / 2) {
      interpreter.takeOver(population.derivation(plant), state, number, origin.placement, output, changes[plant],
                           stretches_[plant]);
    } else {
      stretches_[plant].forget();
      interpreter.interpret(population.derivation(plant), state, number, origin.placement, output);
    }
    modules += state.string.size();
    kept += stretches_[plant].isWhole() ? keptHere : 0;
    parts_.models.toCommonSymbols(origin.model, firstQuery, queries_);
  }
  // a model that changes much is interpreted whole for some steps
  if (wasKnown && kept * 2 < modules) {
    rest_ = kRest;
  } else if (rest_ > 0) {
    --rest_;
  }
  parts_.statistics.queries = queries_.size();
  // the simulation keeps the queries about seeds and deaths for itself
  if (parts_.models.hasLifeQueries()) {
    parts_.births.takeQueries(parts_.models, population, parts_.options, parts_.derivations.seed(), completedSteps_,
                              queries_, queryOffsets_);
  }
}

std::uint64_t AnswerPass::bytes() const {
  return std::accumulate(stretches_.begin(), stretches_.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const turtle::QueryStretches& it) { return sum + it.bytes(); });
}

bool AnswerPass::wantsChanges() const {
  // iterations interpret other strings in between
  if (parts_.options.coupling.iterations > 1 || rest_ > 0) {
    return false;
  }
  const Population& population = parts_.population;
  for (std::size_t plant = 0; plant < population.states().size(); ++plant) {
    if (population.program(plant).hasQueries && population.states()[plant].string.size() >= kLongString &&
        population.interpreter(plant).mayTakeOver()) {
      return true;
    }
  }
  return false;
}

void AnswerPass::consultEnvironment() {
  // the reference transmits nothing in a step without queries
  const bool needsGeometry = parts_.environment.description().needs.geometry;
  if (queries_.size() == 0 && (!needsGeometry || isCompatible())) {
    tickEnvironment();
    return;
  }
  // replies that had arrived when the step failed are not asked for twice
  EnvironmentAnswer& answer = parts_.transaction.answer();
  if (!answer.hasReplies || answer.replies.values.size() != queries_.parameters.size()) {
    answer.hasReplies = false;
    exchange();
    answer.hasReplies = true;
  }
  parts_.statistics.answers = 0;
  writeReplies(answer.replies);
}

void AnswerPass::tickEnvironment() {
  // the reference transmits nothing in a step without queries, and time stands still for its environments
  EnvironmentAnswer& answer = parts_.transaction.answer();
  if (isCompatible() || answer.hasTicked) {
    return;
  }
  const auto error = parts_.environment.tick(completedSteps_);
  if (error && parts_.options.environmentPolicy == EnvironmentPolicy::Fail) {
    fail(*error);
  }
  answer.hasTicked = true;
}

/// Asks the environment. Afterwards the transaction holds what it set.
void AnswerPass::exchange() {
  if (parts_.options.coupling.iterations <= 1 || queries_.size() == 0) {
    exchangeOnce(0);
  } else {
    exchangeIterated();
  }
}

void AnswerPass::exchangeOnce(std::uint32_t iteration) {
  turtle::ReplyBatch& replies = parts_.transaction.answer().replies;
  queries_.step = completedSteps_;
  queries_.timeDays = turtle::beginOfStep(parts_.options.world.stepDurationDays, completedSteps_);
  queries_.iteration = iteration;
  replies.prepare(queries_);
  if (parts_.environment.description().needs.geometry) {
    measureGeometry();
  }
  if (const auto error = parts_.environment.step(queries_, replies)) {
    if (parts_.options.environmentPolicy == EnvironmentPolicy::Fail) {
      fail(*error);
    }
    replies.prepare(queries_);
  }
  requireFiniteReplies();
  parts_.statistics.iterations = iteration + 1;
}

/// Iterated coupling: asks again and again, from the same state of the environment, until the answers stay as they are.
/// Afterwards the transaction holds what all iterations set, as if it was the answer to the strings before.
void AnswerPass::exchangeIterated() {
  EnvironmentLink& environment = parts_.environment;
  turtle::ReplyBatch& replies = parts_.transaction.answer().replies;
  const bool isStateful = environment.description().isStateful;
  const std::string before = isStateful ? environment.save() : std::string();
  if (isStateful && before.empty()) {
    fail({"environment '" + environment.description().name +
              "' changes from step to step and cannot give its state back. Iterated coupling asks it several times "
              "from the same state: let it save and restore, or do not iterate.",
          false});
  }
  const auto goBack = [&]() -> std::optional<turtle::EnvironmentError> {
    return isStateful ? environment.restore(before) : std::nullopt;
  };
  try {
    exchangeOnce(0);
    turtle::ReplyBatch all = replies;
    const std::vector<std::uint64_t> offsets = queryOffsets_;
    std::vector<double> sent = queries_.parameters;
    bool isSettled = hasSettled(sent, replies);
    for (std::uint32_t iteration = 1; iteration < parts_.options.coupling.iterations && !isSettled; ++iteration) {
      if (const auto error = goBack()) {
        fail(*error);
      }
      // the same pass over strings that hold the answers
      parts_.transaction.takeBack(parts_.population.states());
      writeReplies(all);
      queries_.clear();
      interpret();
      // the string is the same but for answers, which no homomorphism reads
      ESPALIER_CHECK(queryOffsets_ == offsets);
      sent = queries_.parameters;
      exchangeOnce(iteration);
      isSettled = hasSettled(sent, replies);
      for (std::size_t k = 0; k < all.values.size(); ++k) {
        if (replies.isSet[k] != 0) {
          all.values[k] = replies.values[k];
          all.isSet[k] = 1;
        }
      }
    }
    if (!isSettled) {
      warnUnsettled();
    }
    interpretAgain();
    replies = std::move(all);
  } catch (...) {
    static_cast<void>(goBack());
    throw;
  }
}

/// Interprets the strings as they were before the answers.
void AnswerPass::interpretAgain() {
  parts_.transaction.takeBack(parts_.population.states());
  queries_.clear();
  interpret();
}

/// No answer changes a parameter by more than the tolerance.
bool AnswerPass::hasSettled(const std::vector<double>& sent, const turtle::ReplyBatch& replies) const {
  for (std::size_t k = 0; k < sent.size(); ++k) {
    if (replies.isSet[k] != 0 && std::fabs(stored(replies.values[k]) - sent[k]) > parts_.options.coupling.tolerance) {
      return false;
    }
  }
  return true;
}

void AnswerPass::warnUnsettled() const {
  if (parts_.options.messages) {
    parts_.options.messages(core::MessageKind::Warning,
                            "step " + std::to_string(completedSteps_ + 1) + ": the answers of environment '" +
                                parts_.environment.description().name + "' did not settle in " +
                                std::to_string(parts_.options.coupling.iterations) + " iterations; the last are used");
  }
}

void AnswerPass::measureGeometry() {
  turtle::Scene scene;
  turtle::InterpretationOutput output;
  output.scene = &scene;
  parts_.drawing.draw(parts_.population.members(), parts_.population.states(), std::move(output));
  auto geometry = std::make_shared<turtle::Geometry>();
  const auto symbolOf = [this](std::uint32_t plant, std::uint64_t module) {
    const Population& population = parts_.population;
    const core::ModuleTypeId type = population.states()[plant].string.types()[module];
    return parts_.models.commonSymbol(population.member(plant).origin.model, population.program(plant).symbolOf[type]);
  };
  turtle::appendGeometry(std::move(scene), parts_.models.view(), symbolOf, *geometry);
  queries_.geometry = std::move(geometry);
}

void AnswerPass::requireFiniteReplies() const {
  const turtle::ReplyBatch& replies = parts_.transaction.answer().replies;
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
                      std::to_string(*error.module) + " ('" + parts_.models.symbolNames()[queries_.symbol[query]] +
                      "'): environment '" + parts_.environment.description().name + "' answered ";
      core::appendNumber(error.message, replies.values[k], core::NumberStyle::Shortest);
      error.message += " for parameter " + std::to_string(k - queries_.parameterOffset[query] + 1) + " of query " +
                       std::to_string(query) + ". Replies must be finite numbers: correct the environment.";
      throw core::SimulationFailure(std::move(error));
    }
  }
}

void AnswerPass::writeReplies(const turtle::ReplyBatch& replies) {
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
      // a query that a homomorphism made takes part, and its reply has no place in the string
      if (queryOffsets_[query] != turtle::kTransientQuery) {
        parts_.transaction.write(plant, parts_.population.states()[plant], queries_.module[query],
                                 queryOffsets_[query] + (k - begin), stored(replies.values[k]));
      }
    }
    parts_.statistics.answers += isAnswer ? 1U : 0U;
  }
  if (replies.surplusCount > 0 && !hasWarnedOfSurplus_ && parts_.options.messages) {
    hasWarnedOfSurplus_ = true;
    parts_.options.messages(core::MessageKind::Warning,
                            "environment '" + parts_.environment.description().name + "' gave " +
                                std::to_string(replies.surplusCount) +
                                " more values than the communication modules have parameters; they are dropped. "
                                "(This is said once.)");
  }
  for (const std::string& note : replies.notes) {
    if (parts_.options.messages && said_.size() < core::DiagnosticList::kLimit && said_.insert(note).second) {
      parts_.options.messages(core::MessageKind::Warning, note);
    }
  }
}

void AnswerPass::fail(const turtle::EnvironmentError& error) const {
  throw core::SimulationFailure(environmentFailure(error, completedSteps_ + 1));
}

}  // namespace espalier::simulation
