#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace espalier::derivation {

/// A run of modules that is equal in two strings, with all parameters.
struct KeptModules {
  std::uint64_t from = 0;  // first module, in the one string
  std::uint64_t to = 0;    // in the other
  std::uint64_t modules = 0;
  bool operator==(const KeptModules&) const = default;
};

/// Names the contents of a string at one time: strings with the same mark are equal. A caller that keeps a mark
/// (ModuleString::marked) can ask the string of a later step which of these contents it still has, without reading
/// either string. For a mark that no caller keeps, nothing is noted.
struct StringMark {
  std::weak_ptr<const StringMark> base;  // of earlier contents; expired: no caller keeps their mark
  std::vector<KeptModules> kept;         // runs that `base` and these contents share, ascending; some may be missing
};

/// The runs that the contents of two marks share; empty when they are not known.
[[nodiscard]] std::vector<KeptModules> keptModules(const StringMark& from, const std::shared_ptr<const StringMark>& to,
                                                   std::uint64_t moduleCount);

/// Notes the modules that a step leaves as they are, for the mark of the string that the step makes.
class KeptModulesRecorder {
 public:
  /// The step reads a string with this mark (null: none).
  void begin(const std::shared_ptr<const StringMark>& old);
  /// These modules come next in both strings, with any number of other modules before them.
  void note(std::uint64_t from, std::uint64_t to, std::uint64_t modules);
  /// The mark of the string that was made; null when no caller could ask for it.
  [[nodiscard]] std::shared_ptr<const StringMark> finish();

 private:
  std::shared_ptr<const StringMark> base_;  // null: no caller keeps a mark
  std::vector<KeptModules> earlier_;  // that `base_` and the string that the step reads share; unused when isDirect_
  bool isDirect_ = false;             // the step reads the string of `base_`
  std::vector<KeptModules> kept_;
};

}  // namespace espalier::derivation
