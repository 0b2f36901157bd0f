#include "engine/turtle/record_chain_builder.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace espalier::turtle {
namespace {

constexpr std::uint64_t kStretchModules = 128;  // about so many: fewer cost states, more are interpreted for one change
constexpr int kTries = 8;                       // links that begin with a turtle like this, looked at more closely
constexpr std::uint32_t kNoLink = 0xFFFFFFFF;

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

std::uint64_t hashOf(const TurtleState& state) {
  std::uint64_t hash = state.branchOrder;
  for (const double number : {state.position.x, state.position.y, state.position.z, state.frame.heading.x,
                              state.frame.heading.y, state.frame.heading.z, state.frame.up.x}) {
    hash = (hash ^ std::bit_cast<std::uint64_t>(number)) * 0x9E3779B97F4A7C15U;
    hash ^= hash >> 29U;
  }
  return hash;
}

std::uint64_t bytesOf(const RecordStretch& stretch) {
  std::uint64_t sum = sizeof stretch + stretch.types.size() * sizeof stretch.types[0] +
                      stretch.parameters.size() * sizeof stretch.parameters[0] +
                      (stretch.closed.size() + stretch.opened.size()) * sizeof stretch.entry +
                      stretch.records.size() * sizeof stretch.records[0];
  for (const TurtleRecord& record : stretch.records) {
    sum += record.parameters.size() * sizeof record.parameters[0];
  }
  return sum;
}

}  // namespace

RecordChainBuilder::RecordChainBuilder(const Interpretation::Subject& subject, const RecordChain* base,
                                       const std::function<void(std::span<TurtleRecord>)>& rename, RecordChain& chain)
    : string_(subject.plantState.string),
      arity_(subject.program.arity),
      base_(base),
      rename_(rename),
      chain_(chain),
      output_{.records = &records_, .fillsQueries = false},
      interpretation_(subject, output_) {
  if (base_ != nullptr) {
    next_ = base_->firstLink[subject.plant];
    end_ = base_->firstLink[subject.plant + 1U];
  }
}

void RecordChainBuilder::appendPlant() {
  interpretation_.begin();
  interpretation_.noteIn(&notes_);
  while (module_ < string_.size()) {
    if (next_ < end_ && (follows(next_) || findNext())) {
      take(base_->links[next_++].stretch);
    } else {
      interpret();
    }
  }
  interpretation_.end();
}

bool RecordChainBuilder::follows(std::size_t link) {
  const RecordStretch& stretch = *base_->links[link].stretch;
  const std::uint64_t count = stretch.types.size();
  if (module_ + count > string_.size() || (stretch.endsString && module_ + count != string_.size()) ||
      offset_ + stretch.parameters.size() > string_.parameterCount() ||
      !isSame(stretch.entry, interpretation_.state())) {
    return false;
  }
  const std::vector<TurtleState>& open = interpretation_.openBranches();
  if (open.size() < stretch.closed.size()) {
    return false;
  }
  const bool closesTheSame = std::equal(stretch.closed.begin(), stretch.closed.end(), open.rbegin(), isSame);
  return closesTheSame &&
         std::memcmp(stretch.types.data(), string_.types().data() + module_, count * sizeof(core::ModuleTypeId)) == 0 &&
         (stretch.parameters.empty() || std::memcmp(stretch.parameters.data(), string_.parameters().data() + offset_,
                                                    stretch.parameters.size() * sizeof(double)) == 0);
}

bool RecordChainBuilder::findNext() {
  if (heads_.empty()) {
    buildTable();
  }
  std::uint32_t& head = heads_[hashOf(interpretation_.state()) & (heads_.size() - 1)];
  // those that were passed are never looked at again
  while (head != kNoLink && head < next_) {
    head = following_[head - tableBegin_];
  }
  std::uint32_t link = head;
  for (int tries = 0; link != kNoLink && tries < kTries; ++tries) {
    if (follows(link)) {
      next_ = link;
      return true;
    }
    link = following_[link - tableBegin_];
  }
  return false;
}

