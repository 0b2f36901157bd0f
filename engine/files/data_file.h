#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "engine/core/diagnostic.h"
#include "engine/files/source_map.h"
#include "engine/files/text_cursor.h"
#include "engine/files/utf8.h"

namespace espalier::files {

/// Bounds of the readers, so that a number in a short file cannot ask for unlimited memory.
inline constexpr std::size_t kMostPoints = 100'000;  // of one function, curve or contour, multiplicities counted
inline constexpr int kMostSamples = 10'000;          // of one function or curve

/// The amounts that all files of one view file may still use together.
struct ReadingBudget {
  std::size_t points = 1'000'000;
  std::size_t samples = 500'000;
};

/// A text file of a model folder, while it is read.
class DataFile {
 public:
  /// `bytes` are the file as stored; every encoding of asUtf8 is accepted. `diagnostics` and `budget` must outlive the
  /// object; without a budget only the bounds of one item hold.
  DataFile(std::string name, std::string_view bytes, core::DiagnosticList& diagnostics, ReadingBudget* budget = nullptr)
      : map_(plainSourceMap(std::move(name), asUtf8(bytes))), diagnostics_(&diagnostics), budget_(budget) {}

  [[nodiscard]] const std::string& name() const { return map_.files.front().name; }
  [[nodiscard]] const std::string& text() const { return map_.files.front().text; }
  [[nodiscard]] TextCursor cursor() const { return TextCursor(text()); }
  void warn(core::SourceRange range, std::string message, std::string hint = {}) const {
    TextReport(map_, *diagnostics_).warn(range, std::move(message), std::move(hint));
  }
  /// A remark about a part that is correct but not used.
  void note(core::SourceRange range, std::string message) const {
    TextReport(map_, *diagnostics_).note(range, std::move(message));
  }
  /// "expected EXPECTED while reading CONTEXT, found …" at the cursor.
  void warnExpected(const TextCursor& at, const std::string& expected, const std::string& context,
                    std::string hint = {}) const;
  /// Takes points or samples from the budget. When it has fewer: false, and the budget stays.
  [[nodiscard]] bool spendPoints(std::size_t count) const;
  [[nodiscard]] bool spendSamples(std::size_t count) const;

 private:
  SourceMap map_;
  core::DiagnosticList* diagnostics_;
  ReadingBudget* budget_;
};

/// The sample count, at most kMostSamples: a larger one gives a warning at `range`. 0, with a warning, when the budget
/// has too few samples left.
[[nodiscard]] int boundedSampleCount(const DataFile& file, core::SourceRange range, int count);

}  // namespace espalier::files
