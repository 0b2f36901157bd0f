#pragma once

#include <cstdint>
#include <vector>

#include "engine/derivation/expressions/evaluator.h"
#include "engine/derivation/state/module_string.h"
#include "engine/derivation/state/string_part.h"
#include "engine/language/program.h"

namespace espalier::derivation {

/// The parts that cut symbols remove from the string in one step. A `%` drops its part. A `%(p)` moves it to the end of
/// the new string, behind a module `%(p,n)`.
class CutParts {
 public:
  explicit CutParts(const language::Program& program);

  void clear() { kept_.clear(); }
  [[nodiscard]] bool isCut(core::ModuleTypeId type) const { return type == cut_ || type == keepingCut_; }
  /// Whether the type is `%(p)`.
  [[nodiscard]] bool keepsPart(core::ModuleTypeId type) const { return type == keepingCut_; }

  /// Keeps the part if its symbol is `%(p)`.
  void add(const ModuleString& old, const StringPart& part, std::uint64_t offset);
  /// Drops the kept parts inside `part`, which a cut before them removes with their symbols. Those parts were added
  /// from right to left.
  void dropInside(const StringPart& part);
  /// Turns the order of the kept parts round.
  void reverse();
  /// Keeps the parts that another scan of the same string has kept.
  void addAll(const CutParts& other) { kept_.insert(kept_.end(), other.kept_.begin(), other.kept_.end()); }

  /// Appends the kept parts to the new string.
  void appendTo(ModuleString& string, const ModuleString& old, const Evaluator& evaluator) const;

 private:
  struct KeptPart {
    StringPart part;
    double parameter = 0.0;  // p
  };

  core::ModuleTypeId cut_;         // `%`
  core::ModuleTypeId keepingCut_;  // `%` with one parameter
  core::ModuleTypeId marker_;      // `%` with two parameters
  std::vector<KeptPart> kept_;
};

}  // namespace espalier::derivation
