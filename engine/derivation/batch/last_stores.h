#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace espalier::derivation {

/// The values that blocks leave in local variables of productions. They belong to the state of a plant: the last module
/// of the string that assigns a variable decides. Batches assign in another order, so each value has the place of its
/// assignment.
class LastStores {
 public:
  /// Of two assignments to a static, the one with the higher place stays.
  void note(std::uint32_t variable, std::uint64_t place, double value) {
    for (Store& store : stores_) {
      if (store.variable == variable) {
        if (place >= store.place) {
          store = {variable, place, value};
        }
        return;
      }
    }
    stores_.push_back({variable, place, value});
  }
  void noteAll(const LastStores& other) {
    for (const Store& store : other.stores_) {
      note(store.variable, store.place, store.value);
    }
  }
  /// Assigns the values to the statics (Program::staticCount).
  void apply(std::span<double> statics) const {
    for (const Store& store : stores_) {
      statics[store.variable] = store.value;
    }
  }
  void clear() { stores_.clear(); }

 private:
  struct Store {
    std::uint32_t variable;
    std::uint64_t place;
    double value;
  };
  std::vector<Store> stores_;  // one for each static
};

}  // namespace espalier::derivation
