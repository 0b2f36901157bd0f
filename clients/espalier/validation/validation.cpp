#include "clients/espalier/validation/validation.h"

namespace espalier::validation {

std::span<const Case> cases() {
  static const std::vector<Case> kAll = [] {
    std::vector<Case> all;
    for (const auto& some : {architectureCases(), soilCases(), rootCases(), uptakeCases(), weatherCases(), lightCases(),
                             forestCases(), standCases()}) {
      all.insert(all.end(), some.begin(), some.end());
    }
    return all;
  }();
  return kAll;
}

}  // namespace espalier::validation
