#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace espalier::core {

/// Byte offsets [begin, end) into the preprocessed text of a model. SourceMap (engine/language) resolves them.
struct SourceRange {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;

  constexpr bool operator==(const SourceRange&) const = default;
};

/// A place in a file as a person names it.
struct SourceLocation {
  std::string file;          // as the user named it; empty: no place is known
  std::uint32_t line = 0;    // 1-based
  std::uint32_t column = 0;  // 1-based, in bytes
  std::uint32_t length = 1;  // bytes to underline, at least 1, never beyond the line
  std::string lineText;      // the physical line without its newline
  std::string expansion;     // "in the expansion of R (tree.l:3:9)"; empty outside macros

  bool operator==(const SourceLocation&) const = default;
};

enum class Severity : std::uint8_t { Error, Warning, Note };

/// A message about source text or configuration, with advice. Never thrown.
struct Diagnostic {
  Severity severity = Severity::Error;
  std::string message;  // one sentence without a final full stop
  SourceLocation location;
  std::string hint;  // empty: none

  bool operator==(const Diagnostic&) const = default;
};

/// The text form:
///
///     tree.l:12:33: error: unknown name 'ww' in the successor of A(l,w)
///        12 | A(l,w) : l > 1 --> F(l)[+A(l*R, ww)]A(l*R, w)
///           |                                 ^~
///        hint: did you mean 'w'?
///
/// without a final newline. TABs of the source line are kept so that the caret stays below its column.
[[nodiscard]] std::string formatDiagnostic(const Diagnostic& diagnostic);

/// Collects diagnostics, at most `kLimit` errors and `kLimit` warnings; further ones are counted, not kept.
class DiagnosticList {
 public:
  static constexpr std::size_t kLimit = 50;

  void add(Diagnostic diagnostic);
  [[nodiscard]] bool hasErrors() const { return errorCount_ > 0; }
  [[nodiscard]] std::size_t errorCount() const { return errorCount_; }
  [[nodiscard]] std::size_t warningCount() const { return warningCount_; }
  [[nodiscard]] const std::vector<Diagnostic>& entries() const { return entries_; }

 private:
  std::vector<Diagnostic> entries_;
  std::size_t errorCount_ = 0;
  std::size_t warningCount_ = 0;
};

/// The name among `candidates` nearest to `name` by edit distance (insertion, deletion, substitution, transposition of
/// neighbours; letter case counts half), or an empty string when none is near enough (distance above a third of the
/// length, at least 1). Ties go to the first candidate. O(candidates * length^2).
[[nodiscard]] std::string_view nearestName(std::string_view name, const std::vector<std::string_view>& candidates);

/// "Did you mean 'chiba'? Available: chiba, clover." or only the list when no name is near. Names are listed as given.
[[nodiscard]] std::string suggestName(std::string_view name, const std::vector<std::string_view>& candidates);

}  // namespace espalier::core
