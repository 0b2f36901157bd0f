#include "engine/derivation/scan/cut_parts.h"

#include <algorithm>
#include <array>
#include <span>

namespace espalier::derivation {

CutParts::CutParts(const language::Program& program)
    : cut_(program.cut), keepingCut_(program.findType("%", 1)), marker_(program.findType("%", 2)) {}

void CutParts::add(const ModuleString& old, const StringPart& part, std::uint64_t offset) {
  if (keepsPart(old.types()[part.firstModule - 1])) {
    kept_.push_back({part, old.parameters()[offset]});
  }
}

void CutParts::dropInside(const StringPart& part) {
  while (!kept_.empty() && kept_.back().part.firstModule <= part.endModule) {
    kept_.pop_back();
  }
}

void CutParts::reverse() {
  std::reverse(kept_.begin(), kept_.end());
}

void CutParts::appendTo(ModuleString& string, const ModuleString& old, const Evaluator& evaluator) const {
  if (kept_.empty()) {
    return;
  }
  if (marker_ == core::kNoModuleType) {
    evaluator.warn("the part that %(p) cuts is dropped: the model has no %(p,n) to append it behind", {});
    return;
  }
  // n counts on from the markers that are in the string already
  const std::span<const core::ModuleTypeId> made = string.types();
  auto number = static_cast<double>(std::count(made.begin(), made.end(), marker_));
  for (const auto& [part, parameter] : kept_) {
    string.append(marker_, std::array<double, 2>{parameter, number});
    string.appendAll(old.types().subspan(part.firstModule, part.endModule - part.firstModule),
                     old.parameters().subspan(part.firstParameter, part.endParameter - part.firstParameter));
    number += 1.0;
  }
}

}  // namespace espalier::derivation
