#include "engine/files/curves/function_file.h"

#include <array>
#include <string>
#include <string_view>
#include <utility>

namespace espalier::files {
namespace {

constexpr int kLeastControlPoints = 4;
constexpr int kOldSamplesOfSets = 100;  // of a function in the old format

/// Reads one function of a file, line by line, and warns about the first mistake.
class FunctionReader {
 public:
  FunctionReader(const DataFile& file, TextCursor& cursor) : file_(file), cursor_(cursor) {}

  std::optional<SplineFunction> read(std::optional<int> oldSampleCount) {
    if (cursor_.rest().starts_with("range")) {
      return readOld(oldSampleCount.value_or(0));
    }
    return readVersion11();
  }

 private:
  std::optional<SplineFunction> readVersion11() {
    const std::size_t begin = cursor_.position();
    TextCursor first = cursor_.takeLine();
    const TextCursor version = first;
    if (!first.takeKeywords("fver 1 1") || !first.atLineEnd()) {
      if (version.atLineEnd() && !cursor_.atEnd()) {
        file_.warn({static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(begin) + 1},
                   "expected 'fver 1 1' while reading a function file, found an empty line",
                   "a function file has no empty lines; this function is 0 everywhere");
        return std::nullopt;
      }
      if (version.rest().starts_with("fver ")) {
        constexpr std::size_t kLongest = 40;
        file_.warn({static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(begin + version.rest().size())},
                   "expected version 'fver 1 1' while reading a function file, found '" +
                       std::string(version.rest().substr(0, kLongest)) + "'",
                   "this function is 0 everywhere");
        return std::nullopt;
      }
      return fail(version, "'fver 1 1'", "a function file",
                  "a function begins with 'fver 1 1', or in the old format with 'range: 0 1'");
    }
    TextCursor nameLine = cursor_.takeLine();
    if (!nameLine.takeKeywords("name: ")) {
      return fail(nameLine, "'name:'", "a function");
    }
    name_ = nameLine.word();
    TextCursor samplesLine = cursor_.takeLine();
    const std::size_t samplesBegin = samplesLine.position();
    if (!samplesLine.takeKeywords("samples: ")) {
      return fail(samplesLine, "'samples:'", context());
    }
    const std::optional<int> samples = samplesLine.integer();
    if (!samples) {
      return fail(samplesLine, "an integer after 'samples:'", context());
    }
    const int sampleCount = boundedSampleCount(file_, samplesLine.rangeFrom(samplesBegin), *samples);
    if (!skipEditorLines()) {
      return std::nullopt;
    }
    TextCursor flip = cursor_.takeLine();
    if (!flip.takeKeywords("flip:")) {
      return fail(flip, "'flip:'", context());
    }
    return readPoints(sampleCount);
  }

  std::optional<SplineFunction> readOld(int sampleCount) {
    // the range is ignored: the domain is always [0, 1]
    TextCursor range = cursor_.takeLine();
    return readPoints(boundedSampleCount(file_, range.rangeFrom(range.position()), sampleCount));
  }

  /// `background:` and `backgroundXY:`, `markers: k` and its k lines.
  bool skipEditorLines() {
    if (cursor_.peek() == 'b') {
      (void)cursor_.takeLine();
      (void)cursor_.takeLine();
    }
    if (cursor_.peek() == 'm') {
      TextCursor line = cursor_.takeLine();
      const std::optional<int> count = line.takeKeywords("markers: ") ? line.integer() : std::nullopt;
      if (!count) {
        (void)fail(line, "'markers:' with a count", context());
        return false;
      }
      for (int i = 0; i < *count && !cursor_.atEnd(); ++i) {
        (void)cursor_.takeLine();
      }
    }
    return true;
  }

  std::optional<SplineFunction> readPoints(int sampleCount) {
    TextCursor line = cursor_.takeLine();
    const std::size_t lineBegin = line.position();
    const std::optional<int> count = line.takeKeywords("points: ") ? line.integer() : std::nullopt;
    if (!count) {
      return fail(line, "'points:' with a count", context());
    }
    // the number of lines counts, without multiplicities
    if (*count < kLeastControlPoints) {
      file_.warn(line.rangeFrom(lineBegin), "a function needs at least 4 lines of points, " + context() + " has " +
                                                std::to_string(*count) + "; it is 0 everywhere");
      return std::nullopt;
    }
    std::vector<std::array<double, 2>> points;
    bool hasFallen = false;
    for (int i = 0; i < *count; ++i) {
      const std::size_t pointBegin = cursor_.position();
      if (!readPoint(points)) {
        return std::nullopt;
      }
      const std::size_t last = points.size() - 1;
      if (points.size() > 1 && !hasFallen && points[last][0] < points[last - 1][0]) {
        hasFallen = true;
        file_.warn({static_cast<std::uint32_t>(pointBegin), static_cast<std::uint32_t>(pointBegin) + 1},
                   "x of " + context() + " falls here", "x goes from 0 to 1; values near a fall are arbitrary");
      }
    }
    if (!points.empty() && (points.front()[0] != 0.0 || points.back()[0] != 1.0)) {
      file_.warn(line.rangeFrom(lineBegin), "x of " + context() + " does not go from 0 to 1",
                 "func() takes x from 0 to 1, whatever the points are");
    }
    if (points.size() < kLeastControlPoints) {
      file_.warn(line.rangeFrom(lineBegin), context() + " has fewer than 4 points; it is 0 everywhere");
      return std::nullopt;
    }
    return SplineFunction(name_, std::move(points), sampleCount);
  }

