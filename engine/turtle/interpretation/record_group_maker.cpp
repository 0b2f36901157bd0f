#include "engine/turtle/interpretation/record_group_maker.h"

#include <utility>

namespace espalier::turtle {
namespace {

/// Follows the numbers of records, and open branches, along the stretches of a group.
class Numbering {
 public:
  explicit Numbering(RecordGroup& group) : group_(group) {
    group_.passage.entry = group_.links.front().stretch->passage.entry;
    current_ = group_.passage.entry.record == kNoParent ? kNoParent : kOuterRecord;
  }

  /// Goes over the next stretch. `outer` and `groupOuter`: the outer records of the stretch and of the group, as they
  /// are in the whole.
  void pass(RecordGroup::Link& link, const std::uint32_t* outer, std::vector<std::uint32_t>& groupOuter) {
    TurtlePassage& whole = group_.passage;
    const TurtlePassage& part = link.stretch->passage;
    link.firstModule = whole.modules;
    link.firstRecord = whole.records;
    link.firstOuter = static_cast<std::uint32_t>(group_.outer.size());
    group_.outer.push_back(current_);
    for (std::size_t i = 0; i < part.closed.size(); ++i) {
      group_.outer.push_back(close(part.closed[i], outer[1 + i], groupOuter));
    }
    current_ = resolved(link, part.exit.record);
    for (const TurtleState& opened : part.opened) {
      whole.opened.push_back(opened);
      whole.opened.back().record = resolved(link, opened.record);
    }
    whole.modules += part.modules;
    whole.parameters += part.parameters;
    whole.records += part.records;
    whole.endsString = part.endsString;
    whole.exit = part.exit;
    whole.exit.record = current_;
  }

 private:
  /// The record at the innermost open branch, which is closed.
  std::uint32_t close(const TurtleState& state, std::uint32_t outer, std::vector<std::uint32_t>& groupOuter) {
    TurtlePassage& whole = group_.passage;
    if (!whole.opened.empty()) {
      const std::uint32_t record = whole.opened.back().record;
      whole.opened.pop_back();
      return record;
    }
    whole.closed.push_back(state);
    groupOuter.push_back(outer);
    return state.record == kNoParent ? kNoParent : kOuterRecord + static_cast<std::uint32_t>(whole.closed.size());
  }

  [[nodiscard]] std::uint32_t resolved(const RecordGroup::Link& link, std::uint32_t number) const {
    if (number == kNoParent) {
      return kNoParent;
    }
    return number >= kOuterRecord ? group_.outer[link.firstOuter + (number - kOuterRecord)] : link.firstRecord + number;
  }

  RecordGroup& group_;
  std::uint32_t current_ = kNoParent;  // the turtle's record, numbered as in the group
};

std::uint64_t bytesOf(const RecordGroup& group) {
  std::uint64_t sum = sizeof group + group.links.size() * sizeof group.links[0] +
                      group.outer.size() * sizeof group.outer[0] +
                      (group.passage.closed.size() + group.passage.opened.size()) * sizeof group.passage.entry;
  for (const RecordGroup::Link& link : group.links) {
    sum += link.stretch->bytes;
  }
  return sum;
}

}  // namespace

void RecordGroupMaker::add(std::shared_ptr<const RecordStretch> stretch, std::span<const std::uint32_t> outer) {
  waiting_.push_back({std::move(stretch), outer_.size()});
  outer_.insert(outer_.end(), outer.begin(), outer.end());
  // two halves, so that both have room to grow
  if (waiting_.size() == kMostStretches) {
    makeGroup(kMostStretches / 2);
  }
}

void RecordGroupMaker::makeGroup(std::size_t stretches) {
  if (stretches == 0) {
    return;
  }
  const auto group = std::make_shared<RecordGroup>();
  group->birth = chain_.generation;
  for (std::size_t i = 0; i < stretches; ++i) {
    group->links.push_back({.stretch = std::move(waiting_[i].stretch)});
  }
  const auto firstOuter = static_cast<std::uint32_t>(chain_.outer.size());
  chain_.outer.push_back(outer_[waiting_.front().firstOuter]);
  Numbering numbering(*group);
  for (std::size_t i = 0; i < stretches; ++i) {
    numbering.pass(group->links[i], outer_.data() + waiting_[i].firstOuter, chain_.outer);
  }
  const TurtlePassage& passage = group->passage;
  group->outer.shrink_to_fit();
  group->bytes = bytesOf(*group);

  chain_.links.push_back({group, module_, chain_.recordCount, firstOuter});
  chain_.recordCount += passage.records;
  chain_.bytes += group->bytes;
  pass(passage);

  // those that are left
  const std::size_t usedOuter = stretches < waiting_.size() ? waiting_[stretches].firstOuter : outer_.size();
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(stretches));
  outer_.erase(outer_.begin(), outer_.begin() + static_cast<std::ptrdiff_t>(usedOuter));
  for (Waiting& waiting : waiting_) {
    waiting.firstOuter -= usedOuter;
  }
}

}  // namespace espalier::turtle
