#include "engine/derivation/matching/produced_pieces.h"

#include <utility>

#include "engine/core/check.h"

namespace espalier::derivation {

void ProducedPieces::clear() {
  modules_.clear();
  pieces_.clear();
  pieceNumber_ = 0;
  ends_.clear();
  branchBehind_.clear();
  for (auto& shortcuts : shortcuts_) {
    shortcuts.clear();
  }
}

void ProducedPieces::begin() {
  Piece next{modules_.size(), modules_.parameterCount(), 0, 0, ++pieceNumber_, 1};
  if (!pieces_.empty()) {
    const Piece& last = pieces_.back();
    next.behind = last.firstModule < modules_.size() ? pieces_.size() : last.behind;
    next.enclosingEnds = linkLast();
  }
  pieces_.push_back(next);
}

std::size_t ProducedPieces::linkLast() {
  const Piece& piece = pieces_.back();
  const std::span<const core::ModuleTypeId> types = std::as_const(modules_).types();
  std::size_t innermost = piece.enclosingEnds;
  std::uint64_t offset = modules_.parameterCount();
  for (std::uint64_t module = types.size(); module-- > piece.firstModule;) {
    const core::ModuleTypeId type = types[module];
    if (type == program_->closeBranch) {
      ends_.push_back({settled({pieces_.size(), module + 1, offset}), innermost});
      innermost = ends_.size();
    } else if (type == program_->openBranch) {
      // a bracket without partner has no branch to pass
      branchBehind_.erase(module);
      if (innermost > 0) {
        branchBehind_.emplace(module, ends_[innermost - 1].behind);
        innermost = ends_[innermost - 1].outside;
      }
    }
    offset -= program_->arity[type];
  }
  return innermost;
}

void ProducedPieces::dropBefore(std::uint64_t count) {
  pieces_.pop_back();
  Piece dropped{modules_.size(), modules_.parameterCount(), 0, 0, 0, 0};
  while (dropped.oldModules < count) {
    const std::uint64_t before = dropped.oldModules;
    dropped = pieces_.back();
    dropped.oldModules += before;
    pieces_.pop_back();
  }
  ESPALIER_CHECK(dropped.oldModules == count);
  modules_.typeBuffer().resize(dropped.firstModule);
  modules_.parameterBuffer().resize(dropped.firstParameter);
  if (count > 0) {
    dropped.number = ++pieceNumber_;
    pieces_.push_back(dropped);
  }
  begin();
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

ProducedPieces::Cursor ProducedPieces::beginOf(std::size_t behind) const {
  return behind == 0 ? Cursor{} : Cursor{behind, pieces_[behind - 1].firstModule, pieces_[behind - 1].firstParameter};
}

ProducedPieces::Cursor ProducedPieces::settled(Cursor cursor) const {
  return cursor.module < endModule(cursor.piece - 1) ? cursor : beginOf(pieces_[cursor.piece - 1].behind);
}

bool ProducedPieces::move(const Move* moves, Cursor& cursor) const {
  if (cursor.piece == 0) {
    return false;
  }
  const core::ModuleTypeId type = modules_.types()[cursor.module];
  if (moves[type] == Move::Stop) {
    return false;
  }
  if (moves[type] == Move::Pass) {
    cursor = settled({cursor.piece, cursor.module + 1, cursor.offset + program_->arity[type]});
    return true;
  }
  const auto behind = branchBehind_.find(cursor.module);
  if (behind == branchBehind_.end()) {
    return false;
  }
  cursor = behind->second;
  return true;
}

ProducedPieces::Cursor ProducedPieces::follow(SearchKind kind, const Move* moves, Cursor cursor) {
  std::unordered_map<std::uint64_t, Cursor>& shortcuts = shortcuts_[static_cast<std::size_t>(kind)];
  passed_.clear();
  do {
    const std::uint64_t key = keyOf(cursor);
    if (isMark(cursor)) {
      const auto known = shortcuts.find(key);
      if (known != shortcuts.end()) {
        cursor = known->second;
        break;
      }
      passed_.push_back(key);
    }
  } while (move(moves, cursor) && cursor.piece > 0);
  for (const std::uint64_t key : passed_) {
    shortcuts.emplace(key, cursor);
  }
  return cursor;
}

bool ProducedPieces::matchesRight(const ContextRules& rules, std::span<const language::ContextElement> context,
                                  double* frame) {
  // the last piece is still being made: the search starts behind it
  Cursor cursor = pieces_.empty() ? Cursor{} : beginOf(pieces_.back().behind);
  for (const language::ContextElement& element : context) {
    const SearchKind kind = searchKind(element.kind);
    const Move* const moves = rules.moves(kind);
    for (std::uint32_t passed = 1; move(moves, cursor); ++passed) {
      if (passed > SearchShortcuts::kNearModules && cursor.piece > 0 && isMark(cursor)) {
        cursor = follow(kind, moves, cursor);
        passed = 0;
      }
    }
    if (cursor.piece == 0) {
      return false;
    }
    const core::ModuleTypeId type = modules_.types()[cursor.module];
    if (kind == SearchKind::RightBranchEnd) {
      if (type != program_->closeBranch) {
        return false;
      }
      continue;
    }
    if (type != element.module.type) {
      return false;
    }
    for (std::size_t i = 0; i < program_->arity[type]; ++i) {
      frame[element.module.firstSlot + i] = modules_.parameters()[cursor.offset + i];
    }
    cursor = settled({cursor.piece, cursor.module + 1, cursor.offset + program_->arity[type]});
  }
  return true;
}

}  // namespace espalier::derivation
