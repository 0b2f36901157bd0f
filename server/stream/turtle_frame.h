#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/turtle/scene/scene.h"
#include "protocol/messages.h"

namespace espalier::server {

/// The turtle records of one state as columns, one row a record. Never changes. The streams that show it share it;
/// streams of differences keep it until their next frame.
struct TurtleFrame {
  std::shared_ptr<const std::vector<std::string>> symbols;  // the names for `symbol`: Simulation::symbolNames
  std::vector<std::uint32_t> index;  // among all records of the state (rows); empty: the row itself
  std::vector<std::uint32_t> plant, module, symbol, colour, branchOrder;  // (rows) each
  std::vector<std::uint32_t> parent;                                      // index of a record, kNoParent: none (rows)
  std::vector<std::uint32_t> parameterOffset{0};                          // (rows + 1)
  std::vector<double> parameters;                                         // concatenated
  std::vector<double> position, heading, left, up;                        // (3 * rows) each
  std::vector<double> width;                                              // (rows)

  static constexpr std::uint32_t kNoParent = 0xFFFFFFFF;

  [[nodiscard]] std::size_t rows() const { return plant.size(); }
  /// Bytes of memory.
  [[nodiscard]] std::uint64_t bytes() const;
};

/// The records that a selection takes. Throws protocol::NonFiniteNumber.
[[nodiscard]] TurtleFrame makeTurtleFrame(const std::vector<turtle::TurtleRecord>& records,
                                          std::shared_ptr<const std::vector<std::string>> symbols,
                                          const protocol::StreamSelection& select);

/// Appends a record as a row; `module` and `parent` stand in the place of its own. Throws protocol::NonFiniteNumber.
void appendRecord(TurtleFrame& frame, const turtle::TurtleRecord& record, std::uint64_t module, std::uint32_t parent);
/// Makes room for so many more rows.
void reserveRows(TurtleFrame& frame, std::size_t rows);

/// A run of rows that a frame shares with an earlier one. Its numbers of records and modules are those of the earlier
/// frame plus the amounts here, modulo 2^32.
struct KeptRows {
  std::uint32_t to = 0;    // first row in the later frame
  std::uint32_t from = 0;  // first row in the earlier frame
  std::uint32_t rows = 0;
  std::uint32_t module = 0;  // to be added to `module`
  std::uint32_t parent = 0;  // to be added to `parent` where there is one
  std::uint32_t index = 0;   // to be added to `index`
};

/// The difference that makes `frame` of `base`: runs of rows that are there already, in order of `to`, and the rows
/// that no run covers, in order. Numbers are the same when their bits are.
struct TurtleDifference {
  std::vector<KeptRows> kept;
  std::vector<std::uint32_t> fresh;  // rows of the later frame
};

/// The same in the form that is sent: the rows that no run covers are a frame.
struct TurtleChange {
  std::size_t rows = 0;  // of the later frame
  std::vector<KeptRows> kept;
  std::shared_ptr<const TurtleFrame> fresh;
};

/// O(rows) with one pass over both frames when most rows are kept. Both must have the same symbols.
[[nodiscard]] TurtleDifference differenceOf(const TurtleFrame& base, const TurtleFrame& frame);

/// The rows of a frame, in that order, as a frame.
[[nodiscard]] TurtleFrame rowsOf(const TurtleFrame& frame, const std::vector<std::uint32_t>& rows);

}  // namespace espalier::server
