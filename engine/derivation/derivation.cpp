#include "engine/derivation/derivation.h"

#include <algorithm>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "engine/core/check.h"
#include "engine/derivation/scan/block_runner.h"
#include "engine/derivation/scan/homomorphism.h"
#include "engine/derivation/scan/scan_context.h"
#include "engine/derivation/scan/step_scan.h"
#include "engine/derivation/scan/sub_systems.h"
#include "engine/derivation/state/plant_backup.h"

namespace espalier::derivation {
namespace {

using Block = BlockRunner::Block;

// X = 155 * 2^32 + N mod 65536: seed48({N, 0, 155}) of the reference
constexpr std::uint64_t kSelectionHigh = std::uint64_t{155} << 32U;

RandomState seededStreams(const language::Program& program, const DerivationOptions& options) {
  // the first L-system with a `seed:` item names the seed
  std::optional<std::int64_t> item;
  for (const language::LSystem& system : program.systems) {
    item = item ? item : system.seed;
  }
  RandomState random;
  random.seed = options.hasSeed || !item ? options.seed : static_cast<std::uint64_t>(*item);
  random.mainSeed = random.seed;
  if (program.compatibility == core::Compatibility::Cpfg && random.seed != 0) {
    random.selection.setState(kSelectionHigh + (random.seed & 0xFFFFU));
  }
  return random;
}

}  // namespace

/// The parts of a step, and the outline of a step and of a rewind.
class Derivation::Implementation {
 public:
  Implementation(const language::Program& program, DerivationOptions options)
      : program_(program),
        tables_(makeSystemTables(program)),
        context_(program, tables_, std::move(options)),
        blocks_(context_),
        calls_(context_, blocks_),
        scan_(context_, calls_),
        homomorphism_(context_, blocks_, calls_) {
    ESPALIER_CHECK(!program.systems.empty());
  }

  void setSeed(std::uint64_t seed) {
    context_.options.seed = seed;
    context_.options.hasSeed = true;
  }
  void rewind(PlantState& state, const ModuleString* start);
  void derive(PlantState& state, StepChanges* changes, ProductionCounts* counts, ModuleOrigins* origins);
  void deriveRecorded(PlantState& state, ModuleRecord& record);
  void ownParameters(PlantState& state) { context_.rotation.ownParameters(state.string); }
  void beginInterpretation(PlantState& state);
  void endInterpretation() { context_.random.usePrivateStream(false); }
  [[nodiscard]] Homomorphism& homomorphism() { return homomorphism_; }
  [[nodiscard]] const DerivationOptions& options() const { return context_.options; }

 private:
  void attach(PlantState& state, std::uint64_t step, std::uint64_t failingStep);
  void requireArity() const;
  void runStep(PlantState& state);

