#include "server/stream/chain_difference.h"

#include <algorithm>
#include <bit>
#include <functional>
#include <utility>

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

/// Finds parts of one list in another: stretches among stretches, or groups among groups. A chain has no part twice.
class PartFinder {
 public:
  static constexpr std::size_t kNone = ~std::size_t{0};

  explicit PartFinder(std::vector<const void*> parts) : parts_(std::move(parts)) {}

  /// Where the part is, from `from` on.
  [[nodiscard]] std::size_t find(std::size_t from, const void* part) {
    if (from < parts_.size() && parts_[from] == part) {
      return from;
    }
    if (slots_.empty()) {
      slots_.assign(std::bit_ceil(2 * parts_.size() + 2), kNone);
      for (std::size_t i = 0; i < parts_.size(); ++i) {
        slotOf(parts_[i]) = i;
      }
    }
    const std::size_t place = slotOf(part);
    return place != kNone && place >= from ? place : kNone;
  }
  [[nodiscard]] std::size_t size() const { return parts_.size(); }

 private:
  /// Where the part's place is written, or would be.
  std::size_t& slotOf(const void* part) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = std::hash<const void*>()(part) * 0x9E3779B97F4A7C15U >> 20U & mask;
    while (slots_[slot] != kNone && parts_[slots_[slot]] != part) {
      slot = (slot + 1) & mask;
    }
    return slots_[slot];
  }

  std::vector<const void*> parts_;
  std::vector<std::size_t> slots_;  // a power of two; empty: not needed yet
};

/// Goes over two lists of parts, in order: `keep(from, to)` for parts that both share, and `tellGap(from, fromEnd, to,
/// toEnd)` for the parts between them.
template <typename Keep, typename TellGap>
void match(std::vector<const void*> baseParts, const std::vector<const void*>& parts, const Keep& keep,
           const TellGap& tellGap) {
  PartFinder base(std::move(baseParts));
  std::size_t from = 0;  // parts before it are done
  std::size_t to = 0;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const std::size_t same = base.find(from, parts[i]);
    if (same == PartFinder::kNone) {
      continue;
    }
    if (to < i) {
      tellGap(from, same, to, i);
    }
    keep(same, i);
    from = same + 1;
    to = i + 1;
  }
  if (to < parts.size()) {
    tellGap(from, base.size(), to, parts.size());
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
      std::vector<const void*> groups;
      groups.reserve(chain.links.size());
      for (const RecordChain::Link& link : chain.links) {
        groups.push_back(link.group.get());
      }
      return groups;
    };
    match(
        groupsOf(base_), groupsOf(chain_), [this](std::size_t from, std::size_t to) { keepGroup(from, to); },
        [this](std::size_t from, std::size_t fromEnd, std::size_t to, std::size_t toEnd) {
          tellGroups(base_.places(from, fromEnd), chain_.places(to, toEnd));
        });
    return {chain_.recordCount, std::move(kept_), std::make_shared<const TurtleFrame>(std::move(fresh_))};
  }

 private:
  /// Stretches of the base have become others, some of them perhaps in other groups.
  void tellGroups(const Places& from, const Places& to) {
    const auto stretchesOf = [](const Places& places) {
      std::vector<const void*> stretches;
      stretches.reserve(places.size());
      for (const RecordChain::Place& place : places) {
        stretches.push_back(place.stretch);
      }
      return stretches;
    };
    match(
        stretchesOf(from), stretchesOf(to), [&](std::size_t i, std::size_t j) { keepStretch(from[i], to[j]); },
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
