#pragma once

#include <cstddef>
#include <string>

#include "engine/core/diagnostic.h"
#include "engine/files/source_map.h"
#include "engine/files/text_cursor.h"

namespace espalier::language {

/// Bounds of what the readers of a model folder's files accept, so that a number in a file cannot ask for more memory
/// than its text is worth by more than a fixed factor.
inline constexpr std::size_t kMostPoints = 100'000;  // of one function, curve or contour, multiplicities counted
inline constexpr int kMostSamples = 10'000;          // of one function or curve

/// What is left for all files of one view file together.
struct ReadingBudget {
  std::size_t points = 1'000'000;
  std::size_t samples = 500'000;
};

/// A file that a view file names, while it is read.
class DataFile {
 public:
  /// `diagnostics` and `budget` must outlive the object; without a budget only the bounds of one item hold.
  DataFile(std::string name, std::string text, core::DiagnosticList& diagnostics, ReadingBudget* budget = nullptr)
      : map_(plainSourceMap(std::move(name), std::move(text))), diagnostics_(&diagnostics), budget_(budget) {}

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
  /// Takes points or samples from the budget; false, and nothing taken, when it has fewer.
  [[nodiscard]] bool spendPoints(std::size_t count) const;
  [[nodiscard]] bool spendSamples(std::size_t count) const;

 private:
  SourceMap map_;
  core::DiagnosticList* diagnostics_;
  ReadingBudget* budget_;
};

/// The sample count within 0 .. kMostSamples, with a warning at `range` when it was larger; 0, with a warning, when the
/// budget has not so many.
[[nodiscard]] int boundedSampleCount(const DataFile& file, core::SourceRange range, int count);

}  // namespace espalier::language
