#pragma once

#include <cstddef>
#include <string>

#include "engine/core/diagnostic.h"
#include "engine/language/source_map.h"
#include "engine/language/text_cursor.h"

namespace espalier::language {

/// Bounds of what the readers of a model folder's files accept, so that a number in a file cannot ask for more memory than
/// its text is worth by more than a fixed factor.
inline constexpr std::size_t kMostPoints = 100'000;  // of one function, curve or contour, multiplicities counted
inline constexpr int kMostSamples = 10'000;            // of one function or curve

/// A file that a view file names, while it is read.
class DataFile {
 public:
  /// `diagnostics` must outlive the object.
  DataFile(std::string name, std::string text, core::DiagnosticList& diagnostics)
      : map_(plainSourceMap(std::move(name), std::move(text))), diagnostics_(&diagnostics) {}

  [[nodiscard]] const std::string& name() const { return map_.files.front().name; }
  [[nodiscard]] const std::string& text() const { return map_.files.front().text; }
  [[nodiscard]] TextCursor cursor() const { return TextCursor(text()); }
  void warn(core::SourceRange range, std::string message, std::string hint = {}) const {
    TextReport(map_, *diagnostics_).warn(range, std::move(message), std::move(hint));
  }
  /// A remark about something that is not wrong, but not used.
  void note(core::SourceRange range, std::string message) const {
    TextReport(map_, *diagnostics_).note(range, std::move(message));
  }
  /// "expected EXPECTED while reading CONTEXT, found …" at the cursor.
  void warnExpected(const TextCursor& at, const std::string& expected, const std::string& context,
                    std::string hint = {}) const;

 private:
  SourceMap map_;
  core::DiagnosticList* diagnostics_;
};

/// The sample count within 0 .. kMostSamples, with a warning at `range` when it was larger.
[[nodiscard]] int boundedSampleCount(const DataFile& file, core::SourceRange range, int count);

}  // namespace espalier::language
