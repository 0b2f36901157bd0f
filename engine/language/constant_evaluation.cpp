#include "engine/language/constant_evaluation.h"

#include <cmath>
#include <numbers>

#include "engine/language/arithmetic.h"

namespace espalier::language {
namespace {

double foldOr(double a, double b, bool leftIsCompound, core::Compatibility compatibility) {
  const bool isReference = compatibility != core::Compatibility::Espalier;
  return isReference && leftIsCompound && orSkips(a) ? a : toNumber(isTrue(a) || isTrue(b));
}

}  // namespace

bool isCompound(const ExpressionNode& node) {
  return node.kind == ExpressionKind::Unary || node.kind == ExpressionKind::Binary ||
         node.kind == ExpressionKind::Conditional || node.kind == ExpressionKind::Call;
}

std::optional<double> foldNode(const ExpressionNode& node, const ModelSyntax& model,
                               std::span<const std::optional<double>> values, core::Compatibility compatibility) {
  std::vector<double> operands;
  for (const ExpressionIndex child : node.children) {
    if (!values[child].has_value()) {
      return std::nullopt;
    }
    operands.push_back(*values[child]);
  }
  bool dividedByZero = false;
  double value = 0.0;
  switch (node.kind) {
    case ExpressionKind::Number:
      value = node.number;
      break;
    case ExpressionKind::Name:
      if (node.binding.kind != Binding::Kind::Pi) {
        return std::nullopt;
      }
      value = std::numbers::pi;
      break;
    case ExpressionKind::Unary:
      value = applyUnary(node.operation, operands[0]);
      break;
    case ExpressionKind::Binary:
      value =
          node.operation == Operation::LogicalOr
              ? foldOr(operands[0], operands[1], isCompound(model.expressions[node.children[0]]), compatibility)
              : applyBinary(node.operation, operands[0], operands[1], dividedByZero, core::Elementary(compatibility));
      break;
    case ExpressionKind::Conditional:
      value = isTrue(operands[0]) ? operands[1] : operands[2];
      break;
    case ExpressionKind::Call:
      if (node.callee != Callee::Function || !isArithmetic(node.function)) {
        return std::nullopt;
      }
      value = callPure(node.function, operands, dividedByZero, core::Elementary(compatibility));
      break;
    default:
      return std::nullopt;
  }
  return dividedByZero || !std::isfinite(value) ? std::nullopt : std::optional<double>(value);
}

std::vector<std::optional<double>> foldConstants(const ModelSyntax& model, core::Compatibility compatibility) {
  // children stand before their parents
  std::vector<std::optional<double>> values(model.expressions.size());
  for (std::size_t i = 0; i < model.expressions.size(); ++i) {
    values[i] = foldNode(model.expressions[i], model, values, compatibility);
  }
  return values;
}

}  // namespace espalier::language
