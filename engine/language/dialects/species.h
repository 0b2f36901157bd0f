#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/language/dialects/dialect.h"

namespace espalier::language {

/// The species tables of the forest of Rodrigues, Coelho & Alencar, with Portuguese or English labels:
/// `Espécie 6`, `Variáveis:`, `Constantes:`, `Axioma:`, `Regras: F -> F[+F]F, F -> F[-F]F`. In each generation one rule
/// of each variable is drawn for the whole string, or with `Sorteio: módulo` for each module. + turns clockwise.
/// Our additions to the published form: `Passo: 4..8` (step), `Ângulo: 20..30` (degrees),
/// `Gerações: 4..5`, drawn once for a tree; and `Giro: 30`, the turn about the turtle's own axis where a branch opens.
[[nodiscard]] bool recognisesSpecies(std::string_view text);
[[nodiscard]] std::vector<DialectEntry> speciesEntries(std::string_view text);
[[nodiscard]] CpfgModel translateSpecies(std::string_view text, const std::string& entry, DialectReport& report);

}  // namespace espalier::language
