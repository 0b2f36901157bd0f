#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "engine/core/vec3.h"
#include "engine/language/dialects/text_lines.h"
#include "engine/language/dialects/translation.h"

namespace espalier::language {

/// The objects of Turtle Painter: `p(x)`, the user's object (`object p: leaf.obj 0.5`) or our leaf, scaled by x; `o`, a
/// fruit (`object o: ...`, or a ball); F(d,s), a stem of length d and thickness s; and the constant vector
/// (`vector: 0, -0.1, 0`) that moves everything drawn.
class PainterObjects {
 public:
  PainterObjects(bool isActive, DialectReport& report) : isActive_(isActive), report_(report) {}

  [[nodiscard]] bool isActive() const { return isActive_; }
  /// Reads `object ...` and `vector: ...`; false: the statement is neither.
  [[nodiscard]] bool reads(const TextPiece& statement);
  void addDrawing(const std::set<char>& plainSymbols, CpfgModel& model) const;

 private:
  void readObject(const TextPiece& value, std::size_t offset);
  void readVector(const TextPiece& value);

  bool isActive_;
  DialectReport& report_;
  std::string leaf_;   // file and scale of `p`; empty: our leaf
  std::string fruit_;  // of `o`
  std::optional<core::Vec3> vector_;
};

/// Whether a statement is `object ...` or `vector: ...`.
[[nodiscard]] bool isPainterStatement(std::string_view statement);

}  // namespace espalier::language
