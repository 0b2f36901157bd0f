#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "protocol/envelope.h"

namespace espalier::protocol {

/// Reads environment.step and its answer as text, several times faster than the tree of decodeMessage. It takes only
/// usual lines: another method, another member or an error anywhere leaves the line to decodeMessage, which reports
/// errors. For every line that this class takes, decodeMessage gives the same values. Keeps memory of six times the
/// longest line until rest().
class BulkTextReader {
 public:
  /// Lines below it are left to the tree.
  static constexpr std::size_t kLeastBytes = 4'096;

  BulkTextReader();
  ~BulkTextReader();
  BulkTextReader(BulkTextReader&&) noexcept;
  BulkTextReader& operator=(BulkTextReader&&) noexcept;

  [[nodiscard]] std::optional<Message> read(std::string_view line);
  /// Gives back the memory of the lines that were read. For a side that may now be silent for long.
  void rest();

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;  // made with the first long line
};

}  // namespace espalier::protocol
