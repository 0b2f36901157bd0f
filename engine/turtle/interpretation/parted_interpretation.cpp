#include "engine/turtle/interpretation/parted_interpretation.h"

#include <algorithm>
#include <new>
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
  output.queries = &part.queries;
  output.queryParameterOffsets = whole.queryParameterOffsets == nullptr ? nullptr : &part.queryOffsets;
  // always kept, to be taken back
  output.changes = &part.changes;
  try {
    Interpretation interpretation(subject, output);
    walk(interpretation);
  } catch (const core::SimulationFailure&) {
    part.hasFailed = true;
  } catch (const std::bad_alloc&) {
    part.hasFailed = true;
  }
}

}  // namespace

void PartedInterpretation::Part::clear() {
  queries.clear();
  queryOffsets.clear();
  changes.clear();
  warnings.clear();
  hasFailed = false;
}

bool PartedInterpretation::run(const Interpretation::Subject& subject, const InterpretationOutput& output) {
  const unsigned threads = subject.derivation.options().threads;
  const derivation::ModuleString& string = subject.plantState.string;
  const bool isQueryPass =
      output.queries != nullptr && output.scene == nullptr && output.records == nullptr && !output.onModule;
  if (threads <= 1 || !isQueryPass || !subject.tables.hasIndependentBranches || string.size() < kSmallestString) {
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
  if (branches_.size() < 2 || covered < string.size() / 2) {
    return false;
  }
  starts_.assign(branches_.size(), {});
  parts_.resize(std::max(parts_.size(), branches_.size()));
  std::for_each(parts_.begin(), parts_.end(), [](Part& part) { part.clear(); });
  around_.clear();
  // the threads write parameters at the same time, in memory that the string shares with nobody
  static_cast<void>(subject.plantState.string.mutableParameters());

  walkAround(subject, output);
  walkBranches(subject, output, threads);
  const bool isTooMuch = [&] {
    std::size_t queries = output.queries->size() + around_.queries.size();
    for (const Part& part : parts_) {
      queries += part.queries.size();
    }
    return queries > subject.derivation.options().limits.maximumQueries;
  }();
  if (hasFailed() || isTooMuch || !appendChanges(output)) {
    takeBack(subject.plantState);
    return false;
  }
  join(subject, output);
  return true;
}

void PartedInterpretation::walkAround(const Interpretation::Subject& subject, const InterpretationOutput& output) {
  interpretInto(around_, subject, output, [this](Interpretation& interpretation) {
    interpretation.runAround(branches_, starts_, around_.warnings);
  });
}

void PartedInterpretation::walkBranches(const Interpretation::Subject& subject, const InterpretationOutput& output,
                                        unsigned threads) {
  core::WorkerTeam team(threads);
  team.forEach(branches_.size(), [&](std::size_t i) {
    // behind a cut or a failure there is nothing to do
    if (starts_[i].isReached) {
      interpretInto(parts_[i], subject, output, [this, i](Interpretation& interpretation) {
        interpretation.runBranch(branches_[i], starts_[i], parts_[i].warnings);
      });
    }
  });
}

bool PartedInterpretation::hasFailed() const {
  return around_.hasFailed ||
         std::any_of(parts_.begin(), parts_.end(), [](const Part& part) { return part.hasFailed; });
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
  const auto parameters = plantState.string.mutableParameters();
  const auto restore = [&](const Part& part) {
    std::for_each(part.changes.rbegin(), part.changes.rend(),
                  [&](const ParameterChange& change) { parameters[change.offset] = change.before; });
  };
  std::for_each(parts_.begin(), parts_.end(), restore);
  restore(around_);
}

void PartedInterpretation::join(const Interpretation::Subject& subject, const InterpretationOutput& output) {
  Interpretation speaker(subject, output);
  const auto append = [&](const Part& part, const Interpretation::OutputMark& begin,
                          const Interpretation::OutputMark& end) {
    appendQueries(*output.queries, part.queries, begin.queries, end.queries);
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
}

}  // namespace espalier::turtle
