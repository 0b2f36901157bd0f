#include "clients/espalier/output/string_output.h"

#include <algorithm>
#include <cstdio>
#include <string>

#include "engine/core/number_text.h"
#include "engine/derivation/state/string_text.h"

namespace espalier::command {

void printString(const language::Program& program, const derivation::ModuleString& string) {
  constexpr std::size_t kPieceModules = 65'536;
  const core::NumberStyle style = derivation::numberStyle(program.compatibility);
  std::string text;
  derivation::ModuleString piece;
  std::size_t parameter = 0;
  const auto types = string.types();
  const auto parameters = string.parameters();
  for (std::size_t begin = 0; begin < types.size(); begin += kPieceModules) {
    // the modules of the piece with their parameters
    const auto pieceTypes = types.subspan(begin, std::min(kPieceModules, types.size() - begin));
    std::size_t parameterCount = 0;
    for (const core::ModuleTypeId type : pieceTypes) {
      parameterCount += program.arity[type];
    }
    piece.clear();
    piece.appendAll(pieceTypes, parameters.subspan(parameter, parameterCount));
    parameter += parameterCount;

    text.clear();
    derivation::appendText(text, program, piece, style);
    std::fwrite(text.data(), 1, text.size(), stdout);
  }
  std::fputc('\n', stdout);
}

}  // namespace espalier::command
