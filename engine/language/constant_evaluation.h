#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/language/parse/syntax.h"

namespace espalier::language {

/// Whether the reference treats the operand as compound: an operator or a call; parentheses alone do not count. The
/// reference's `&&`, `||` and `?:` skip a side only after a compound operand.
[[nodiscard]] bool isCompound(const ExpressionNode& node);

/// The value of one node from the values of its children, exactly as the evaluator would compute it. Nothing when a
/// child has no value, the node depends on other inputs, it divides by zero, or the value is not finite.
[[nodiscard]] std::optional<double> foldNode(const ExpressionNode& node, const ModelSyntax& model,
                                             std::span<const std::optional<double>> values,
                                             core::Compatibility compatibility);

/// The values of all expressions of a model that are constant, by expression index. Names must be bound.
[[nodiscard]] std::vector<std::optional<double>> foldConstants(const ModelSyntax& model,
                                                               core::Compatibility compatibility);

}  // namespace espalier::language
