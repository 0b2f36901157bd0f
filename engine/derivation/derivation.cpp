#include "engine/derivation/derivation.h"

#include <algorithm>
#include <new>
#include <string>
#include <thread>
#include <utility>

#include "engine/core/check.h"
#include "engine/derivation/implementation.h"

namespace espalier::derivation {
namespace {

// X = 155 * 2^32 + N mod 65536: seed48({N, 0, 155}) of the reference
constexpr std::uint64_t kSelectionHigh = std::uint64_t{155} << 32U;

// more threads than this wait for the memory and for each other
constexpr unsigned kMostThreads = 64;

Evaluator::Options evaluatorOptions(const DerivationOptions& options) {
  return {options.plant, options.limits, options.cancelled, options.messages, options.canWriteFiles};
}

bool hasContext(const language::ProductionList& list) {
  return std::any_of(list.productions.begin(), list.productions.end(), [](const language::Production& production) {
    return !production.leftContext.empty() || !production.rightContext.empty();
  });
}

}  // namespace

Derivation::Implementation::Implementation(const language::Program& program, DerivationOptions options)
    : program_(&program),
      options_(std::move(options)),
      random_(program.compatibility, options_.plant),
      evaluator_(program, random_, evaluatorOptions(options_)),
      rewriter_(program, evaluator_, random_, options_.limits),
      calls_(program, evaluator_),
      tables_(makeSystemTables(program)),
      cutWithTurtle_(program.findType("%", 1)),
      keptCut_(program.findType("%", 2)),
      threadCount_(options_.threads == 0 ? std::min(std::max(std::thread::hardware_concurrency(), 1U), kMostThreads)
                                         : std::min(options_.threads, kMostThreads)),
      parameterSum_({program.arity.begin(), program.arity.end()}),
      index_(program),
      frame_(program.maximumSlots + std::size_t{1}, 0.0) {
  ESPALIER_CHECK(!program.systems.empty());
  for (const language::LSystem& system : program.systems) {
    hasHomomorphism_ = hasHomomorphism_ || !system.homomorphism.productions.empty();
    hasHomomorphismContexts_ = hasHomomorphismContexts_ || hasContext(system.homomorphism);
  }
  for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
    const auto type = static_cast<core::ModuleTypeId>(i);
    hasParameters_ = hasParameters_ || program.arity[type] > 0;
    if (program.arity[type] > options_.limits.maximumArity) {
      tooLong_.push_back(type);
    }
  }
  if (program.hasSubSystems) {
    isCall_.resize(program.moduleTypeCount(), 0);
    std::vector<std::uint8_t> isBarrier(program.moduleTypeCount(), 0);
    for (std::size_t i = 0; i < program.moduleTypeCount(); ++i) {
      const auto type = static_cast<core::ModuleTypeId>(i);
      isCall_[type] = isCall(program, type) ? 1 : 0;
      isBarrier[type] = isCall_[type] != 0 || type == program.subSystemEnd ? 1 : 0;
    }
    rewriter_.setBarriers(std::move(isBarrier));
  }
}

void Derivation::Implementation::Backup::save(const PlantState& state) {
  step = state.step;
  derivationLength = state.derivationLength;
  isStopped = state.isStopped;
  statics = state.statics;
  instances = state.instances;
  random = state.random;
  files = state.files;
}

void Derivation::Implementation::Backup::restore(PlantState& state) const {
  state.step = step;
  state.derivationLength = derivationLength;
  state.isStopped = isStopped;
  state.statics = statics;
  state.instances = instances;
  state.random = random;
  state.files = files;
}

void Derivation::Implementation::attach(PlantState& state, std::uint64_t step, std::uint64_t failingStep) {
  step_ = step;
  evaluator_.attach(state);
  evaluator_.setStep(step, failingStep);
  evaluator_.clearModule();
  random_.attach(state.random);
  calls_.reset(state.instances);
}

void Derivation::Implementation::runBlock(language::CodeRange code, Block block, std::uint32_t instance) {
  if (code.empty()) {
    return;
  }
  evaluator_.clearModule();
  random_.key(core::DrawDomain::Blocks, step_, static_cast<std::uint64_t>(block) + std::uint64_t{8} * instance);
  evaluator_.run(code, frame_.data());
}

void Derivation::Implementation::seedStreams(RandomState& random) const {
  // the first L-system with a `seed:` item names the seed
  std::optional<std::int64_t> item;
  for (const language::LSystem& system : program_->systems) {
    if (!item && system.seed) {
      item = system.seed;
    }
  }
  if (options_.hasSeed || !item) {
    random.seed = options_.seed;
  } else {
    random.seed = static_cast<std::uint64_t>(*item);
  }
  random.mainSeed = random.seed;
  if (program_->compatibility == core::Compatibility::Cpfg && random.seed != 0) {
    random.selection.setState(kSelectionHigh + (random.seed & 0xFFFFU));
  }
}