  const language::Program& program_;
  std::vector<SystemTables> tables_;  // by L-system
  ScanContext context_;
  BlockRunner blocks_;
  SubSystems calls_;
  StepScan scan_;
  Homomorphism homomorphism_;
  PlantBackup backup_;  // of the plant before the step
};

void Derivation::Implementation::attach(PlantState& state, std::uint64_t step, std::uint64_t failingStep) {
  context_.attach(state, step, failingStep);
  calls_.begin();
}

void Derivation::Implementation::derive(PlantState& state, StepChanges* changes, ProductionCounts* counts,
                                        ModuleOrigins* origins) {
  ESPALIER_CHECK(!state.instances.empty());
  // homomorphism does not count
  struct Counting {
    ScanContext& context;
    ~Counting() {
      context.isCounted = false;
      context.origins = nullptr;
      context.rewriter.setCounts(nullptr);
    }
  };
  context_.isCounted = counts != nullptr;
  context_.origins = origins;
  context_.rewriter.setCounts(counts);
  const Counting counting{context_};
  if (changes != nullptr) {
    changes->clear();
  }
  context_.changes = changes;
  if (origins != nullptr) {
    origins->clear();
  }
  backup_.save(state);
  try {
    runStep(state);
    if (origins != nullptr) {
      origins->complete(state.string.size());
    }
  } catch (const std::bad_alloc&) {
    backup_.restore(state);
    context_.output.clear();
    context_.evaluator.clearModule();
    context_.evaluator.failHere(core::SimulationErrorCode::LimitExceeded, "there is not enough memory for the string");
  } catch (...) {
    backup_.restore(state);
    context_.output.clear();
    throw;
  }
}

void Derivation::Implementation::runStep(PlantState& state) {
  // the step's number, and the plant that blocks and productions change
  const language::LSystem& system = program_.systems.front();
  const std::uint64_t step = state.step + 1;
  attach(state, step, step);

  // StartEach
  blocks_.run(system.startEach, Block::StartEach, 0);

  // every module of the old string becomes modules of the new one
  scan_.run();

  // EndEach
  context_.evaluator.enter(state.instances.front());
  blocks_.run(system.endEach, Block::EndEach, 0);

  // End, in the last step; a caller that goes on beyond it does not run End again
  if (step == state.derivationLength || (state.isStopped && step < state.derivationLength)) {
    calls_.endAll(context_.output);
    blocks_.run(system.end, Block::End, 0);
    state.isStopped = true;
  }

  // the new string takes the place of the old one
  state.step = step;
  scan_.swapStrings();
}

void Derivation::Implementation::deriveRecorded(PlantState& state, ModuleRecord& record) {
  // the context forgets the caller's record even when the model fails
  struct Recording {
    ScanContext& context;
    ~Recording() {
      context.record = nullptr;
      context.rewriter.setRecord(nullptr);
    }
  };
  context_.record = &record;
  const Recording recording{context_};
  derive(state, nullptr, nullptr, nullptr);
}

void Derivation::Implementation::rewind(PlantState& state, const ModuleString* start) {
  // a run from the beginning says again what the run before it has said
  context_.evaluator.forgetWarnings();
  context_.rewriter.forgetWarnings();

  // a failure leaves the old state as it is, because everything is made in a fresh one
  PlantState fresh;
  fresh.derivationLength = options().derivationLength.value_or(program_.derivationLength);
  fresh.statics.assign(program_.staticCount, 0.0);
  fresh.random = seededStreams(program_, options());
  fresh.instances.push_back(makeInstance(program_, 0));
  attach(fresh, 0, 0);
  requireArity();

  // Start
  blocks_.run(program_.systems.front().start, Block::Start, 0);
  fresh.instances.front().hasStarted = true;

  // the axiom
  if (start != nullptr) {
    fresh.string = *start;
  } else {
    blocks_.appendAxiom(fresh.string);
  }
  context_.rewriter.checkSize(fresh.string.size(), fresh.string.parameterCount());
  calls_.addInstances(fresh.string, fresh.instances);
  state = std::move(fresh);
}

void Derivation::Implementation::requireArity() const {
  const std::uint32_t limit = options().limits.maximumArity;
  const auto tooLong = std::find_if(program_.arity.begin(), program_.arity.end(),
                                    [limit](std::uint16_t arity) { return arity > limit; });
  if (tooLong != program_.arity.end()) {
    const auto type = static_cast<core::ModuleTypeId>(tooLong - program_.arity.begin());
    context_.evaluator.failHere(core::SimulationErrorCode::LimitExceeded,
                                "the module '" + std::string(program_.nameOf(type)) + "' has " +
                                    std::to_string(*tooLong) + " parameters, more than " + std::to_string(limit) +
                                    " (limit arity)");
  }
}

void Derivation::Implementation::beginInterpretation(PlantState& state) {
  attach(state, state.step, state.step + 1);
  homomorphism_.begin(state);
}

Derivation::Derivation(const language::Program& program, DerivationOptions options)
    : implementation_(std::make_unique<Implementation>(program, std::move(options))) {}
Derivation::~Derivation() = default;
Derivation::Derivation(Derivation&&) noexcept = default;
Derivation& Derivation::operator=(Derivation&&) noexcept = default;

void Derivation::setSeed(std::uint64_t seed) {
  implementation_->setSeed(seed);
}
void Derivation::rewind(PlantState& state, const ModuleString* start) {
  implementation_->rewind(state, start);
}
void Derivation::derive(PlantState& state, StepChanges* changes, ProductionCounts* counts, ModuleOrigins* origins) {
  implementation_->derive(state, changes, counts, origins);
}
void Derivation::ownParameters(PlantState& state) {
  implementation_->ownParameters(state);
}
void Derivation::deriveRecorded(PlantState& state, ModuleRecord& record) {
  implementation_->deriveRecorded(state, record);
}
bool Derivation::hasHomomorphism() const {
  return implementation_->homomorphism().hasProductions();
}
void Derivation::beginInterpretation(PlantState& state) {
  implementation_->beginInterpretation(state);
}
std::uint64_t Derivation::expand(PlantState& state, std::uint32_t instance, std::uint64_t module,
                                 std::uint64_t parameterOffset, ModuleString& image) {
  return implementation_->homomorphism().expand(state, instance, module, parameterOffset, image);
}
void Derivation::endInterpretation(PlantState& state) {
  static_cast<void>(state);
  implementation_->endInterpretation();
}
const DerivationOptions& Derivation::options() const {
  return implementation_->options();
}

}  // namespace espalier::derivation
