#pragma once

#include <cstdint>
#include <memory>
#include <vector>

namespace espalier::derivation {

/// Modules of one string that are the same, with their parameters, in another.
struct KeptModules {
  std::uint64_t from = 0;  // the first, in the one
  std::uint64_t to = 0;    // in the other
  std::uint64_t modules = 0;
  bool operator==(const KeptModules&) const = default;
};

/// Stands for the contents of a string at one time: strings with the same mark are the same. Whoever keeps a mark
/// (ModuleString::marked) can ask the string of a later step for what it still has of these contents, without reading
/// either. Nothing is noted for marks that nobody keeps.
struct StringMark {
  std::weak_ptr<const StringMark> base;  // of the contents that `kept` tells of; expired: nobody keeps them
  std::vector<KeptModules> kept;         // from those of `base` to these, ascending in both; not necessarily all
};

/// What contents have in common with those of a mark, by theirs; nothing when it is not known.
[[nodiscard]] std::vector<KeptModules> keptModules(const StringMark& from, const std::shared_ptr<const StringMark>& to,
                                                   std::uint64_t moduleCount);

/// Notes what a step leaves as it is, for the mark of the string that it makes.
class KeptModulesRecorder {
 public:
  /// The step reads a string with this mark (null: none).
  void begin(const std::shared_ptr<const StringMark>& old);
  /// These come next in both strings, with as many modules between the last ones and them as there may be.
  void note(std::uint64_t from, std::uint64_t to, std::uint64_t modules);
  /// The mark of the string that was made; null when nobody would ask for it.
  [[nodiscard]] std::shared_ptr<const StringMark> finish();

 private:
  std::shared_ptr<const StringMark> base_;  // null: nobody keeps a mark
  std::vector<KeptModules> earlier_;  // from `base_` to the string that the step reads; empty: it is that of `base_`
  bool isDirect_ = false;             // the string that the step reads is that of `base_`
  std::vector<KeptModules> kept_;
};

}  // namespace espalier::derivation