void Derivation::Implementation::failArity(core::ModuleTypeId type) const {
  evaluator_.failHere(core::SimulationErrorCode::LimitExceeded,
                      "the module '" + std::string(program_->nameOf(type)) + "' has " +
                          std::to_string(program_->arity[type]) + " parameters, more than " +
                          std::to_string(options_.limits.maximumArity) + " (limit maximumArity)");
}

void Derivation::Implementation::rewind(PlantState& state, const ModuleString* start) {
  // everything is made in a fresh state, so that a failure leaves the old one as it is
  PlantState fresh;
  fresh.derivationLength = options_.derivationLength.value_or(program_->derivationLength);
  fresh.statics.assign(program_->staticCount, 0.0);
  seedStreams(fresh.random);
  fresh.instances.push_back(makeInstance(*program_, 0));
  attach(fresh, 0, 0);
  if (!tooLong_.empty()) {
    failArity(tooLong_.front());
  }

  // Start, then the axiom
  const language::LSystem& system = program_->systems.front();
  runBlock(system.start, Block::Start, 0);
  fresh.instances.front().hasStarted = true;
  if (start != nullptr) {
    fresh.string = *start;
  } else {
    appendAxiom(fresh.string);
  }
  rewriter_.checkSize(fresh.string.size(), fresh.string.parameterCount());
  addCallsOf(fresh.string, fresh.instances);
  state = std::move(fresh);
}

void Derivation::Implementation::appendAxiom(ModuleString& string) {
  const language::LSystem& system = program_->systems.front();
  random_.key(core::DrawDomain::Blocks, step_, static_cast<std::uint64_t>(Block::Axiom));
  std::vector<double> parameters;
  for (const language::SuccessorModule& module : system.axiom) {
    parameters.clear();
    for (std::size_t i = 0; i < program_->arity[module.type]; ++i) {
      const language::Expression& expression = system.axiomExpressions[module.firstExpression + i];
      parameters.push_back(rewriter_.stored(evaluator_.value(expression, frame_.data()), expression, i, module.type));
    }
    string.append(module.type, parameters);
  }
}

void Derivation::Implementation::derive(PlantState& state) {
  ESPALIER_CHECK(!state.instances.empty());
  backup_.save(state);
  try {
    runStep(state);
  } catch (const std::bad_alloc&) {
    backup_.restore(state);
    working_.clear();
    evaluator_.clearModule();
    evaluator_.failHere(core::SimulationErrorCode::LimitExceeded, "the memory for the string could not be had");
  } catch (...) {
    backup_.restore(state);
    working_.clear();
    throw;
  }
}

void Derivation::Implementation::runStep(PlantState& state) {
  const language::LSystem& system = program_->systems.front();
  // counter
  const std::uint64_t step = state.step + 1;
  attach(state, step, step);

  runBlock(system.startEach, Block::StartEach, 0);
  scan(state);
  evaluator_.enter(state.instances.front());
  runBlock(system.endEach, Block::EndEach, 0);

  // the last step; a caller that goes on beyond it does not run End again
  if (step == state.derivationLength || (state.isStopped && step < state.derivationLength)) {
    endAllCalls(state);
    runBlock(system.end, Block::End, 0);
    state.isStopped = true;
  }
  state.step = step;
  state.string.swap(working_);
  state.string.setMark(keptModules_.finish());
  isWorkingIndexed_ = isOldIndexed_;
}

bool Derivation::Implementation::needsIndex(const language::LSystem& system) const {
  return hasContext(system.productions) || hasContext(system.decomposition);
}

void Derivation::Implementation::buildIndex(const ModuleString& string) {
  isWorkingIndexed_ = false;
  index_.clear();
  index_.extend(string);
}

void Derivation::Implementation::beginInterpretation(PlantState& state) {
  attach(state, state.step, state.step + 1);
  shortcuts_.clear();
  if (!hasHomomorphism_) {
    return;
  }
  if (hasHomomorphismContexts_) {
    buildIndex(state.string);
  }
  if (program_->hasSubSystems) {
    findParents(state.string);
  }
  for (const language::LSystem& system : program_->systems) {
    if (system.homomorphismSeed && *system.homomorphismSeed >= 0.0) {
      random_.startPrivateStream(*system.homomorphismSeed);
      break;
    }
  }
}

