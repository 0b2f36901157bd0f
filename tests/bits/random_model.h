#pragma once

#include <cstdint>
#include <string>

namespace espalier::test {

/// A model made at random, with its environment: expressions with every elementary function, draws, conditions,
/// contexts, turns, tropisms, query and communication modules.
struct RandomModel {
  std::string text;         // of model.l
  std::string view;         // of model.v
  std::string process;      // name of a built-in environment; empty: none
  std::uint64_t steps = 0;  // to make
};

/// Model number `number`. Equal on every machine and with every compiler. One in a hundred grows to more modules than
/// one thread derives alone.
[[nodiscard]] RandomModel randomModel(std::uint32_t number);

}  // namespace espalier::test
