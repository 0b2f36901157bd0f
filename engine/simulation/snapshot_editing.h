#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "engine/core/simulation_error.h"
#include "engine/simulation/forest.h"

namespace espalier::simulation {

/// A module to be put into a string.
struct EditedModule {
  std::string symbol;
  std::vector<double> parameters;
};

/// A change of one plant's string between two steps.
struct StringEdit {
  enum class Kind : std::uint8_t {
    Insert,  // `modules` before `module`, or at the end when it is the string's length
    Prune,   // removes `module` and all modules behind it in its branch; for a `[` the whole branch
    Replace  // `modules` take the place of `module`
  };
  Kind kind = Kind::Insert;
  std::uint32_t plant = 0;
  std::uint64_t module = 0;  // index in the plant's string
  std::vector<EditedModule> modules;
};

using EditedSnapshot = tl::expected<std::string, core::SimulationError>;

/// The snapshot with one string changed. Brackets stay paired, and modules must be of types that the model has. A model
/// with sub-L-systems cannot be edited, because their states are counted along the string. Not possible while the
/// replies of a step that failed are kept. O(snapshot).
[[nodiscard]] EditedSnapshot editString(std::string_view snapshot, const StringEdit& edit);

/// The snapshot with other values of the main L-system's variables in all plants; names are the Programs'.
[[nodiscard]] EditedSnapshot setVariables(std::string_view snapshot, const Programs& programs,
                                          const std::vector<std::pair<std::string, double>>& values);

/// The snapshot as one of `programs`, which have the same sources with other definitions. restore() finds parts that do
/// not fit.
[[nodiscard]] EditedSnapshot withPrograms(std::string_view snapshot, const Programs& programs);

}  // namespace espalier::simulation
