#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/derivation/state/byte_tables.h"

namespace espalier::derivation {

/// Finds the modules of a stretch that tables by module type mark, and counts the parameters before each of them. It
/// finds the brackets of a string, or the modules that productions may change. It takes sixteen modules at a time where
/// the processor has AVX2 and the model has at most 64 module types of at most 15 parameters. Results are equal
/// everywhere.
class ModuleFinder {
 public:
  /// Bits by module type. A module is found when one bit is set for its own type, for the type before it and for the
  /// type behind it. `before` and `behind` both empty: neighbours do not matter.
  struct Marks {
    std::vector<std::uint8_t> own;
    std::vector<std::uint8_t> before;
    std::vector<std::uint8_t> behind;
  };
  /// Receives the found modules. Each array needs room for kSlack more.
  struct Target {
    std::uint32_t* modules = nullptr;  // counted from the first module of the stretch
    std::uint32_t* offsets = nullptr;  // parameters before the module, counted from the stretch's first
    std::uint8_t* bits = nullptr;      // the bits in common
  };
  struct Count {
    std::size_t found = 0;
    std::uint32_t parameters = 0;  // of all modules of the stretch
  };
  static constexpr std::size_t kSlack = 16;

  /// `arity` by module type, of the Program; it must outlive the object.
  ModuleFinder(std::span<const std::uint16_t> arity, Marks marks);

  /// Looks through `count` modules from `types` on. When neighbours matter, `hasBefore` and `hasBehind` say that
  /// types[-1] and types[count] can be read; a missing neighbour counts as one with all bits.
  [[nodiscard]] Count find(const core::ModuleTypeId* types, std::uint32_t count, bool hasBefore, bool hasBehind,
                           const Target& target) const;
  /// The same without vector instructions.
  [[nodiscard]] Count findSlowly(const core::ModuleTypeId* types, std::uint32_t count, bool hasBefore, bool hasBehind,
                                 const Target& target) const;

 private:
  /// The tables of the vector loop.
  struct ByteTables {
    ByteTable own{};
    ByteTable before{};
    ByteTable behind{};
    ByteTable arity{};
  };
  friend struct VectorFinder;

  void findOne(const core::ModuleTypeId* types, std::uint32_t module, bool hasBefore, bool hasBehind,
               const Target& target, Count& count) const;
  void findAll(const core::ModuleTypeId* types, std::uint32_t begin, std::uint32_t end, const Target& target,
               Count& count) const;

  std::span<const std::uint16_t> arity_;
  Marks marks_;
  bool looksAround_;
  std::uint32_t blockCount_ = 0;  // of 16 types in the byte tables, 1, 2 or 4; 0: no vector instructions
  ByteTables tables_;
};

}  // namespace espalier::derivation
