#include "server/stream/chain_difference.h"

#include <algorithm>
#include <utility>

#include "engine/core/check.h"
#include "server/stream/row_difference.h"

namespace espalier::server {
namespace {

using turtle::RecordChain;

using Places = std::vector<RecordChain::Place>;

/// The records of stretches [begin, end) for RowDifference.
class ChainRows {
 public:
  ChainRows(const RecordChain& chain, const Places& places, std::size_t begin, std::size_t end) {
    std::size_t count = 0;
    for (std::size_t i = begin; i < end; ++i) {
      count += places[i].stretch->records.size();
    }
    rows_.reserve(count);
    for (std::size_t i = begin; i < end; ++i) {
      const RecordChain::Place& place = places[i];
      for (const turtle::TurtleRecord& record : place.stretch->records) {
        rows_.push_back({&record, static_cast<std::uint32_t>(place.firstModule + record.module),
                         chain.recordOf(place, record.parent)});
      }
    }
  }

  [[nodiscard]] std::size_t rows() const { return rows_.size(); }
  [[nodiscard]] RowView row(std::size_t i) const {
    const turtle::TurtleRecord& record = *rows_[i].record;
    return {.position = &record.position,
            .heading = &record.frame.heading,
            .left = &record.frame.left,
            .up = &record.frame.up,
            .width = record.width,
            .plant = record.plant,
            .module = rows_[i].module,
            .symbol = record.symbol,
            .colour = static_cast<std::uint32_t>(record.colour),
            .branchOrder = record.branchOrder,
            .parent = rows_[i].parent,
            .index = static_cast<std::uint32_t>(i),
            .parameters = record.parameters};
  }
  void appendTo(TurtleFrame& frame, std::size_t i) const {
    appendRecord(frame, *rows_[i].record, rows_[i].module, rows_[i].parent);
  }

 private:
  struct Row {
    const turtle::TurtleRecord* record;
    std::uint32_t module;
    std::uint32_t parent;
  };

  std::vector<Row> rows_;
};

/// A part of a chain, a group or a stretch.
struct Part {
  const void* part = nullptr;
  std::uint64_t birth = 0;
};

/// Goes over the parts of two chains, in order: `keep(from, to)` for parts that both share, and `tellGap(from, fromEnd,
/// to, toEnd)` for the parts between them. The base is of this generation, so it has every part that is not younger
/// (RecordChain): the next shared part is found by going on.
template <typename Keep, typename TellGap>
void match(std::uint64_t generation, const std::vector<Part>& baseParts, const std::vector<Part>& parts,
           const Keep& keep, const TellGap& tellGap) {
  std::size_t from = 0;  // parts before it are done
  std::size_t to = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].birth > generation) {
      continue;
    }
    std::size_t same = from;
    while (same < baseParts.size() && baseParts[same].part != parts[i].part) {
      ++same;
    }
    ESPALIER_CHECK(same < baseParts.size());
    if (to < i) {
      tellGap(from, same, to, i);
    }
    keep(same, i);
    from = same + 1;
    to = i + 1;
  }
  if (to < parts.size()) {
    tellGap(from, baseParts.size(), to, parts.size());
  }
}

class ChainDifference {
 public:
  ChainDifference(const RecordChain& base, const RecordChain& chain,
                  std::shared_ptr<const std::vector<std::string>> symbols)
      : base_(base), chain_(chain) {
    fresh_.symbols = std::move(symbols);
  }

  TurtleChange make() {
    const auto groupsOf = [](const RecordChain& chain) {
      std::vector<Part> groups;
      groups.reserve(chain.links.size());
      for (const RecordChain::Link& link : chain.links) {
        groups.push_back({link.group.get(), link.group->birth});
      }
      return groups;
    };
    match(
        base_.generation, groupsOf(base_), groupsOf(chain_),
        [this](std::size_t from, std::size_t to) { keepGroup(from, to); },
        [this](std::size_t from, std::size_t fromEnd, std::size_t to, std::size_t toEnd) {
          tellGroups(base_.places(from, fromEnd), chain_.places(to, toEnd));
        });
    return {chain_.recordCount, std::move(kept_), std::make_shared<const TurtleFrame>(std::move(fresh_))};
  }

 private:
  /// Stretches of the base have become others, some of them perhaps in other groups.
  void tellGroups(const Places& from, const Places& to) {
    const auto stretchesOf = [](const Places& places) {
      std::vector<Part> stretches;
      stretches.reserve(places.size());
      for (const RecordChain::Place& place : places) {
        stretches.push_back({place.stretch, place.stretch->birth});
      }
      return stretches;
    };
    match(
        base_.generation, stretchesOf(from), stretchesOf(to),
        [&](std::size_t i, std::size_t j) { keepStretch(from[i], to[j]); },
        [&](std::size_t begin, std::size_t end, std::size_t toBegin, std::size_t toEnd) {
          tellRows(from, begin, end, to, toBegin, toEnd);
        });
  }

