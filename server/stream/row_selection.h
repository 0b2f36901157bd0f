#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <unordered_set>
#include <vector>

#include "protocol/messages.h"

namespace espalier::server {

/// Which rows a viewer has selected, by plant and symbol. A selection may have as many names as a message holds, so a
/// row costs O(log plants) whatever its length.
class RowSelection {
 public:
  /// `symbols`: what the symbols of rows are places in. O(names + symbols + plants · log plants).
  RowSelection(const std::vector<std::string>& symbols, const protocol::StreamSelection& select)
      : areAllSymbols_(select.symbols.empty()), plants_(select.plants) {
    std::sort(plants_.begin(), plants_.end());
    if (areAllSymbols_) {
      return;
    }
    const std::unordered_set<std::string_view> names(select.symbols.begin(), select.symbols.end());
    for (const std::string& symbol : symbols) {
      isTaken_.push_back(names.contains(symbol));
    }
  }
  [[nodiscard]] bool takes(std::uint32_t plant, std::uint32_t symbol) const {
    return (plants_.empty() || std::binary_search(plants_.begin(), plants_.end(), plant)) &&
           (areAllSymbols_ || (symbol < isTaken_.size() && isTaken_[symbol]));
  }

 private:
  bool areAllSymbols_;
  std::vector<bool> isTaken_;  // by symbol
  std::vector<std::uint32_t> plants_;
};

}  // namespace espalier::server