void RecordChainBuilder::buildTable() {
  tableBegin_ = next_;
  heads_.assign(std::bit_ceil(2 * (end_ - next_) + 2), kNoLink);
  following_.assign(end_ - next_, kNoLink);
  // nearer links come before farther ones
  for (std::size_t link = end_; link-- > tableBegin_;) {
    std::uint32_t& head = heads_[hashOf(base_->links[link].stretch->entry) & (heads_.size() - 1)];
    following_[link - tableBegin_] = std::exchange(head, static_cast<std::uint32_t>(link));
  }
}

std::uint32_t RecordChainBuilder::resolved(std::uint32_t number) const {
  if (number == kNoParent) {
    return kNoParent;
  }
  return number >= kOuterRecord ? notes_.outer[number - kOuterRecord] : chain_.recordCount + number;
}

void RecordChainBuilder::append(std::shared_ptr<const RecordStretch> stretch, std::uint64_t firstModule) {
  const auto count = static_cast<std::uint32_t>(stretch->records.size());
  chain_.bytes += stretch->bytes;
  chain_.links.push_back(
      {std::move(stretch), firstModule, chain_.recordCount, static_cast<std::uint32_t>(chain_.outer.size())});
  chain_.outer.insert(chain_.outer.end(), notes_.outer.begin(), notes_.outer.end());
  chain_.recordCount += count;
}

void RecordChainBuilder::take(const std::shared_ptr<const RecordStretch>& stretch) {
  std::vector<TurtleState>& open = interpretation_.openBranches();
  TurtleState& state = interpretation_.state();
  notes_.outer.assign(1, state.record);
  for (std::size_t i = 0; i < stretch->closed.size(); ++i) {
    notes_.outer.push_back(open.back().record);
    open.pop_back();
  }
  state = stretch->exit;
  state.record = resolved(state.record);
  for (const TurtleState& opened : stretch->opened) {
    open.push_back(opened);
    open.back().record = resolved(opened.record);
  }
  append(stretch, module_);
  module_ += stretch->types.size();
  offset_ += stretch->parameters.size();
}

void RecordChainBuilder::interpret() {
  const std::uint64_t first = module_;
  const std::uint64_t firstOffset = offset_;
  std::vector<TurtleState>& open = interpretation_.openBranches();
  TurtleState& state = interpretation_.state();
  const auto stretch = std::make_shared<RecordStretch>();
  notes_.lowest = open.size();
  notes_.closed.clear();
  notes_.outer.assign(1, state.record);
  state.record = state.record == kNoParent ? kNoParent : kOuterRecord;
  stretch->entry = state;

  // up to where the base goes on, or far enough
  while (module_ < string_.size()) {
    const bool mayEnd = interpretation_.walkOne(module_, offset_);
    if (mayEnd && (module_ - first >= kStretchModules || (next_ < end_ && findNext()))) {
      break;
    }
  }

  const auto types = string_.types().subspan(first, module_ - first);
  const auto parameters = string_.parameters().subspan(firstOffset, offset_ - firstOffset);
  stretch->types.assign(types.begin(), types.end());
  stretch->parameters.assign(parameters.begin(), parameters.end());
  stretch->endsString = module_ == string_.size();
  stretch->closed = notes_.closed;
  stretch->exit = state;
  stretch->opened.assign(open.begin() + static_cast<std::ptrdiff_t>(notes_.lowest), open.end());
  stretch->records.assign(std::make_move_iterator(records_.begin()), std::make_move_iterator(records_.end()));
  records_.clear();
  for (TurtleRecord& record : stretch->records) {
    record.module -= first;
  }
  rename_(stretch->records);
  stretch->bytes = bytesOf(*stretch);

  // what follows numbers records as in the whole
  state.record = resolved(state.record);
  for (auto opened = open.begin() + static_cast<std::ptrdiff_t>(notes_.lowest); opened != open.end(); ++opened) {
    opened->record = resolved(opened->record);
  }
  append(stretch, first);
}

}  // namespace espalier::turtle