  /// Stretches [begin, end) of the base have become [toBegin, toEnd), which are others.
  void tellRows(const Places& from, std::size_t begin, std::size_t end, const Places& to, std::size_t toBegin,
                std::size_t toEnd) {
    const ChainRows base(base_, from, begin, end);
    const ChainRows rows(chain_, to, toBegin, toEnd);
    const TurtleDifference difference = RowDifference(base, rows).make();
    for (KeptRows run : difference.kept) {
      run.to += to[toBegin].firstRecord;
      run.from += from[begin].firstRecord;
      run.index = run.to - run.from;
      append(run);
    }
    // at least doubled, so that many gaps do not copy one another again and again
    if (fresh_.rows() + difference.fresh.size() > fresh_.plant.capacity()) {
      reserveRows(fresh_, std::max(difference.fresh.size(), fresh_.rows()));
    }
    for (const std::uint32_t row : difference.fresh) {
      rows.appendTo(fresh_, row);
    }
  }

  /// Rows that are kept when the rows they grow from have moved by the same amount.
  static KeptRows runOf(std::uint32_t from, std::uint32_t to, std::uint64_t fromModule, std::uint64_t toModule,
                        std::size_t rows) {
    KeptRows run;
    run.to = to;
    run.from = from;
    run.rows = static_cast<std::uint32_t>(rows);
    run.module = static_cast<std::uint32_t>(toModule - fromModule);
    run.parent = to - from;
    run.index = to - from;
    return run;
  }

  void keepGroup(std::size_t from, std::size_t to) {
    const RecordChain::Link& before = base_.links[from];
    const RecordChain::Link& after = chain_.links[to];
    const turtle::TurtlePassage& passage = after.group->passage;
    const KeptRows run =
        runOf(before.firstRecord, after.firstRecord, before.firstModule, after.firstModule, passage.records);
    bool movesAsOne = true;
    for (std::size_t k = 0; k < 1 + passage.closed.size(); ++k) {
      const std::uint32_t parent = chain_.outer[after.firstOuter + k];
      movesAsOne =
          movesAsOne && (parent == turtle::kNoParent || parent - base_.outer[before.firstOuter + k] == run.parent);
    }
    if (movesAsOne) {
      append(run);
      return;
    }
    const Places befores = base_.places(from, from + 1);
    const Places afters = chain_.places(to, to + 1);
    for (std::size_t i = 0; i < afters.size(); ++i) {
      keepStretch(befores[i], afters[i]);
    }
  }

  void keepStretch(const RecordChain::Place& from, const RecordChain::Place& to) {
    const std::vector<turtle::TurtleRecord>& records = to.stretch->records;
    KeptRows run = runOf(from.firstRecord, to.firstRecord, from.firstModule, to.firstModule, records.size());
    bool movesAsOne = true;
    for (std::size_t k = 0; k < 1 + to.stretch->passage.closed.size(); ++k) {
      const std::uint32_t parent = chain_.outerRecordOf(to, k);
      movesAsOne = movesAsOne && (parent == turtle::kNoParent || parent - base_.outerRecordOf(from, k) == run.parent);
    }
    if (movesAsOne) {
      append(run);
      return;
    }
    run.rows = 1;
    for (const turtle::TurtleRecord& record : records) {
      KeptRows row = run;
      const std::uint32_t parent = chain_.recordOf(to, record.parent);
      if (parent != turtle::kNoParent) {
        row.parent = parent - base_.recordOf(from, record.parent);
      }
      append(row);
      ++run.to;
      ++run.from;
    }
  }

  /// Goes on with the last run where it can.
  void append(const KeptRows& run) {
    if (run.rows == 0) {
      return;
    }
    if (!kept_.empty()) {
      KeptRows& last = kept_.back();
      if (last.to + last.rows == run.to && last.from + last.rows == run.from && last.module == run.module &&
          last.parent == run.parent) {
        last.rows += run.rows;
        return;
      }
    }
    kept_.push_back(run);
  }

  const RecordChain& base_;
  const RecordChain& chain_;
  std::vector<KeptRows> kept_;
  TurtleFrame fresh_;
};

}  // namespace

TurtleFrame makeTurtleFrame(const RecordChain& chain, std::shared_ptr<const std::vector<std::string>> symbols) {
  TurtleFrame frame;
  frame.symbols = std::move(symbols);
  reserveRows(frame, chain.recordCount);
  for (const RecordChain::Place& place : chain.places(0, chain.links.size())) {
    for (const turtle::TurtleRecord& record : place.stretch->records) {
      appendRecord(frame, record, place.firstModule + record.module, chain.recordOf(place, record.parent));
    }
  }
  return frame;
}

TurtleChange differenceOf(const RecordChain& base, const RecordChain& chain,
                          std::shared_ptr<const std::vector<std::string>> symbols) {
  return ChainDifference(base, chain, std::move(symbols)).make();
}

}  // namespace espalier::server
