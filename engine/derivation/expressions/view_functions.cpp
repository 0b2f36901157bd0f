#include "engine/derivation/expressions/view_functions.h"

namespace espalier::derivation {
namespace {

using language::Function;

/// The entry with a 1-based number, or null.
template <typename T>
const T* entry(const std::vector<T>& list, double number) {
  return number >= 1.0 && number < static_cast<double>(list.size()) + 1.0 ? &list[static_cast<std::size_t>(number) - 1]
                                                                          : nullptr;
}

}  // namespace

std::optional<double> viewValue(const files::ViewSettings& view, Function function, std::span<const double> arguments) {
  if (function == Function::Func) {
    const auto* curve = entry(view.functions, arguments[0]);
    return curve == nullptr ? std::nullopt : std::optional(curve->value(arguments[1]));
  }
  if (function == Function::InBlob) {
    const auto* field = entry(view.blobFields, arguments[0]);
    return field == nullptr ? std::nullopt : std::optional(field->value({arguments[1], arguments[2], arguments[3]}));
  }
  const auto* curve = entry(view.curves, arguments[0]);
  if (curve == nullptr) {
    return std::nullopt;
  }
  if (function == Function::CurveGal) {
    return curve->arcLength();
  }
  const core::Vec3 point = curve->point(arguments[1]);
  return function == Function::CurveX ? point.x : function == Function::CurveY ? point.y : point.z;
}

const char* missingViewFunction(Function function) {
  switch (function) {
    case Function::Func:
      return "func: the view file defines no such function; its value is 0";
    case Function::InBlob:
      return "inblob: the view file defines no such field; its value is 0";
    default:
      return "curve functions: the view file defines no such curve; the value is 0";
  }
}

}  // namespace espalier::derivation
