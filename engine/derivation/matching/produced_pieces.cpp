#include "engine/derivation/matching/produced_pieces.h"

namespace espalier::derivation {

void ProducedPieces::clear() {
  modules_.clear();
  pieces_.clear();
}

void ProducedPieces::begin() {
  pieces_.push_back({modules_.size(), modules_.parameterCount()});
}

void ProducedPieces::dropBefore(std::uint64_t count) {
  // keep them as empty pieces, so that every old module has a piece
  const std::size_t firstDropped = pieces_.size() - 1 - count;
  const Piece first = pieces_[firstDropped];
  for (std::size_t i = firstDropped; i < pieces_.size(); ++i) {
    pieces_[i] = first;
  }
  modules_.typeBuffer().resize(first.firstModule);
  modules_.parameterBuffer().resize(first.firstParameter);
}

std::uint64_t ProducedPieces::endModule(std::size_t piece) const {
  return piece + 1 < pieces_.size() ? pieces_[piece + 1].firstModule : modules_.size();
}

void ProducedPieces::appendTo(ModuleString& string) const {
  for (std::size_t i = pieces_.size(); i-- > 0;) {
    const Piece& piece = pieces_[i];
    const std::uint64_t endParameter =
        i + 1 < pieces_.size() ? pieces_[i + 1].firstParameter : modules_.parameterCount();
    string.appendAll(modules_.types().subspan(piece.firstModule, endModule(i) - piece.firstModule),
                     modules_.parameters().subspan(piece.firstParameter, endParameter - piece.firstParameter));
  }
}

void ProducedPieces::settle(Cursor& cursor) const {
  // behind the end of a piece comes the piece that was made before it
  while (cursor.piece > 0 && cursor.module == endModule(cursor.piece - 1)) {
    --cursor.piece;
    if (cursor.piece > 0) {
      cursor.module = pieces_[cursor.piece - 1].firstModule;
      cursor.offset = pieces_[cursor.piece - 1].firstParameter;
    }
  }
}

void ProducedPieces::advance(const language::Program& program, Cursor& cursor) const {
  cursor.offset += program.arity[modules_.types()[cursor.module]];
  ++cursor.module;
  settle(cursor);
}

bool ProducedPieces::skipBranch(const language::Program& program, Cursor& cursor) const {
  std::uint64_t depth = 0;
  while (cursor.piece > 0) {
    const core::ModuleTypeId type = modules_.types()[cursor.module];
    advance(program, cursor);
    if (type == program.openBranch) {
      ++depth;
    } else if (type == program.closeBranch && --depth == 0) {
      return true;
    }
  }
  return false;
}

bool ProducedPieces::matchesRight(const language::Program& program, const ContextRules& rules,
                                  std::span<const language::ContextElement> context, double* frame) const {
  // the last piece is still being made: the search starts behind it
  if (pieces_.size() < 2) {
    return false;
  }
  const Piece& nearest = pieces_[pieces_.size() - 2];
  Cursor cursor{pieces_.size() - 1, nearest.firstModule, nearest.firstParameter};
  settle(cursor);
  for (const language::ContextElement& element : context) {
    const bool isBranchEnd = element.kind == language::ContextElement::Kind::SkipToBranchEnd;
    while (true) {
      if (cursor.piece == 0) {
        return false;
      }
      const core::ModuleTypeId type = modules_.types()[cursor.module];
      if (isBranchEnd && type == program.closeBranch) {
        break;
      }
      const bool isIgnored = rules.isIgnored(type);
      if (type == program.openBranch &&
          (isBranchEnd || (!isIgnored && element.kind != language::ContextElement::Kind::OpenBranch))) {
        if (!skipBranch(program, cursor)) {
          return false;
        }
        continue;
      }
      if (isBranchEnd || isIgnored) {
        advance(program, cursor);
        continue;
      }
      if (type != element.module.type) {
        return false;
      }
      for (std::size_t i = 0; i < program.arity[type]; ++i) {
        frame[element.module.firstSlot + i] = modules_.parameters()[cursor.offset + i];
      }
      advance(program, cursor);
      break;
    }
  }
  return true;
}

}  // namespace espalier::derivation
