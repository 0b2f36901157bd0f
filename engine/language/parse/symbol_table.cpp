#include "engine/language/parse/symbol_table.h"

#include <utility>

namespace espalier::language {

core::SymbolId SymbolTable::internCharacter(char character) {
  core::SymbolId& symbol = characters_[static_cast<unsigned char>(character) & 0x7FU];
  if (symbol == core::kNoSymbol) {
    symbol = static_cast<core::SymbolId>(symbols_.size());
    symbols_.push_back({std::string(1, character), false, false, {}});
  }
  return symbol;
}

bool SymbolTable::declare(Symbol symbol, core::SymbolId* id) {
  if (const auto known = declared_.find(symbol.name); known != declared_.end()) {
    *id = known->second;
    return false;
  }
  if (symbol.name.size() == 1) {
    // the character may be used already
    *id = internCharacter(symbol.name[0]);
  } else {
    *id = static_cast<core::SymbolId>(symbols_.size());
    symbols_.emplace_back();
  }
  declared_.emplace(symbol.name, *id);
  declaredLengths_.insert(symbol.name.size());
  symbols_[*id] = std::move(symbol);
  return true;
}

core::SymbolId SymbolTable::longestDeclared(std::string_view text) const {
  for (const std::size_t length : declaredLengths_) {
    if (const auto found = declared_.find(text.substr(0, length)); found != declared_.end()) {
      return found->second;
    }
  }
  return core::kNoSymbol;
}

core::ModuleTypeId SymbolTable::internType(core::SymbolId symbol, std::uint16_t arity) {
  const auto [place, isNew] =
      typeIndex_.emplace(std::pair{symbol, arity}, static_cast<core::ModuleTypeId>(types_.size()));
  if (isNew) {
    if (types_.size() >= core::kNoModuleType) {
      typeIndex_.erase(place);
      return core::kNoModuleType;
    }
    types_.push_back({symbol, arity});
  }
  return place->second;
}

}  // namespace espalier::language