  bool readPoint(std::vector<std::array<double, 2>>& points) {
    TextCursor line = cursor_.takeLine();
    const std::size_t begin = line.position();
    std::array<double, 2> point{};
    for (double& coordinate : point) {
      line.skipBlanks();
      const std::optional<double> number = line.number();
      if (!number) {
        (void)fail(line, "two numbers of a point", context());
        return false;
      }
      coordinate = *number;
    }
    if (line.peek() == ',') {
      file_.warnExpected(line, "a blank between the numbers of a point", context(),
                         "write numbers with a point, as 0.9");
    }
    line.skipBlanks();
    const int multiplicity = line.integer().value_or(1);
    const std::size_t count = multiplicity > 0 ? static_cast<std::size_t>(multiplicity) : 0;
    if (count > kMostPoints - points.size()) {
      file_.warn(line.rangeFrom(begin),
                 context() + " has more than " + std::to_string(kMostPoints) + " points; it is 0 everywhere");
      return false;
    }
    if (!file_.spendPoints(count)) {
      file_.warn(line.rangeFrom(begin),
                 "the files of one view file have too many points; " + context() + " is 0 everywhere");
      return false;
    }
    points.insert(points.end(), count, point);
    return true;
  }

  [[nodiscard]] std::string context() const { return name_.empty() ? "a function" : "function '" + name_ + "'"; }

  std::optional<SplineFunction> fail(const TextCursor& at, const std::string& expected, const std::string& context,
                                     std::string hint = "this function is 0 everywhere") {
    file_.warnExpected(at, expected, context, std::move(hint));
    return std::nullopt;
  }

  const DataFile& file_;
  TextCursor& cursor_;
  std::string name_;
};

/// Goes to the next line that begins a function.
void skipToNextItem(TextCursor& cursor) {
  while (!cursor.atEnd() && !cursor.rest().starts_with("fver") && !cursor.rest().starts_with("range")) {
    (void)cursor.takeLine();
  }
}

}  // namespace

SplineFunction zeroFunction() {
  return SplineFunction({}, std::vector<std::array<double, 2>>(kLeastControlPoints), 0);
}

SplineFunction readFunctionFile(const DataFile& file, std::optional<int> sampleCount) {
  TextCursor cursor = file.cursor();
  std::optional<SplineFunction> function = FunctionReader(file, cursor).read(sampleCount);
  return function ? std::move(*function) : zeroFunction();
}

std::vector<SplineFunction> readFunctionSet(const DataFile& file, core::Compatibility compatibility) {
  std::vector<SplineFunction> functions;
  TextCursor cursor = file.cursor();
  TextCursor first = cursor.takeLine();
  if (!first.takeKeywords("funcgalleryver 1 1")) {
    file.warnExpected(first, "'funcgalleryver 1 1'", "a function set");
    return functions;
  }
  TextCursor itemsLine = cursor.takeLine();
  const std::optional<int> count = itemsLine.takeKeywords("items: ") ? itemsLine.integer() : std::nullopt;
  if (!count) {
    file.warnExpected(itemsLine, "'items:' with a count", "a function set");
    return functions;
  }
  for (int i = 0; i < *count; ++i) {
    if (cursor.atEnd()) {
      file.warnExpected(cursor, "function " + std::to_string(i + 1) + " of " + std::to_string(*count), "a function set",
                        "correct the count after 'items:'");
      break;
    }
    // a function that becomes 0 takes memory, too
    if (!file.spendPoints(kLeastControlPoints)) {
      file.warnExpected(cursor, "fewer points", "the files of one view file");
      break;
    }
    std::optional<SplineFunction> function = FunctionReader(file, cursor).read(kOldSamplesOfSets);
    if (!function && compatibility == core::Compatibility::Espalier) {
      skipToNextItem(cursor);
    }
    functions.push_back(function ? std::move(*function) : zeroFunction());
  }
  return functions;
}

}  // namespace espalier::files
