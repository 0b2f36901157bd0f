#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "engine/derivation/state/module_string.h"
#include "engine/language/program.h"

namespace espalier::command {

/// Measures of the branching of a string, as a multiscale tree graph has it (Godin & Caraglio 1998). A vertex is a
/// module whose symbol begins with a letter. It stands on the vertex before it in its branch, else on the vertex that
/// bears the branch. An axis is a chain of vertices without a bracket between them; its order is the number of axes
/// below it.
[[nodiscard]] const std::vector<std::string_view>& treeMeasureNames();

/// The tree of one string.
class TreeMeasures {
 public:
  /// `isVertex` by module type; empty: every module whose symbol begins with a letter. O(modules).
  TreeMeasures(const language::Program& program, const derivation::ModuleString& string,
               const std::vector<bool>& isVertex);

  /// The measure of that place in treeMeasureNames(), of one order when it is given. Not a number: of no vertex.
  [[nodiscard]] double value(std::size_t name, std::optional<std::uint64_t> order) const;

 private:
  struct Vertex {
    std::uint32_t parent;  // index; kNone: a root
    std::uint32_t order;
    std::uint32_t depth = 1;      // vertices from the root to this one
    std::uint32_t strahler = 1;   // Strahler 1957
    std::uint32_t strongest = 0;  // greatest Strahler number among the children
    bool isTip = true;
    bool startsAxis = true;
  };
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  std::vector<Vertex> vertices_;
};

}  // namespace espalier::command
