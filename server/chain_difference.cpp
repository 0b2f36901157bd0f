#include "server/chain_difference.h"

#include <bit>
#include <functional>
#include <utility>

namespace espalier::server {
namespace {

using turtle::RecordChain;
using turtle::RecordStretch;

/// The records of links [begin, end) as rows.
TurtleFrame rowsOf(const RecordChain& chain, std::size_t begin, std::size_t end,
                   std::shared_ptr<const std::vector<std::string>> symbols) {
  TurtleFrame frame;
  frame.symbols = std::move(symbols);
  const auto firstRecordOf = [&](std::size_t link) {
    return link < chain.links.size() ? chain.links[link].firstRecord : chain.recordCount;
  };
  reserveRows(frame, firstRecordOf(end) - firstRecordOf(begin));
  for (std::size_t i = begin; i < end; ++i) {
    const RecordChain::Link& link = chain.links[i];
    for (const turtle::TurtleRecord& record : link.stretch->records) {
      appendRecord(frame, record, link.firstModule + record.module, chain.recordOf(link, record.parent));
    }
  }
  return frame;
}

void appendRows(TurtleFrame& to, const TurtleFrame& from) {
  const auto append = [&](auto column) {
    (to.*column).insert((to.*column).end(), (from.*column).begin(), (from.*column).end());
  };
  const auto firstParameter = static_cast<std::uint32_t>(to.parameters.size());
  for (const auto column : {&TurtleFrame::plant, &TurtleFrame::module, &TurtleFrame::symbol, &TurtleFrame::colour,
                            &TurtleFrame::branchOrder, &TurtleFrame::parent}) {
    append(column);
  }
  for (const auto column : {&TurtleFrame::parameters, &TurtleFrame::position, &TurtleFrame::heading, &TurtleFrame::left,
                            &TurtleFrame::up, &TurtleFrame::width}) {
    append(column);
  }
  for (std::size_t row = 1; row < from.parameterOffset.size(); ++row) {
    to.parameterOffset.push_back(firstParameter + from.parameterOffset[row]);
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
    std::size_t to = 0;    // links before it are told, of the chain
    std::size_t from = 0;  // and of the base
    for (std::size_t link = 0; link < chain_.links.size(); ++link) {
      const std::size_t same = find(from, *chain_.links[link].stretch);
      if (same == kNone) {
        continue;
      }
      tellGap(from, same, to, link);
      keep(base_.links[same], chain_.links[link]);
      from = same + 1;
      to = link + 1;
    }
    tellGap(from, base_.links.size(), to, chain_.links.size());
    return {chain_.recordCount, std::move(kept_), std::make_shared<const TurtleFrame>(std::move(fresh_))};
  }

 private:
  static constexpr std::size_t kNone = ~std::size_t{0};

  /// The next link of the base from `from` on with this stretch.
  std::size_t find(std::size_t from, const RecordStretch& stretch) {
    if (from < base_.links.size() && base_.links[from].stretch.get() == &stretch) {
      return from;
    }
    if (places_.empty()) {
      places_.assign(std::bit_ceil(2 * base_.links.size() + 2), kNone);
      for (std::size_t link = 0; link < base_.links.size(); ++link) {
        placeOf(*base_.links[link].stretch) = link;
      }
    }
    const std::size_t link = placeOf(stretch);
    return link != kNone && link >= from ? link : kNone;
  }

  /// Where the link of the base with this stretch is written, or would be: a chain has no stretch twice.
  std::size_t& placeOf(const RecordStretch& stretch) {
    const std::size_t mask = places_.size() - 1;
    std::size_t slot = std::hash<const RecordStretch*>()(&stretch) * 0x9E3779B97F4A7C15U >> 20U & mask;
    while (places_[slot] != kNone && base_.links[places_[slot]].stretch.get() != &stretch) {
      slot = (slot + 1) & mask;
    }
    return places_[slot];
  }

  /// Links [from, fromEnd) of the base have become links [to, toEnd).
  void tellGap(std::size_t from, std::size_t fromEnd, std::size_t to, std::size_t toEnd) {
    if (to == toEnd) {
      return;
    }
    const TurtleFrame base = rowsOf(base_, from, fromEnd, fresh_.symbols);
    const TurtleFrame frame = rowsOf(chain_, to, toEnd, fresh_.symbols);
    const TurtleDifference difference = server::differenceOf(base, frame);
    const std::uint32_t firstTo = chain_.links[to].firstRecord;
    const std::uint32_t firstFrom = from < base_.links.size() ? base_.links[from].firstRecord : base_.recordCount;
    for (KeptRows run : difference.kept) {
      run.to += firstTo;
      run.from += firstFrom;
      run.index = run.to - run.from;
      append(run);
    }
    appendRows(fresh_, server::rowsOf(frame, difference.fresh));
  }

  void keep(const RecordChain::Link& from, const RecordChain::Link& to) {
    const std::vector<turtle::TurtleRecord>& records = to.stretch->records;
    KeptRows run;
    run.to = to.firstRecord;
    run.from = from.firstRecord;
    run.rows = static_cast<std::uint32_t>(records.size());
    run.module = static_cast<std::uint32_t>(to.firstModule - from.firstModule);
    run.parent = run.to - run.from;
    run.index = run.to - run.from;
    // all of it in one when what it grows from has moved as it has
    const std::size_t outerCount = 1 + to.stretch->closed.size();
    bool movesAsOne = true;
    for (std::size_t k = 0; k < outerCount; ++k) {
      const std::uint32_t parent = chain_.outer[to.firstOuter + k];
      movesAsOne =
          movesAsOne && (parent == turtle::kNoParent || parent - base_.outer[from.firstOuter + k] == run.parent);
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
  std::vector<std::size_t> places_;  // of stretches among the links of the base (a power of two); empty: not needed yet
  std::vector<KeptRows> kept_;
  TurtleFrame fresh_;
};

}  // namespace

TurtleFrame makeTurtleFrame(const RecordChain& chain, std::shared_ptr<const std::vector<std::string>> symbols) {
  return rowsOf(chain, 0, chain.links.size(), std::move(symbols));
}

TurtleChange differenceOf(const RecordChain& base, const RecordChain& chain,
                          std::shared_ptr<const std::vector<std::string>> symbols) {
  return ChainDifference(base, chain, std::move(symbols)).make();
}

}  // namespace espalier::server
