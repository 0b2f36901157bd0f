#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "engine/turtle/export/exporters.h"

namespace espalier::turtle {

/// One module of a plant's string, with the turtle's state after it.
struct VisitedModule {
  std::uint32_t plant = 0;
  std::uint64_t index = 0;  // in the plant's string
  std::string_view symbol;
  std::span<const double> parameters;
  const TurtleRecord* state = nullptr;  // of modules that belong together the same; null: cut off, not interpreted
};

/// Calls `visit` for every module of every plant in order, interpreting the strings once more. An error sentence when
/// that fails. `progress` may be empty. O(modules).
[[nodiscard]] std::optional<std::string> walkStrings(const ExportInput& input, const ExportProgress& progress,
                                                     const std::function<void(const VisitedModule&)>& visit);

/// Appends the text form of a module: its symbol, its parameters in parentheses.
void appendModule(std::string& text, std::string_view symbol, std::span<const double> parameters,
                  core::Compatibility compatibility);

}  // namespace espalier::turtle
