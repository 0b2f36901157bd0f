#pragma once

#include <cstdint>

namespace espalier::core {

/// A Symbol: the name of a module, interned per Program. A one-character name or a declared one (`Module: Apex(age)`).
using SymbolId = std::uint16_t;

/// A module type: (symbol, arity), interned per Program. `A(l)` and `A(l,w)` have different types.
using ModuleTypeId = std::uint16_t;

inline constexpr SymbolId kNoSymbol = 0xFFFF;
inline constexpr ModuleTypeId kNoModuleType = 0xFFFF;

/// The mode of a run (docs/language.md, section 0). Espalier: doubles, counter-based draws. Cpfg: as the reference
/// program in interactive use (32-bit parameters, two sequential random streams). CpfgBatch: as its batch run.
enum class Compatibility : std::uint8_t { Espalier, Cpfg, CpfgBatch };

}  // namespace espalier::core
