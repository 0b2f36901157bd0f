#include "engine/files/curves/contour_file.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

namespace espalier::files {
namespace {

using core::Vec3;

// a cubic segment of an open curve needs four points; a closed curve needs three
constexpr std::size_t kLeastOpen = 4;
constexpr std::size_t kLeastClosed = 3;

class ContourReader {
 public:
  ContourReader(const DataFile& file, Contour& contour) : file_(file), cursor_(file.cursor()), contour_(contour) {}

  bool read() {
    if (cursor_.takeKeywords("cver 1 ")) {
      TextCursor line = cursor_.takeLine();
      const TextCursor written = line;
      const int version = line.integer().value_or(0);
      if (version < 1 || version > 3) {
        return fail(written, "1, 2 or 3 behind 'cver 1'");
      }
      return readVersion(version) && checkCount();
    }
    return readPlain() && checkCount();
  }

 private:
  bool readVersion(int version) {
    TextCursor name = cursor_.takeLine();
    if (!name.takeKeywords("name:")) {
      return fail(name, "'name:'");
    }
    TextCursor points = cursor_.takeLine();
    const std::optional<int> count = points.takeKeywords("points: ") ? points.integer() : std::nullopt;
    if (!count) {
      return fail(points, "'points:' with a count");
    }
    TextCursor type = cursor_.takeLine();
    if (!type.takeKeywords("type: ")) {
      return fail(type, "'type:'");
    }
    const std::string_view word = type.rest();
    if (version > 1 && !word.starts_with('o') && !word.starts_with('c')) {
      return fail(type, "a type that begins with o (open) or c (closed)");
    }
    contour_.isClosed = version == 1 ? type.word() != "open" : word.starts_with('c');
    return (version < 3 || skipEditorLines()) && readPoints(*count, 3, true);
  }

  /// `samples:`, and the lines that an editor adds: the `background:` pair, `markers: k` and its k lines.
  bool skipEditorLines() {
    TextCursor samples = cursor_.takeLine();
    if (!samples.takeKeywords("samples:")) {
      return fail(samples, "'samples:'");
    }
    if (cursor_.peek() == 'b') {
      (void)cursor_.takeLine();
      (void)cursor_.takeLine();
    }
    if (cursor_.peek() == 'm') {
      TextCursor line = cursor_.takeLine();
      const std::optional<int> count = line.takeKeywords("markers: ") ? line.integer() : std::nullopt;
      if (!count) {
        return fail(line, "'markers:' with a count");
      }
      for (int i = 0; i < *count && !cursor_.atEnd(); ++i) {
        (void)cursor_.takeLine();
      }
    }
    return true;
  }

  /// `n dim open|closed`, without multiplicities.
  bool readPlain() {
    TextCursor line = cursor_.takeLine();
    const TextCursor first = line;
    line.skipBlanks();
    const std::optional<int> count = line.integer();
    line.skipBlanks();
    const std::optional<int> dimension = line.integer();
    if (!count || !dimension || *dimension < 2 || *dimension > 3) {
      return fail(first, "'cver 1 3', or a count, the dimension 2 or 3 and 'open' or 'closed'");
    }
    line.skipBlanks();
    contour_.isClosed = line.word() == "closed";
    return readPoints(*count, *dimension, false);
  }

  bool readPoints(int lineCount, int dimension, bool hasMultiplicity) {
    for (int i = 0; i < lineCount; ++i) {
      TextCursor line = cursor_.takeLine();
      const std::size_t begin = line.position();
      double numbers[3] = {0.0, 0.0, 0.0};
      for (int k = 0; k < dimension; ++k) {
        line.skipBlanks();
        const std::optional<double> number = line.number();
        if (!number) {
          return fail(line, std::to_string(dimension) + " numbers of a point");
        }
        numbers[k] = *number;
      }
      int multiplicity = 1;
      if (hasMultiplicity) {
        line.skipBlanks();
        const std::optional<int> read = line.integer();
        if (!read) {
          return fail(line, "the multiplicity of a point");
        }
        multiplicity = *read;
      }
      const std::size_t count = multiplicity > 0 ? static_cast<std::size_t>(multiplicity) : 0;
      if (count > kMostPoints - contour_.points.size()) {
        file_.warn(line.rangeFrom(begin), "a contour has at most " + std::to_string(kMostPoints) + " points",
                   kConsequence);
        return false;
      }
      if (!file_.spendPoints(count)) {
        file_.warn(line.rangeFrom(begin), "the files of one view file have too many points", kConsequence);
        return false;
      }
      contour_.points.insert(contour_.points.end(), count, Vec3{numbers[0], numbers[1], numbers[2]});
    }
    return true;
  }

  bool checkCount() {
    const std::size_t least = contour_.isClosed ? kLeastClosed : kLeastOpen;
    if (contour_.points.size() >= least) {
      return true;
    }
    file_.warn({0, 1},
               std::string(contour_.isClosed ? "a closed" : "an open") + " contour needs at least " +
                   std::to_string(least) + " points with their multiplicities, this one has " +
                   std::to_string(contour_.points.size()),
               kConsequence);
    return false;
  }

  bool fail(const TextCursor& at, const std::string& expected) {
    file_.warnExpected(at, expected, "a contour", kConsequence);
    return false;
  }

  static constexpr const char* kConsequence = "--compat cpfg uses the circle instead of this contour";
  const DataFile& file_;
  TextCursor cursor_;
  Contour& contour_;
};

}  // namespace

std::optional<Contour> readContourFile(const DataFile& file, int id) {
  Contour contour;
  contour.id = id;
  if (!ContourReader(file, contour).read()) {
    return std::nullopt;
  }
  return contour;
}

}  // namespace espalier::files
