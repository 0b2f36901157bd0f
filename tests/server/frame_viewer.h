#pragma once

#include <gtest/gtest.h>

#include <cstring>

#include "server/stream/turtle_frame.h"

namespace espalier::server {

/// The frame of a viewer that had `base` and is told the change, put together as protocol/README.md says.
inline TurtleFrame viewedAfter(const TurtleFrame& base, const TurtleChange& change) {
  TurtleFrame result;
  result.symbols = change.fresh->symbols;
  const auto add = [&](const TurtleFrame& from, std::size_t row, const KeptRows& run) {
    result.plant.push_back(from.plant.at(row));
    result.module.push_back(from.module[row] + run.module);
    result.symbol.push_back(from.symbol[row]);
    result.colour.push_back(from.colour[row]);
    result.branchOrder.push_back(from.branchOrder[row]);
    const std::uint32_t parent = from.parent[row];
    result.parent.push_back(parent == TurtleFrame::kNoParent ? parent : parent + run.parent);
    if (!from.index.empty()) {
      result.index.push_back(from.index[row] + run.index);
    }
    for (const auto column : {&TurtleFrame::position, &TurtleFrame::heading, &TurtleFrame::left, &TurtleFrame::up}) {
      const auto begin = (from.*column).begin() + static_cast<std::ptrdiff_t>(3 * row);
      (result.*column).insert((result.*column).end(), begin, begin + 3);
    }
    result.width.push_back(from.width[row]);
    result.parameters.insert(result.parameters.end(), from.parameters.begin() + from.parameterOffset[row],
                             from.parameters.begin() + from.parameterOffset[row + 1]);
    result.parameterOffset.push_back(static_cast<std::uint32_t>(result.parameters.size()));
  };
  std::size_t run = 0;
  std::size_t used = 0;
  for (std::size_t row = 0; row < change.rows;) {
    if (run < change.kept.size() && change.kept[run].to == row) {
      for (std::uint32_t i = 0; i < change.kept[run].rows; ++i) {
        add(base, change.kept[run].from + i, change.kept[run]);
      }
      row += change.kept[run++].rows;
    } else {
      add(*change.fresh, used++, {});
      ++row;
    }
  }
  EXPECT_EQ(used, change.fresh->rows());
  EXPECT_EQ(run, change.kept.size());
  return result;
}

/// That every number has the same bits.
inline void expectSameRows(const TurtleFrame& a, const TurtleFrame& b) {
  for (const auto column :
       {&TurtleFrame::index, &TurtleFrame::plant, &TurtleFrame::module, &TurtleFrame::symbol, &TurtleFrame::colour,
        &TurtleFrame::branchOrder, &TurtleFrame::parent, &TurtleFrame::parameterOffset}) {
    EXPECT_EQ(a.*column, b.*column);
  }
  for (const auto column : {&TurtleFrame::parameters, &TurtleFrame::position, &TurtleFrame::heading, &TurtleFrame::left,
                            &TurtleFrame::up, &TurtleFrame::width}) {
    ASSERT_EQ((a.*column).size(), (b.*column).size());
    EXPECT_TRUE((a.*column).empty() ||
                std::memcmp((a.*column).data(), (b.*column).data(), (a.*column).size() * sizeof(double)) == 0);
  }
}

}  // namespace espalier::server
