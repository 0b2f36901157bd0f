#include "engine/turtle/interpretation/record_chain_builder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace espalier::turtle {
namespace {

constexpr int kTries = 8;  // stretches that begin with a turtle like this, looked at more closely
// groups that are searched before all are, and modules that are interpreted meanwhile: most changes are small
constexpr std::size_t kNearGroups = 4;
constexpr std::uint64_t kNearModules = 4096;
constexpr std::uint32_t kNoEntry = 0xFFFFFFFF;
// a group that follows joins the stretches before it when they are no more together: there are few small groups
constexpr std::size_t kJoinedStretches = 48;

template <typename T>
bool haveSameBytes(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

bool haveSameBits(const core::Frame& a, const core::Frame& b) {
  return haveSameBytes(a.heading, b.heading) && haveSameBytes(a.left, b.left) && haveSameBytes(a.up, b.up);
}

/// Whether a turtle does the same as another. Records only name parents: it matters whether there is one.
bool isSame(const TurtleState& a, const TurtleState& b) {
  const auto numbersOf = [](const TurtleState& s) {
    return std::array{s.width,           s.scale, s.oldElasticity, s.startTangent, s.endTangent, s.startRadiusTangent,
                      s.endRadiusTangent};
  };
  const auto countsOf = [](const TurtleState& s) {
    return std::array<std::uint32_t, 9>{s.branchOrder,
                                        static_cast<std::uint32_t>(s.colour),
                                        static_cast<std::uint32_t>(s.backColour),
                                        static_cast<std::uint32_t>(s.contour),
                                        static_cast<std::uint32_t>(s.contourSides),
                                        static_cast<std::uint32_t>(s.texture),
                                        s.cylinder,
                                        s.cylinderOrder,
                                        s.segment};
  };
  return haveSameBytes(a.position, b.position) && haveSameBits(a.frame, b.frame) &&
         haveSameBits(a.otherFrame, b.otherFrame) && haveSameBytes(a.previousHeading, b.previousHeading) &&
         haveSameBytes(a.previousUp, b.previousUp) && haveSameBytes(a.elasticity, b.elasticity) &&
         haveSameBytes(numbersOf(a), numbersOf(b)) && countsOf(a) == countsOf(b) &&
         a.hasSmoothRadius == b.hasSmoothRadius && (a.record == kNoParent) == (b.record == kNoParent);
}

std::uint32_t hashOf(const TurtleState& state) {
  // products that do not wait for each other
  const auto part = [](double number, std::uint64_t factor) { return std::bit_cast<std::uint64_t>(number) * factor; };
  std::uint64_t hash = part(state.position.x, 0x9E3779B97F4A7C15U) + part(state.position.y, 0xC2B2AE3D27D4EB4FU) +
                       part(state.position.z, 0x165667B19E3779F9U) + part(state.frame.heading.x, 0xD6E8FEB86659FD93U) +
                       part(state.frame.heading.y, 0xA0761D6478BD642FU) +
                       part(state.frame.heading.z, 0xE7037ED1A0B428DBU) + part(state.frame.up.x, 0x8EBC6AF09C88C6E3U) +
                       state.branchOrder;
  hash = (hash ^ hash >> 32U) * 0x9E3779B97F4A7C15U;
  return static_cast<std::uint32_t>(hash >> 32U);
}

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
                                       const std::function<void(std::span<TurtleRecord>)>& rename, RecordChain& chain,
                                       std::uint64_t stretchModules)
    : string_(subject.plantState.string),
      base_(base),
      rename_(rename),
      chain_(chain),
      stretchModules_(stretchModules),
      groups_(string_, chain),
      output_{.records = &records_, .fillsQueries = false},
      interpretation_(subject, output_),
      recordCount_(chain.recordCount) {
  const std::shared_ptr<const derivation::StringMark> mark = subject.plantState.string.marked();
  chain_.marks.resize(subject.plant + std::size_t{1});
  chain_.marks[subject.plant] = mark;
  if (base_ != nullptr) {
    next_.link = base_->firstLink[subject.plant];
    end_ = base_->firstLink[subject.plant + 1U];
    if (subject.plant < base_->marks.size() && base_->marks[subject.plant] != nullptr) {
      kept_ = derivation::keptModules(*base_->marks[subject.plant], mark, string_.size());
    }
  }
}

void RecordChainBuilder::appendPlant() {
  interpretation_.begin();
  interpretation_.noteIn(&notes_);
  while (module_ < string_.size()) {
    if (isKnown() && next_.stretch == 0 && groupFollows()) {
      takeGroup();
    } else if (isKnown() && stretchFollows(next_)) {
      takeStretch();
    } else if (!isKnown() || !findNext()) {
      interpret();
    }
  }
  groups_.finish();
  interpretation_.end();
}

bool RecordChainBuilder::groupFollows() {
  const RecordChain::Link& link = base_->links[next_.link];
  const RecordGroup& group = *link.group;
  return follows(group.passage, link.firstModule, group.types.data(), group.parameters.data());
}

bool RecordChainBuilder::stretchFollows(const Place& place) {
  const RecordGroup& group = *base_->links[place.link].group;
  const RecordGroup::Link& link = group.links[place.stretch];
  return follows(link.stretch->passage, base_->links[place.link].firstModule + link.firstModule,
                 group.types.data() + link.firstModule, group.parameters.data() + link.firstOffset);
}

bool RecordChainBuilder::areKept(std::uint64_t baseModule, std::uint64_t modules) {
  while (nextKept_ < kept_.size() && kept_[nextKept_].to + kept_[nextKept_].modules <= module_) {
    ++nextKept_;
  }
  if (nextKept_ == kept_.size() || kept_[nextKept_].to > module_) {
    return false;
  }
  const derivation::KeptModules& kept = kept_[nextKept_];
  return module_ - kept.to == baseModule - kept.from && module_ + modules <= kept.to + kept.modules;
}

bool RecordChainBuilder::follows(const TurtlePassage& passage, std::uint64_t baseModule,
                                 const core::ModuleTypeId* types, const double* parameters) {
  if (module_ + passage.modules > string_.size() ||
      (passage.endsString && module_ + passage.modules != string_.size()) ||
      offset_ + passage.parameters > string_.parameterCount() || !isSame(passage.entry, interpretation_.state())) {
    return false;
  }
  const std::vector<TurtleState>& open = interpretation_.openBranches();
  if (open.size() < passage.closed.size()) {
    return false;
  }
  const bool closesTheSame = std::equal(passage.closed.begin(), passage.closed.end(), open.rbegin(), isSame);
  if (!closesTheSame || areKept(baseModule, passage.modules)) {
    return closesTheSame;
  }
  return std::memcmp(types, string_.types().data() + module_, passage.modules * sizeof *types) == 0 &&
         (passage.parameters == 0 ||
          std::memcmp(parameters, string_.parameters().data() + offset_, passage.parameters * sizeof *parameters) == 0);
}

bool RecordChainBuilder::findNext() {
  if (next_.link >= tableEnd_) {
    buildTable(std::min(end_, next_.link + kNearGroups));
  } else if (tableEnd_ < end_ && module_ - takenEnd_ >= kNearModules) {
    buildTable(end_);
  }
  const std::uint32_t hash = hashOf(interpretation_.state());
  std::uint32_t& head = heads_[hash & (heads_.size() - 1)];
  // those that were passed are never looked at again
  const std::size_t passed = (next_.link - tableBegin_) * kMostStretches + next_.stretch;
  while (head != kNoEntry && head < passed) {
    head = following_[head];
  }
  std::uint32_t entry = head;
  for (int tries = 0; entry != kNoEntry && tries < kTries; ++tries) {
    const Place place = placeOf(entry);
    if (base_->links[place.link].group->links[place.stretch].entryHash == hash && stretchFollows(place)) {
      next_ = place;
      return true;
    }
    entry = following_[entry];
  }
  return false;
}

void RecordChainBuilder::buildTable(std::size_t end) {
  tableBegin_ = next_.link;
  tableEnd_ = end;
  std::size_t stretches = 0;
  for (std::size_t link = tableBegin_; link < tableEnd_; ++link) {
    stretches += base_->links[link].group->links.size();
  }
  heads_.assign(std::bit_ceil(2 * stretches + 2), kNoEntry);
  following_.resize((tableEnd_ - tableBegin_) * kMostStretches);
  // nearer stretches come before farther ones
  for (std::size_t link = tableEnd_; link-- > tableBegin_;) {
    const std::vector<RecordGroup::Link>& parts = base_->links[link].group->links;
    for (std::size_t i = parts.size(); i-- > 0;) {
      const auto entry = static_cast<std::uint32_t>((link - tableBegin_) * kMostStretches + i);
      following_[entry] = std::exchange(heads_[parts[i].entryHash & (heads_.size() - 1)], entry);
    }
  }
}

RecordChainBuilder::Place RecordChainBuilder::placeOf(std::uint32_t entry) const {
  return {tableBegin_ + entry / kMostStretches, entry % kMostStretches};
}

std::uint32_t RecordChainBuilder::resolved(std::uint32_t number) const {
  if (number == kNoParent) {
    return kNoParent;
  }
  return number >= kOuterRecord ? notes_.outer[number - kOuterRecord] : recordCount_ + number;
}

void RecordChainBuilder::append(std::shared_ptr<const RecordStretch> stretch, std::uint32_t entryHash) {
  recordCount_ += stretch->passage.records;
  groups_.add(std::move(stretch), entryHash, notes_.outer);
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
  takenEnd_ = module_;
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
  const std::vector<RecordGroup::Link>& parts = base_->links[next_.link].group->links;
  const RecordGroup::Link& link = parts[next_.stretch];
  pass(link.stretch->passage);
  append(link.stretch, link.entryHash);
  next_ = next_.stretch + 1 < parts.size() ? Place{next_.link, next_.stretch + 1} : Place{next_.link + 1, 0};
}

void RecordChainBuilder::interpret() {
  const std::uint64_t first = module_;
  const std::uint64_t firstOffset = offset_;
  std::vector<TurtleState>& open = interpretation_.openBranches();
  TurtleState& state = interpretation_.state();
  const auto stretch = std::make_shared<RecordStretch>();
  TurtlePassage& passage = stretch->passage;
  const std::uint32_t entryHash = hashOf(state);
  notes_.lowest = open.size();
  notes_.closed.clear();
  notes_.outer.assign(1, state.record);
  state.record = state.record == kNoParent ? kNoParent : kOuterRecord;
  passage.entry = state;

  // up to where the base goes on, or far enough
  while (module_ < string_.size()) {
    const bool mayEnd = interpretation_.walkOne(module_, offset_);
    if (mayEnd && (module_ - first >= stretchModules_ || (isKnown() && findNext()))) {
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
  append(stretch, entryHash);
}

}  // namespace espalier::turtle
