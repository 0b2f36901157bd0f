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

/// A place in a file, in the terms of a text editor.
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
/// without a final newline. TABs of the source line stay TABs, so that the caret stands below its column.
[[nodiscard]] std::string formatDiagnostic(const Diagnostic& diagnostic);

/// Collects diagnostics. Keeps at most `kLimit` errors and `kLimit` warnings, and only counts the rest.
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

/// The candidate nearest to `name` by edit distance (insertion, deletion, substitution, transposition of neighbours; a
/// change of letter case counts half). Empty when every distance is above a third of the length (at least 1). The first
/// of equally near candidates wins. O(candidates * length^2).
[[nodiscard]] std::string_view nearestName(std::string_view name, const std::vector<std::string_view>& candidates);

/// "Did you mean 'chiba'? Available: chiba, clover.", or only the list, in its order, when no candidate is near.
[[nodiscard]] std::string suggestName(std::string_view name, const std::vector<std::string_view>& candidates);

}  // namespace espalier::core
