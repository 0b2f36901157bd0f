#include "engine/turtle/interpretation/parted_interpretation.h"

#include <algorithm>
#include <new>
#include <optional>
#include <utility>

#include "engine/core/worker_team.h"

namespace espalier::turtle {
namespace {

constexpr std::uint64_t kSmallestString = 50'000;  // modules; below this threads cost more than they save
constexpr std::uint64_t kSmallestBranch = 1'000;   // modules of a branch that is worth an output of its own
constexpr std::uint64_t kBranchesPerThread = 16;   // about so many, so that no thread waits long for the last one

template <typename T>
void appendRange(std::vector<T>& to, const std::vector<T>& from, std::size_t begin, std::size_t end) {
  // columns that the process does not need are empty
  if (!from.empty()) {
    to.insert(to.end(), from.begin() + static_cast<std::ptrdiff_t>(begin),
              from.begin() + static_cast<std::ptrdiff_t>(end));
  }
}

void appendOffsets(std::vector<std::uint64_t>& to, const std::vector<std::uint64_t>& from, std::size_t begin,
                   std::size_t end, std::size_t base) {
  if (from.size() <= end) {
    return;
  }
  if (to.empty()) {
    to.push_back(0);
  }
  for (std::size_t i = begin; i < end; ++i) {
    to.push_back(base + (from[i + 1] - from[begin]));
  }
}

void appendQueries(QueryBatch& to, const QueryBatch& from, std::size_t begin, std::size_t end) {
  if (begin == end) {
    return;
  }
  appendRange(to.plant, from.plant, begin, end);
  appendRange(to.module, from.module, begin, end);
  appendRange(to.symbol, from.symbol, begin, end);
  appendRange(to.isTransient, from.isTransient, begin, end);
  appendRange(to.position, from.position, begin, end);
  appendRange(to.heading, from.heading, begin, end);
  appendRange(to.left, from.left, begin, end);
  appendRange(to.up, from.up, begin, end);
  appendRange(to.width, from.width, begin, end);
  appendRange(to.scale, from.scale, begin, end);
  appendOffsets(to.parameterOffset, from.parameterOffset, begin, end, to.parameters.size());
  appendRange(to.parameters, from.parameters, from.parameterOffset[begin], from.parameterOffset[end]);
  appendRange(to.following, from.following, begin, end);
  appendRange(to.followingPair, from.followingPair, begin, end);
  appendOffsets(to.followingOffset, from.followingOffset, begin, end, to.followingParameters.size());
  if (!from.followingParameters.empty()) {
    appendRange(to.followingParameters, from.followingParameters, from.followingOffset[begin],
                from.followingOffset[end]);
  }
}

/// Interprets into a part. No exception leaves: it may run in a thread, and the caller's second attempt meets the
/// failure again.
template <typename Part, typename Walk>
void interpretInto(Part& part, const Interpretation::Subject& subject, const InterpretationOutput& whole,
                   const Walk& walk) {
  InterpretationOutput output = whole;
  output.scene = whole.scene == nullptr ? nullptr : &part.scene;
  output.queries = whole.queries == nullptr ? nullptr : &part.queries;
  output.queryParameterOffsets = whole.queryParameterOffsets == nullptr ? nullptr : &part.queryOffsets;
  // always kept, to be taken back
  output.changes = &part.changes;
  try {
    Interpretation interpretation(subject, output);
    part.isOutOfPlace = !walk(interpretation);
  } catch (const core::SimulationFailure&) {
    part.hasFailed = true;
  } catch (const std::bad_alloc&) {
    part.hasFailed = true;
  }
}

/// The subject with a thread's own Derivation, where it needs one.
Interpretation::Subject subjectOf(const Interpretation::Subject& whole, std::vector<derivation::Derivation>& expanders,
                                  unsigned thread) {
  derivation::Derivation& derivation = expanders.empty() ? whole.derivation : expanders[thread];
  return {whole.program, whole.tables, whole.reported, derivation, whole.plantState, whole.plant, whole.placement};
}

}  // namespace

void PartedInterpretation::Part::clear() {
  queries.clear();
  queryOffsets.clear();
  changes.clear();
  warnings.clear();
  scene = {};
  hasFailed = false;
  isOutOfPlace = false;
}

bool PartedInterpretation::run(const Interpretation::Subject& subject, const InterpretationOutput& output) {
  const unsigned threads = subject.derivation.options().threads;
  const bool isScene = output.scene != nullptr;
  if (threads <= 1 || output.records != nullptr || output.onModule || isScene == (output.queries != nullptr)) {
    return false;
  }
  const bool mayBeParted = isScene ? subject.tables.mayDrawApart && mayDraw_ : subject.tables.hasIndependentBranches;
  if (!mayBeParted || !findBranches(subject, threads)) {
    return false;
  }
  starts_.assign(branches_.size(), {});
  parts_.resize(std::max(parts_.size(), branches_.size()));
  clear();
  // the threads write parameters at the same time, in memory that the string shares with nobody
  if (output.fillsQueries) {
    static_cast<void>(subject.plantState.string.mutableParameters());
  }
  hasSpoken_ = false;
  Expanders expanders = makeExpanders(subject, threads);

  walkAround(subjectOf(subject, expanders, 0), output);
  std::optional<SceneAssembly> assembly;
  if (isScene) {
    assembly.emplace(*output.scene, around_.scene, starts_);
  }
  if (!around_.hasFailed && !around_.isOutOfPlace) {
    walkBranches(subject, output, expanders, threads, assembly ? &*assembly : nullptr);
  }
  const bool isTooMuch = [&] {
    std::size_t queries = around_.queries.size() + (isScene ? 0 : output.queries->size());
    for (const Part& part : parts_) {
      queries += part.queries.size();
    }
    return queries > subject.derivation.options().limits.maximumQueries;
  }();
  if (hasFailed() || isTooMuch || (assembly && !assembly->finish()) || !appendChanges(output)) {
    if (assembly) {
      assembly->takeBack();
      mayDraw_ = !isOutOfPlace();
    }
    takeBack(subject.plantState);
    clear();
    return false;
  }
  join(subject, output);
  return true;
}

void PartedInterpretation::clear() {
  std::ranges::for_each(parts_, &Part::clear);
  around_.clear();
}

/// Returns false when they are not worth threads.
bool PartedInterpretation::findBranches(const Interpretation::Subject& subject, unsigned threads) {
  const derivation::ModuleString& string = subject.plantState.string;
  if (string.size() < kSmallestString) {
    return false;
  }
  // most strings without branches are known by this, which costs a tenth of looking for the branches
  if (std::count(string.types().begin(), string.types().end(), subject.program.openBranch) < 2) {
    return false;
  }
  const std::uint64_t largest = std::max(string.size() / (threads * kBranchesPerThread), 2 * kSmallestBranch);
  branches_ = findBranchParts(subject.tables, subject.program.arity, string.types(), kSmallestBranch, largest);
  std::uint64_t covered = 0;
  for (const BranchPart& branch : branches_) {
    covered += branch.endModule - branch.firstModule;
  }
  // one thread walks the modules around the branches
  return branches_.size() >= 2 && covered >= string.size() / 2;
}

PartedInterpretation::Expanders PartedInterpretation::makeExpanders(const Interpretation::Subject& subject,
                                                                    unsigned threads) {
  Expanders expanders;
  if (!subject.tables.hasImages) {
    return expanders;
  }
  derivation::DerivationOptions options = subject.derivation.options();
  options.threads = 1;
  options.messages = [this](core::MessageKind, std::string_view) { hasSpoken_ = true; };
  for (unsigned i = 0; i < threads; ++i) {
    expanders.emplace_back(subject.program, options).beginInterpretation(subject.plantState);
  }
  return expanders;
}

void PartedInterpretation::walkAround(const Interpretation::Subject& subject, const InterpretationOutput& output) {
  interpretInto(around_, subject, output, [this](Interpretation& interpretation) {
    interpretation.runAround(branches_, starts_, around_.warnings);
    return std::ranges::none_of(starts_, &Interpretation::BranchStart::isWithinShape);
  });
}

void PartedInterpretation::walkBranches(const Interpretation::Subject& subject, const InterpretationOutput& output,
                                        Expanders& expanders, unsigned threads, SceneAssembly* assembly) {
  const auto walkBranch = [&](const Interpretation::Subject& own, std::size_t i) {
    Part& part = parts_[i];
    if (assembly != nullptr) {
      part.scene = assembly->take();
    }
    interpretInto(part, own, output, [&](Interpretation& interpretation) {
      const bool isInPlace = interpretation.runBranch(branches_[i], starts_[i], part.warnings);
      if (assembly != nullptr && isInPlace) {
        assembly->add(i, std::move(part.scene));
      }
      return isInPlace;
    });
  };
  core::WorkerTeam team(threads);
  std::atomic<std::size_t> next = 0;
  team.onEveryWorker([&](unsigned worker) {
    const Interpretation::Subject own = subjectOf(subject, expanders, worker);
    for (std::size_t i = next++; i < branches_.size(); i = next++) {
      // behind a cut there is nothing to do
      if (starts_[i].isReached) {
        walkBranch(own, i);
      }
    }
  });
}

bool PartedInterpretation::hasFailed() const {
  return around_.hasFailed || isOutOfPlace() || std::ranges::any_of(parts_, &Part::hasFailed);
}

bool PartedInterpretation::isOutOfPlace() const {
  return hasSpoken_ || around_.isOutOfPlace || std::ranges::any_of(parts_, &Part::isOutOfPlace);
}

bool PartedInterpretation::appendChanges(const InterpretationOutput& output) const {
  // before anything else that may fail: the step is taken back with them
  if (output.changes == nullptr) {
    return true;
  }
  std::size_t count = output.changes->size() + around_.changes.size();
  for (const Part& part : parts_) {
    count += part.changes.size();
  }
  try {
    output.changes->reserve(count);
  } catch (const std::bad_alloc&) {
    return false;
  }
  std::size_t done = 0;
  for (std::size_t i = 0; i < branches_.size(); ++i) {
    if (starts_[i].isReached) {
      appendRange(*output.changes, around_.changes, done, starts_[i].mark.changes);
      appendRange(*output.changes, parts_[i].changes, 0, parts_[i].changes.size());
      done = starts_[i].mark.changes;
    }
  }
  appendRange(*output.changes, around_.changes, done, around_.changes.size());
  return true;
}

void PartedInterpretation::takeBack(derivation::PlantState& plantState) const {
  const auto restore = [&](const Part& part) {
    std::for_each(part.changes.rbegin(), part.changes.rend(),
                  [&](const ParameterChange& change) { plantState.string.setParameter(change.offset, change.before); });
  };
  std::for_each(parts_.begin(), parts_.end(), restore);
  restore(around_);
}

void PartedInterpretation::join(const Interpretation::Subject& subject, const InterpretationOutput& output) {
  Interpretation speaker(subject, output);
  const auto append = [&](const Part& part, const Interpretation::OutputMark& begin,
                          const Interpretation::OutputMark& end) {
    if (output.queries != nullptr) {
      appendQueries(*output.queries, part.queries, begin.queries, end.queries);
    }
    if (output.queryParameterOffsets != nullptr) {
      appendRange(*output.queryParameterOffsets, part.queryOffsets, begin.queries, end.queries);
    }
    for (std::size_t i = begin.warnings; i < end.warnings; ++i) {
      speaker.warnOnce(part.warnings[i]);
    }
  };
  const auto wholeOf = [](const Part& part) {
    return Interpretation::OutputMark{part.queries.size(), part.changes.size(), part.warnings.size()};
  };
  Interpretation::OutputMark done;
  for (std::size_t i = 0; i < branches_.size(); ++i) {
    if (starts_[i].isReached) {
      append(around_, done, starts_[i].mark);
      append(parts_[i], {}, wholeOf(parts_[i]));
      done = starts_[i].mark;
    }
  }
  append(around_, done, wholeOf(around_));
  Drawing(output.scene, subject.program.view, subject.plant).finish();
  around_.scene = {};
}

}  // namespace espalier::turtle
