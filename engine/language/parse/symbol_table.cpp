#include "engine/language/parse/symbol_table.h"

#include <algorithm>

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
  const bool isCharacter = symbol.name.size() == 1;
  const auto known =
      std::find_if(symbols_.begin(), symbols_.end(), [&](const Symbol& other) { return other.name == symbol.name; });
  if (known != symbols_.end()) {
    *id = static_cast<core::SymbolId>(known - symbols_.begin());
    if (known->isDeclared) {
      return false;
    }
    // the character was used before it was declared
    *known = std::move(symbol);
  } else {
    *id = static_cast<core::SymbolId>(symbols_.size());
    if (isCharacter) {
      characters_[static_cast<unsigned char>(symbol.name[0]) & 0x7FU] = *id;
    }
    symbols_.push_back(std::move(symbol));
  }
  const auto place = std::find_if(declared_.begin(), declared_.end(), [&](core::SymbolId other) {
    return symbols_[other].name.size() < symbols_[*id].name.size();
  });
  declared_.insert(place, *id);
  return true;
}

core::SymbolId SymbolTable::longestDeclared(std::string_view text) const {
  const auto found = std::find_if(declared_.begin(), declared_.end(),
                                  [&](core::SymbolId symbol) { return text.starts_with(symbols_[symbol].name); });
  return found == declared_.end() ? core::kNoSymbol : *found;
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
