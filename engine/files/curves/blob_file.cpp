#include "engine/files/curves/blob_file.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace espalier::files {
namespace {

using core::Vec3;

// the reference adds the segment of an `L` line twice
constexpr double kLineWeight = 2.0;

std::vector<double> numbersOf(TextCursor line, std::size_t most) {
  std::vector<double> numbers;
  while (numbers.size() < most) {
    line.skipBlanks();
    const std::optional<double> number = line.number();
    if (!number) {
      break;
    }
    numbers.push_back(*number);
  }
  return numbers;
}

class BlobReader {
 public:
  explicit BlobReader(const DataFile& file) : file_(file), cursor_(file.cursor()) {}

  BlobField read() {
    while (!cursor_.atEnd()) {
      TextCursor line = cursor_.takeLine();
      line.skipBlanks();
      if (!line.atEnd()) {
        readLine(line);
      }
    }
    finishObject();
    return std::move(field_);
  }

 private:
  enum class Open : unsigned char { Nothing, Segment, Point };

  void readLine(TextCursor line) {
    const TextCursor begin = line;
    const char command = line.peek();
    line.setPosition(line.position() + 1);
    switch (command) {
      case '#':
        return;
      case 'L':
        return readWholeSegment(begin, numbersOf(line, 8));
      case 'l':
      case 'e':
        finishObject();
        open_ = command == 'l' ? Open::Segment : Open::Point;
        object_ = {};
        object_.startRadius = object_.endRadius = defaultRadius_;
        endCount_ = 0;
        return;
      case 'o':
        return readEnd(begin, numbersOf(line, 3));
      case 'r':
        return readRadii(begin, numbersOf(line, 2));
      case 'a':
        return readAxes(begin, numbersOf(line, 9));
      case 'q':
        return finishObject();
      default:
        file_.warnExpected(begin, "one of # L l e o r a q", "a blob field", "the line is ignored");
    }
  }

  void readWholeSegment(const TextCursor& at, const std::vector<double>& n) {
    if (n.size() < 6) {
      return file_.warnExpected(at, "six coordinates after 'L'", "a blob field", "the line is ignored");
    }
    BlobField::Object object;
    object.start = {n[0], n[1], n[2]};
    object.end = {n[3], n[4], n[5]};
    object.startRadius = n.size() > 6 ? n[6] : defaultRadius_;
    object.endRadius = n.size() > 7 ? n[7] : object.startRadius;
    object.weight = kLineWeight;
    field_.add(object);
  }

  void readEnd(const TextCursor& at, const std::vector<double>& n) {
    if (n.size() < 3 || open_ == Open::Nothing) {
      return file_.warnExpected(at, open_ == Open::Nothing ? "'l' or 'e' before 'o'" : "three coordinates after 'o'",
                                "a blob field", "the line is ignored");
    }
    (endCount_ == 0 ? object_.start : object_.end) = {n[0], n[1], n[2]};
    if (endCount_ == 0) {
      object_.end = object_.start;
    }
    ++endCount_;
  }

  void readRadii(const TextCursor& at, const std::vector<double>& n) {
    if (n.empty()) {
      return file_.warnExpected(at, "a radius after 'r'", "a blob field", "the line is ignored");
    }
    if (open_ == Open::Nothing) {
      defaultRadius_ = n[0];
      return;
    }
    object_.startRadius = n[0];
    object_.endRadius = n.size() > 1 ? n[1] : n[0];
  }

  void readAxes(const TextCursor& at, const std::vector<double>& n) {
    if (n.size() < 9 || open_ != Open::Point) {
      return file_.warnExpected(at, open_ == Open::Point ? "nine numbers after 'a'" : "'e' before 'a'", "a blob field",
                                "the line is ignored");
    }
    object_.isEllipsoid = true;
    for (std::size_t i = 0; i < 3; ++i) {
      object_.axes[i] = {n[3 * i], n[3 * i + 1], n[3 * i + 2]};
    }
  }

  void finishObject() {
    if (open_ != Open::Nothing && endCount_ > 0) {
      field_.add(object_);
    }
    open_ = Open::Nothing;
  }

  const DataFile& file_;
  TextCursor cursor_;
  BlobField field_;
  Open open_ = Open::Nothing;
  BlobField::Object object_;
  int endCount_ = 0;
  double defaultRadius_ = 2.0;
};

/// Squared distance of a point from an object, in units of the object's radius there.
double relativeDistanceSquared(const BlobField::Object& object, const Vec3& point) {
  const Vec3 away = point - object.start;
  if (object.isEllipsoid) {
    double sum = 0.0;
    for (const Vec3& axis : object.axes) {
      const double along = core::dot(away, axis) / core::dot(axis, axis);
      sum += along * along;
    }
    return sum;
  }
  const Vec3 direction = object.end - object.start;
  const double lengthSquared = core::dot(direction, direction);
  const double share = lengthSquared > 0.0 ? std::clamp(core::dot(away, direction) / lengthSquared, 0.0, 1.0) : 0.0;
  const double radius = object.startRadius + share * (object.endRadius - object.startRadius);
  const Vec3 offset = away - direction * share;
  return core::dot(offset, offset) / (radius * radius);
}

}  // namespace

double BlobField::value(const core::Vec3& point) const {
  // Wyvill, McPheeters & Wyvill 1986: a cubic of the squared distance, 1 at the centre and 0 at the radius
  double sum = 0.0;
  for (const Object& object : objects_) {
    const double q = relativeDistanceSquared(object, point);
    if (q < 1.0) {
      sum += object.weight * (1.0 + q * (-2.444444 + q * (1.888889 - 0.444444 * q)));
    }
  }
  return sum;
}

BlobField readBlobFile(const DataFile& file) {
  return BlobReader(file).read();
}

}  // namespace espalier::files
