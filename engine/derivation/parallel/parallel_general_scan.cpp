#include "engine/derivation/parallel/parallel_general_scan.h"

#include <algorithm>
#include <utility>

#include "engine/derivation/parallel/scan_round.h"
#include "engine/derivation/parallel/shared_output.h"

namespace espalier::derivation {
namespace {

// modules of a chunk: enough to be worth taking, few enough to stay in the caches and to keep all threads at work
constexpr std::uint64_t kLeastModules = 256;
constexpr std::uint64_t kMostModules = 8192;
constexpr std::uint64_t kChunksPerThread = 8;

DerivationOptions helperOptions(const DerivationOptions& owner) {
  DerivationOptions options = owner;
  options.threads = 1;
  options.messages = nullptr;
  return options;
}

}  // namespace

/// The working data of one thread.
class ParallelGeneralScan::Helper {
 public:
  explicit Helper(const ScanContext& owner)
      : context_(owner.program, owner.tables, helperOptions(owner.options)),
        rewriter_(context_),
        plain_(context_, rewriter_),
        batch_(context_, plain_) {
    context_.evaluator.setMessages([this](core::MessageKind, std::string_view) { hasWarned_ = true; });
  }

  /// Begins the step of `owner`, with a copy of the plant's variables.
  void begin(const ScanContext& owner) {
    const PlantState& plant = *owner.plant;
    state_.step = plant.step;
    state_.derivationLength = plant.derivationLength;
    state_.isStopped = plant.isStopped;
    state_.statics = plant.statics;
    state_.instances.assign(plant.instances.begin(), plant.instances.begin() + 1);
    state_.random = plant.random;
    state_.viewVolume = plant.viewVolume;
    context_.scannedModules = owner.scannedModules;
    context_.changes = owner.changes == nullptr ? nullptr : &changes_;
    context_.attach(state_, owner.step, owner.step);
    context_.read(*owner.old, owner.index, nullptr);
  }

  /// Gives no warning that `owner` has given already, and every other one.
  void adoptWarnings(const ScanContext& owner) {
    context_.evaluator.adoptWarnings(owner.evaluator);
    context_.rewriter.adoptWarnings(owner.rewriter);
  }

  /// Scans from `place` to `end` into made(). False: something failed or warned, and made() is of no use.
  [[nodiscard]] bool scan(std::uint64_t end, ScanPlace& place) {
    context_.output.clear();
    context_.cuts.clear();
    changes_ = {};
    hasWarned_ = false;
    try {
      if (batch_.isWorthwhile(*context_.old)) {
        batch_.run(end, place);
      } else {
        plain_.run(end, place);
      }
    } catch (...) {
      // the calling thread meets the same failure, in the order of the string
      return false;
    }
    return !hasWarned_;
  }

  [[nodiscard]] const ModuleString& made() const { return context_.output; }
  [[nodiscard]] const CutParts& cuts() const { return context_.cuts; }
  /// The parts of the old string that made() holds unchanged; empty when nobody wants them.
  [[nodiscard]] const StepChanges& changes() const { return changes_; }

 private:
  PlantState state_;
  ScanContext context_;
  ModuleRewriter rewriter_;
  PlainScan plain_;
  BatchScan batch_;
  StepChanges changes_;     // of the last chunk
  bool hasWarned_ = false;  // in it
};

ParallelGeneralScan::ParallelGeneralScan(ScanContext& context, PlainScan& plain, core::WorkerTeam& team)
    : context_(&context), plain_(&plain), team_(&team), chunks_(context.program) {
  for (unsigned worker = 0; worker < team.size(); ++worker) {
    helpers_.push_back(std::make_unique<Helper>(context));
  }
}

ParallelGeneralScan::~ParallelGeneralScan() = default;

void ParallelGeneralScan::run(StringIndex* links) {
  ScanContext& context = *context_;
  const ModuleString& old = *context.old;
  chunks_.cut(old, std::clamp(old.size() / (kChunksPerThread * team_->size()), kLeastModules, kMostModules), *team_,
              links);
  for (const auto& helper : helpers_) {
    helper->begin(context);
  }
  ScanPlace place;
  for (std::uint64_t chunk = 0; chunk < chunks_.count();) {
    for (const auto& helper : helpers_) {
      helper->adoptWarnings(context);
    }
    chunk = runRound(chunk, place);
    // the chunk that stopped the round
    if (chunk < chunks_.count()) {
      context.evaluator.clearModule();
      context.evaluator.pollCancelled();
      plain_->run(std::max(chunkStart(chunk + 1).module, place.module), place);
      context.rewriter.checkSize(context.output.size(), context.output.parameterCount());
      ++chunk;
    }
  }
}

ScanPlace ParallelGeneralScan::chunkStart(std::uint64_t chunk) const {
  const std::vector<std::uint8_t>& isInside = context_->tables.front().isInside;
  const std::span<const core::ModuleTypeId> types = context_->old->types();
  ScanPlace place = chunks_.begin(chunk);
  if (chunk == 0) {
    return place;
  }
  // begin where no predecessor can reach over, if there is such a place near by
  const std::uint64_t last = std::min<std::uint64_t>(place.module + chunks_.chunkModules() / 2, types.size());
  while (place.module < last && isInside[types[place.module]] != 0) {
    place.offset += context_->program.arity[types[place.module]];
    ++place.module;
  }
  return place;
}

std::uint64_t ParallelGeneralScan::runRound(std::uint64_t firstChunk, ScanPlace& place) {
  ScanContext& context = *context_;
  ScanRound round(firstChunk, chunks_.count());
  round.modules = context.output.size();
  round.parameters = context.output.parameterCount();
  SharedOutput output(context.output);

  team_->onEveryWorker([&](unsigned worker) {
    Helper& helper = *helpers_[worker];
    const ModuleString& made = helper.made();
    std::uint64_t chunk = 0;
    try {
      while (round.take(chunk)) {
        const ScanPlace begin = chunkStart(chunk);
        const std::uint64_t end = chunkStart(chunk + 1).module;
        ScanPlace reached = begin;
        const bool isDone = helper.scan(end, reached);
        if (!round.awaitTurn(chunk)) {
          return;
        }
        // an earlier cut has removed the whole chunk
        if (place.module >= end) {
          round.passTurn(chunk);
          continue;
        }
        const std::uint64_t modules = round.modules;
        const std::uint64_t parameters = round.parameters;
        const std::uint64_t endModules = modules + made.size();
        const std::uint64_t endParameters = parameters + made.parameterCount();
        if (!isDone || place.module != begin.module || !context.isWithinLimits(endModules, endParameters) ||
            !output.holds(endModules, endParameters)) {
          round.stopAt(chunk);
          return;
        }
        place = reached;
        round.modules = endModules;
        round.parameters = endParameters;
        context.cuts.addAll(helper.cuts());
        for (const KeptModules& run : helper.changes().kept()) {
          context.changes->keep(run.from, modules + run.to, run.modules);
        }
        round.passTurn(chunk);
        output.prepare(modules, endModules, parameters, endParameters);
        std::copy_n(made.types().data(), made.size(), output.types() + modules);
        std::copy_n(made.parameters().data(), made.parameterCount(), output.parameters() + parameters);
      }
    } catch (...) {
      // the others must not wait for this chunk
      round.stopAt(chunk);
      throw;
    }
  });
  output.finish(round.modules, round.parameters);
  return round.end();
}

}  // namespace espalier::derivation
