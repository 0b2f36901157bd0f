#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/core/identifiers.h"
#include "engine/language/program.h"

namespace espalier::language {

/// The only parameter name of a module that is declared with `(...)`: it has any number of parameters.
inline constexpr std::string_view kAnyParameters = "...";

/// Most declared names of a model: with the characters, their numbers fit into SymbolId.
inline constexpr std::size_t kMostDeclaredNames = core::kNoSymbol - 128;

/// Interns Symbols and module types while a model is read, in the order of their first use.
class SymbolTable {
 public:
  SymbolTable() { characters_.fill(core::kNoSymbol); }

  /// The symbol of a 7-bit character.
  core::SymbolId internCharacter(char character);

  /// Declares a named module; false when the name is declared already. `*id` is its symbol in both cases.
  bool declare(Symbol symbol, core::SymbolId* id);

  /// The longest declared name that `text` starts with, or kNoSymbol. O(lengths of names · log names).
  [[nodiscard]] core::SymbolId longestDeclared(std::string_view text) const;

  /// The type of (symbol, arity), or kNoModuleType when there are too many.
  core::ModuleTypeId internType(core::SymbolId symbol, std::uint16_t arity);

  [[nodiscard]] std::size_t declaredCount() const { return declared_.size(); }

  [[nodiscard]] const std::vector<Symbol>& symbols() const { return symbols_; }
  [[nodiscard]] const std::vector<ModuleType>& types() const { return types_; }
  [[nodiscard]] const Symbol& operator[](core::SymbolId symbol) const { return symbols_[symbol]; }

 private:
  std::vector<Symbol> symbols_;
  std::vector<ModuleType> types_;
  std::array<core::SymbolId, 128> characters_{};                 // symbol of each one-character name, or kNoSymbol
  std::map<std::string, core::SymbolId, std::less<>> declared_;  // by name
  std::set<std::size_t, std::greater<>> declaredLengths_;        // of the names
  std::map<std::pair<core::SymbolId, std::uint16_t>, core::ModuleTypeId> typeIndex_;
};

}  // namespace espalier::language
