#include "engine/files/curves/curve_file.h"

#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace espalier::files {
namespace {

using core::Vec3;

constexpr std::size_t kLeastPoints = 4;

ParametricCurve::Kind kindOf(std::string_view name) {
  if (name == "bspline-endpoint") {
    return ParametricCurve::Kind::BSplineEndPoint;
  }
  if (name == "bspline-closed") {
    return ParametricCurve::Kind::BSplineClosed;
  }
  if (name == "bspline-phantom") {
    return ParametricCurve::Kind::BSplinePhantom;
  }
  if (name == "bezier") {
    return ParametricCurve::Kind::Bezier;
  }
  if (name == "bezier-surface") {
    return ParametricCurve::Kind::BezierSurface;
  }
  return ParametricCurve::Kind::BSpline;
}

class CurveReader {
 public:
  explicit CurveReader(const DataFile& file) : file_(file), cursor_(file.cursor()) {}

  std::optional<ParametricCurve> read(int sampleCount) {
    std::vector<Vec3> points;
    while (!cursor_.atEnd() && (!expectedLines_ || readLines_ < *expectedLines_)) {
      TextCursor line = cursor_.takeLine();
      line.skipBlanks();
      if (line.atEnd() || line.rest().starts_with("//")) {
        continue;
      }
      if (!readKeyword(line) && !readPoint(line, points)) {
        return std::nullopt;
      }
      if (hasFailed_) {
        return std::nullopt;
      }
    }
    const std::size_t least =
        kind_ == ParametricCurve::Kind::BezierSurface ? ParametricCurve::kPatchPoints : kLeastPoints;
    if (!expectedLines_ || readLines_ < *expectedLines_) {
      file_.warnExpected(cursor_, expectedLines_ ? std::to_string(*expectedLines_) + " points" : "'points:'", "a curve",
                         kConsequence);
      return std::nullopt;
    }
    if (points.size() < least) {
      file_.warn(cursor_.rangeFrom(pointsBegin_),
                 "a curve of this type needs at least " + std::to_string(least) + " points, this one has " +
                     std::to_string(points.size()),
                 kConsequence);
      return std::nullopt;
    }
    ParametricCurve curve(kind_, std::move(points), sampleCount);
    if (!std::isfinite(curve.arcLength())) {
      file_.warn({0, 1}, "the curve is too long for a number", kConsequence);
      return std::nullopt;
    }
    return curve;
  }

 private:
  static constexpr const char* kConsequence = "this curve is the origin everywhere";

  /// Whether the line is a keyword line; sets hasFailed_ when the line has a mistake.
  bool readKeyword(TextCursor line) {
    const std::size_t colon = line.rest().find(':');
    if (colon == std::string_view::npos) {
      return false;
    }
    const std::size_t begin = line.position();
    const std::string_view keyword = line.rest().substr(0, colon);
    line.setPosition(begin + colon + 1);
    line.skipBlanks();
    if (keyword == "points") {
      if (expectedLines_) {
        file_.warn(line.rangeFrom(begin), "a curve inside a curve is not supported", kConsequence);
        hasFailed_ = true;
        return true;
      }
      expectedLines_ = readInteger(line, "'points:'");
      pointsBegin_ = begin;
    } else if (keyword == "dimension" || keyword == "dim") {
      dimension_ = readInteger(line, "'dimension:'");
      if (!hasFailed_ && (dimension_ < 2 || dimension_ > 4)) {
        file_.warn(line.rangeFrom(begin), "the dimension of a curve is 2, 3 or 4", kConsequence);
        hasFailed_ = true;
      }
    } else if (keyword == "type") {
      kind_ = kindOf(line.word());
    }
    // version, contact, end, heading, up, size, range and unknown keywords do not change the curve's points
    return true;
  }

  int readInteger(TextCursor& line, const std::string& keyword) {
    const std::optional<int> value = line.integer();
    if (!value) {
      file_.warnExpected(line, "an integer after " + keyword, "a curve", kConsequence);
      hasFailed_ = true;
    }
    return value.value_or(0);
  }

  bool readPoint(TextCursor line, std::vector<Vec3>& points) {
    const std::size_t begin = line.position();
    if (!expectedLines_) {
      file_.warnExpected(line, "a keyword or 'points:' before the first point", "a curve", kConsequence);
      return false;
    }
    double numbers[4] = {0.0, 0.0, 0.0, 1.0};
    for (int i = 0; i < dimension_; ++i) {
      line.skipBlanks();
      const std::optional<double> number = line.number();
      if (!number) {
        file_.warnExpected(line, std::to_string(dimension_) + " numbers of a point", "a curve", kConsequence);
        return false;
      }
      numbers[i] = *number;
    }
    if (!line.atLineEnd()) {
      file_.warnExpected(line, "the end of a point of " + std::to_string(dimension_) + " numbers", "a curve",
                         kConsequence);
      return false;
    }
    ++readLines_;
    if (numbers[3] >= static_cast<double>(kMostPoints - points.size())) {
      file_.warn(line.rangeFrom(begin), "a curve has at most " + std::to_string(kMostPoints) + " points", kConsequence);
      return false;
    }
    const std::size_t multiplicity = numbers[3] >= 1.0 ? static_cast<std::size_t>(numbers[3]) : 0;
    if (!file_.spendPoints(multiplicity)) {
      file_.warn(line.rangeFrom(begin), "the files of one view file have too many points", kConsequence);
      return false;
    }
    points.insert(points.end(), multiplicity, Vec3{numbers[0], numbers[1], numbers[2]});
    return true;
  }

  const DataFile& file_;
  TextCursor cursor_;
  std::optional<int> expectedLines_;  // of `points:`
  int readLines_ = 0;
  int dimension_ = 2;
  std::size_t pointsBegin_ = 0;
  ParametricCurve::Kind kind_ = ParametricCurve::Kind::BSpline;
  bool hasFailed_ = false;
};

}  // namespace

ParametricCurve zeroCurve() {
  return ParametricCurve(ParametricCurve::Kind::BSpline, std::vector<Vec3>(kLeastPoints), 2);
}

ParametricCurve readCurveFile(const DataFile& file, int sampleCount) {
  std::optional<ParametricCurve> curve = CurveReader(file).read(sampleCount);
  return curve ? std::move(*curve) : zeroCurve();
}

}  // namespace espalier::files