void Derivation::Implementation::findParents(const ModuleString& string) {
  parents_.assign(1, 0);
  chain_.assign(1, 0);
  for (const core::ModuleTypeId type : string.types()) {
    if (isCall_[type] != 0) {
      parents_.push_back(chain_.back());
      chain_.push_back(static_cast<std::uint32_t>(parents_.size() - 1));
    } else if (type == program_->subSystemEnd && chain_.size() > 1) {
      chain_.pop_back();
    }
  }
}

std::uint64_t Derivation::Implementation::expand(PlantState& state, std::uint32_t instance, std::uint64_t module,
                                                 std::uint64_t parameterOffset, ModuleString& image) {
  const core::ModuleTypeId type = state.string.types()[module];
  const language::LSystem& system = program_->systems[state.instances[instance].system];
  const language::ProductionList& list = system.homomorphism;
  if (list.index.empty() || list.maximumDepth == 0 || list.index.candidates(type).empty()) {
    return 0;
  }

  // the L-systems around the module
  if (instance != 0) {
    chain_.clear();
    for (std::uint32_t i = instance; i != 0; i = parents_[i]) {
      chain_.push_back(i);
    }
    for (auto i = chain_.rbegin(); i != chain_.rend(); ++i) {
      calls_.push(*i);
    }
    InstanceState& active = calls_.state();
    if (!active.hasStarted) {
      active.hasStarted = true;
      runBlock(system.start, Block::Start, instance);
    }
  }

  // contexts follow the rules of the main L-system
  const ModuleString& string = state.string;
  rewriter_.setStrings({string.types().data(), string.parameters().data(), string.size(), string.parameterCount(),
                        &index_, true, &shortcuts_},
                       nullptr);
  const ContextRules& rules = tables_.front().rules;
  const PredecessorPlace place{string.types().data(), string.parameters().data(), string.size(), module,
                               parameterOffset};
  Surroundings surroundings{module, parameterOffset, 0, 0, true};
  const bool hasOwnStream = system.homomorphismSeed && *system.homomorphismSeed >= 0.0;
  evaluator_.setModule(module, type);
  random_.key(core::DrawDomain::Interpretation, hasOwnStream ? 0 : step_, module);
  std::uint64_t consumed = 0;
  if (const language::Production* production = rewriter_.chooseFirst(list, rules, place, surroundings)) {
    consumed = production->predecessor.size();
    surroundings.right = module + consumed;
    surroundings.rightOffset = parameterOffset + rewriter_.parameterCount(*production);
    surroundings.isBehindPredecessor = false;
    // the private stream must be put back even when the model fails
    struct PrivateStream {
      RandomSource& random;
      PrivateStream(RandomSource& source, bool isUsed) : random(source) { random.usePrivateStream(isUsed); }
      PrivateStream(const PrivateStream&) = delete;
      PrivateStream& operator=(const PrivateStream&) = delete;
      ~PrivateStream() { random.usePrivateStream(false); }
    };
    const PrivateStream stream(random_, hasOwnStream);
    rewriter_.applyNested(*production, list, rules, surroundings, 1, true, core::DrawDomain::Interpretation, step_,
                          module, image);
  }
  while (calls_.depth() > 1) {
    calls_.pop();
  }
  return consumed;
}

void Derivation::Implementation::endInterpretation() {
  random_.usePrivateStream(false);
}

Derivation::Derivation(const language::Program& program, DerivationOptions options)
    : implementation_(std::make_unique<Implementation>(program, std::move(options))) {}
Derivation::~Derivation() = default;
Derivation::Derivation(Derivation&&) noexcept = default;
Derivation& Derivation::operator=(Derivation&&) noexcept = default;

void Derivation::rewind(PlantState& state, const ModuleString* start) {
  implementation_->rewind(state, start);
}
void Derivation::derive(PlantState& state) {
  implementation_->derive(state);
}
void Derivation::deriveRecorded(PlantState& state, ModuleRecord& record) {
  implementation_->deriveRecorded(state, record);
}
bool Derivation::hasHomomorphism() const {
  return implementation_->hasHomomorphism();
}
void Derivation::beginInterpretation(PlantState& state) {
  implementation_->beginInterpretation(state);
}
std::uint64_t Derivation::expand(PlantState& state, std::uint32_t instance, std::uint64_t module,
                                 std::uint64_t parameterOffset, ModuleString& image) {
  return implementation_->expand(state, instance, module, parameterOffset, image);
}
void Derivation::endInterpretation(PlantState& state) {
  static_cast<void>(state);
  implementation_->endInterpretation();
}
const DerivationOptions& Derivation::options() const {
  return implementation_->options();
}

}  // namespace espalier::derivation
