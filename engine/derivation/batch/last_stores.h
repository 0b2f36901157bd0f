#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace espalier::derivation {

/// The values that blocks leave in local variables of productions. They belong to the state of a plant: the last module
/// of the string that assigns a variable decides. Batches assign in another order, so each value has the place of its
/// assignment: twice the number of the module, and 1 more for a block behind the condition.
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
  /// Notes the assignments of the modules [first, end) in `other`, as those of the module `moved(module)`.
  template <typename F>
  void moveTo(std::uint64_t first, std::uint64_t end, const F& moved, LastStores& other) const {
    for (const Store& store : stores_) {
      const std::uint64_t module = store.place / 2;
      if (first <= module && module < end) {
        other.note(store.variable, 2 * moved(module), store.value);
      }
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
