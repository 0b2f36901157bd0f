#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "engine/derivation/state/module_string.h"

namespace espalier::derivation {

/// A run of modules that is equal, with all parameters, in an older and in a newer string.
struct KeptModules {
  std::uint64_t from = 0;  // first module, in the older string
  std::uint64_t to = 0;    // in the newer one
  std::uint64_t modules = 0;
  bool operator==(const KeptModules&) const = default;
};

/// Modules of a string that follow each other.
struct StringStretch {
  std::span<const core::ModuleTypeId> types;
  std::span<const double> parameters;  // of these modules
  std::uint64_t first = 0;             // the number of the first of them
};

/// The part of a plant's string that is unchanged from an older one: runs of modules that are as they were. All other
/// modules may have changed. A step, the answers to queries, an edit or a restore each yield such a value, and the
/// values of several changes in a row join into one (`then`). It refers to no string.
class StepChanges {
 public:
  /// Modules; a shorter run between two changes costs more than it saves, and may be left out.
  static constexpr std::uint64_t kShortestRun = 32;

  /// Everything may have changed.
  StepChanges() = default;
  /// Nothing changed in a string of so many modules.
  [[nodiscard]] static StepChanges nothing(std::uint64_t modules);
  /// Compares two strings of one Program from both ends. `arity`: by module type. O(bytes) of what is equal.
  [[nodiscard]] static StepChanges between(const ModuleString& older, const ModuleString& newer,
                                           std::span<const std::uint16_t> arity);
  /// In a string of so many modules, parameters of these (rising, repeats allowed) or of the module behind each of them
  /// may have changed.
  [[nodiscard]] static StepChanges ofParameters(std::span<const std::uint64_t> modules, std::uint64_t moduleCount);

  /// These modules are as they were. They come behind those of the calls before, in both strings.
  void keep(std::uint64_t from, std::uint64_t to, std::uint64_t modules);
  /// `older` has become `newer`: keeps the modules at both ends that are equal, bit by bit. They come behind those of
  /// the calls before. `arity`: by module type.
  void keepEqualEnds(const StringStretch& older, const StringStretch& newer, std::span<const std::uint16_t> arity);
  /// Everything may have changed again; the memory stays.
  void clear() { kept_.clear(); }
  /// Both changes as one, `next` being the later one.
  [[nodiscard]] StepChanges then(const StepChanges& next) const;
  /// The same into `result`, which is neither of them.
  void join(const StepChanges& next, StepChanges& result) const;

  /// Ascending in both strings.
  [[nodiscard]] const std::vector<KeptModules>& kept() const { return kept_; }

  bool operator==(const StepChanges&) const = default;

 private:
  std::vector<KeptModules> kept_;
};

}  // namespace espalier::derivation
