#include "engine/turtle/interpretation/record_chain_builder.h"

#include <algorithm>
#include <utility>

namespace espalier::turtle {
namespace {

// a group that follows joins the stretches before it when they are no more together: there are few small groups
constexpr std::size_t kJoinedStretches = 48;

std::uint64_t bytesOf(const RecordStretch& stretch) {
  std::uint64_t sum = sizeof stretch +
                      (stretch.passage.closed.size() + stretch.passage.opened.size()) * sizeof stretch.passage.entry +
                      stretch.records.size() * sizeof stretch.records[0];
  for (const TurtleRecord& record : stretch.records) {
    sum += record.parameters.size() * sizeof record.parameters[0];
  }
  return sum;
}

}  // namespace

RecordChainBuilder::RecordChainBuilder(const Interpretation::Subject& subject, const RecordChain* base,
                                       const derivation::StepChanges& changes,
                                       const std::function<void(std::span<TurtleRecord>)>& rename, RecordChain& chain,
                                       std::uint64_t stretchModules)
    : string_(subject.plantState.string),
      base_(base),
      rename_(rename),
      chain_(chain),
      stretchModules_(stretchModules),
      groups_(chain),
      output_{.records = &records_, .fillsQueries = false},
      interpretation_(subject, output_),
      recordCount_(chain.recordCount) {
  if (base_ != nullptr) {
    kept_ = changes.kept();
    next_.link = base_->firstLink[subject.plant];
    end_ = base_->firstLink[subject.plant + 1U];
  }
}

void RecordChainBuilder::appendPlant() {
  interpretation_.begin();
  interpretation_.noteIn(&notes_);
  findNext();
  while (module_ < string_.size()) {
    if (nextModule_ > module_) {
      interpret();
    } else if (next_.stretch == 0 && groupFollows()) {
      takeGroup();
    } else if (stretchFollows()) {
      takeStretch();
    } else {
      // another turtle comes here
      skipStretch();
    }
    findNext();
  }
  groups_.finish();
  interpretation_.end();
}

void RecordChainBuilder::findNext() {
  nextModule_ = kNever;
  while (next_.link < end_) {
    const RecordChain::Link& link = base_->links[next_.link];
    const RecordGroup::Link& part = link.group->links[next_.stretch];
    const std::uint64_t first = link.firstModule + part.firstModule;
    while (!kept_.empty() && kept_.front().from + kept_.front().modules <= first) {
      kept_ = kept_.subspan(1);
    }
    if (kept_.empty()) {
      return;
    }
    const std::uint64_t place = placeOf(first, part.stretch->passage.modules);
    if (place != kNever && place >= module_) {
      nextModule_ = place;
      return;
    }
    skipStretch();
  }
}

void RecordChainBuilder::skipStretch() {
  const std::size_t count = base_->links[next_.link].group->links.size();
  next_ = next_.stretch + 1 < count ? Place{next_.link, next_.stretch + 1} : Place{next_.link + 1, 0};
}

std::uint64_t RecordChainBuilder::placeOf(std::uint64_t baseModule, std::uint64_t modules) const {
  const derivation::KeptModules& run = kept_.front();
  return baseModule >= run.from && baseModule + modules <= run.from + run.modules ? run.to + (baseModule - run.from)
                                                                                  : kNever;
}

bool RecordChainBuilder::groupFollows() const {
  const RecordChain::Link& link = base_->links[next_.link];
  return placeOf(link.firstModule, link.group->passage.modules) == module_ && isReached(link.group->passage);
}

bool RecordChainBuilder::stretchFollows() const {
  return isReached(base_->links[next_.link].group->links[next_.stretch].stretch->passage);
}

bool RecordChainBuilder::isReached(const TurtlePassage& passage) const {
  return passage.isSameFor(interpretation_.state(), interpretation_.openBranches(), string_.size() - module_);
}

std::uint32_t RecordChainBuilder::resolved(std::uint32_t number) const {
  if (number == kNoParent) {
    return kNoParent;
  }
  return number >= kOuterRecord ? notes_.outer[number - kOuterRecord] : recordCount_ + number;
}

void RecordChainBuilder::append(std::shared_ptr<const RecordStretch> stretch) {
  recordCount_ += stretch->passage.records;
  groups_.add(std::move(stretch), notes_.outer);
}

void RecordChainBuilder::pass(const TurtlePassage& passage) {
  std::vector<TurtleState>& open = interpretation_.openBranches();
  TurtleState& state = interpretation_.state();
  notes_.outer.assign(1, state.record);
  for (std::size_t i = 0; i < passage.closed.size(); ++i) {
    notes_.outer.push_back(open.back().record);
    open.pop_back();
  }
  state = passage.exit;
  state.record = resolved(state.record);
  for (const TurtleState& opened : passage.opened) {
    open.push_back(opened);
    open.back().record = resolved(opened.record);
  }
  module_ += passage.modules;
  offset_ += passage.parameters;
}

void RecordChainBuilder::takeGroup() {
  const std::shared_ptr<const RecordGroup>& group = base_->links[next_.link].group;
  const std::size_t waiting = groups_.waiting();
  if (waiting > 0 && waiting + group->links.size() <= kJoinedStretches) {
    const std::size_t link = next_.link;
    while (next_.link == link) {
      takeStretch();
    }
    return;
  }
  groups_.finish();
  pass(group->passage);
  chain_.links.push_back(
      {group, module_ - group->passage.modules, recordCount_, static_cast<std::uint32_t>(chain_.outer.size())});
  chain_.outer.insert(chain_.outer.end(), notes_.outer.begin(), notes_.outer.end());
  chain_.bytes += group->bytes;
  recordCount_ += group->passage.records;
  chain_.recordCount = recordCount_;
  groups_.pass(group->passage);
  ++next_.link;
}

void RecordChainBuilder::takeStretch() {
  const std::shared_ptr<const RecordStretch> stretch = base_->links[next_.link].group->links[next_.stretch].stretch;
  pass(stretch->passage);
  append(stretch);
  skipStretch();
}

void RecordChainBuilder::interpret() {
  const std::uint64_t first = module_;
  const std::uint64_t firstOffset = offset_;
  std::vector<TurtleState>& open = interpretation_.openBranches();
  TurtleState& state = interpretation_.state();
  const auto stretch = std::make_shared<RecordStretch>();
  stretch->birth = chain_.generation;
  TurtlePassage& passage = stretch->passage;
  notes_.lowest = open.size();
  notes_.closed.clear();
  notes_.outer.assign(1, state.record);
  state.record = state.record == kNoParent ? kNoParent : kOuterRecord;
  passage.entry = state;

  // up to where the base goes on, or far enough
  while (module_ < string_.size()) {
    const bool mayEnd = interpretation_.walkOne(module_, offset_);
    if (module_ > nextModule_) {
      findNext();
    }
    if (mayEnd && (module_ - first >= stretchModules_ || (module_ == nextModule_ && stretchFollows()))) {
      break;
    }
  }

  passage.closed = notes_.closed;
  passage.exit = state;
  passage.opened.assign(open.begin() + static_cast<std::ptrdiff_t>(notes_.lowest), open.end());
  passage.endsString = module_ == string_.size();
  passage.modules = module_ - first;
  passage.parameters = offset_ - firstOffset;
  passage.records = static_cast<std::uint32_t>(records_.size());
  stretch->records.assign(std::make_move_iterator(records_.begin()), std::make_move_iterator(records_.end()));
  records_.clear();
  for (TurtleRecord& record : stretch->records) {
    record.module -= first;
  }
  rename_(stretch->records);
  stretch->bytes = bytesOf(*stretch);

  // from here on records are numbered as in the whole
  state.record = resolved(state.record);
  for (auto opened = open.begin() + static_cast<std::ptrdiff_t>(notes_.lowest); opened != open.end(); ++opened) {
    opened->record = resolved(opened->record);
  }
  append(stretch);
}

}  // namespace espalier::turtle
