#include "engine/core/polygon.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>

#include "engine/core/index_lists.h"
#include "engine/core/index_set.h"
#include "engine/core/point_grid.h"
#include "engine/core/work_meter.h"

namespace espalier::core {

namespace {

using Point = std::array<double, 2>;

// twice the signed area of a triangle
double doubleArea(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// the plane's axes, right-handed with the unit vector `normal`
std::array<Vec3, 2> planeAxes(const Vec3& normal) {
  const Vec3 other = std::abs(normal.x) < 0.9 ? Vec3{1.0, 0.0, 0.0} : Vec3{0.0, 1.0, 0.0};
  const Vec3 u = normalised(cross(other, normal));
  return {u, cross(normal, u)};
}

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

constexpr std::uint32_t kNone = IndexLists::kNone;
constexpr std::size_t kManyCorners = 64;             // from which a grid saves more than it costs
constexpr std::uint32_t kCornersBetweenPolls = 256;  // looked at

/// The corners that a polygon still has while others are cut off.
class Ring {
 public:
  explicit Ring(const std::vector<Point>& points) : points_(points), next_(points.size()), before_(points.size()) {
    const auto count = static_cast<std::uint32_t>(points.size());
    for (std::uint32_t i = 0; i < count; ++i) {
      next_[i] = (i + 1) % count;
      before_[i] = (i + count - 1) % count;
    }
  }

  [[nodiscard]] std::uint32_t next(std::uint32_t i) const { return next_[i]; }
  [[nodiscard]] std::uint32_t before(std::uint32_t i) const { return before_[i]; }
  [[nodiscard]] const Point& point(std::uint32_t i) const { return points_[i]; }
  /// Whether a corner was not cut off.
  [[nodiscard]] bool has(std::uint32_t i) const { return next_[before_[i]] == i; }
  [[nodiscard]] std::array<std::uint32_t, 3> triangleAt(std::uint32_t i) const { return {before_[i], i, next_[i]}; }

  /// Twice the area of the triangle at a corner. Above 0: the corner is convex.
  [[nodiscard]] double turnAt(std::uint32_t i) const {
    return doubleArea(points_[before_[i]], points_[i], points_[next_[i]]);
  }

  /// Whether the convex triangle at corner i has corner k in it or on it.
  [[nodiscard]] bool isInside(std::uint32_t k, std::uint32_t i) const {
    const Point& a = points_[before_[i]];
    const Point& b = points_[i];
    const Point& c = points_[next_[i]];
    const Point& p = points_[k];
    // a vertex at a corner is allowed: polygons may touch themselves
    return p != a && p != b && p != c && doubleArea(a, b, p) >= 0.0 && doubleArea(b, c, p) >= 0.0 &&
           doubleArea(c, a, p) >= 0.0;
  }

  void cutOff(std::uint32_t i) {
    next_[before_[i]] = next_[i];
    before_[next_[i]] = before_[i];
  }

 private:
  const std::vector<Point>& points_;
  std::vector<std::uint32_t> next_, before_;
};

// convex, and no other vertex inside or on the triangle
bool isEar(const Ring& ring, std::uint32_t i) {
  if (!(ring.turnAt(i) > 0.0)) {
    return false;
  }
  for (std::uint32_t k = ring.next(ring.next(i)); k != ring.before(i); k = ring.next(k)) {
    if (!(ring.turnAt(k) > 0.0) && ring.isInside(k, i)) {
      return false;
    }
  }
  return true;
}

// the triangles of a polygon of few corners: goes round and compares each corner with all others
Triangles clipFew(const std::vector<Point>& points) {
  Ring ring(points);
  Triangles triangles;
  auto left = static_cast<std::uint32_t>(points.size());
  triangles.reserve(left);
  std::uint32_t at = 0;
  std::uint32_t tried = 0;
  std::uint32_t bestFallback = 0;
  while (left > 3) {
    const bool isFlat = ring.turnAt(at) == 0.0;
    if (isFlat || isEar(ring, at) || tried == left) {
      // a polygon that crosses itself may have no ear: cut off the corner that turns most
      const std::uint32_t cut = tried == left ? bestFallback : at;
      triangles.push_back(ring.triangleAt(cut));
      ring.cutOff(cut);
      at = ring.next(ring.next(cut));
      --left;
      tried = 0;
      bestFallback = at;
      continue;
    }
    if (ring.turnAt(at) > ring.turnAt(bestFallback)) {
      bestFallback = at;
    }
    at = ring.next(at);
    ++tried;
  }
  triangles.push_back(ring.triangleAt(at));
  return triangles;
}

/// Cuts a polygon of many corners: goes round as clipFew() and cuts the same corners, but passes over those that are
/// known to be no ears. A corner that is no ear stays so until its triangle changes or the corner in it that was found,
/// its blocker, is gone or becomes convex.
class ManyCornersClipper {
 public:
  explicit ManyCornersClipper(const std::vector<Point>& points);

  [[nodiscard]] Triangles clip();

 private:
  [[nodiscard]] std::uint32_t nextOpen(std::uint32_t at) const;
  [[nodiscard]] bool isEar(std::uint32_t i);
  [[nodiscard]] std::uint32_t cornerThatTurnsMost(std::uint32_t at);
  void cutOff(std::uint32_t i);
  void triangleChanged(std::uint32_t i);
  void setHollow(std::uint32_t i, bool isHollow);
  void removeBlocker(std::uint32_t i);

  struct Turn {
    double doubleArea;
    std::uint32_t corner;
    // of equal turns the corner with the lower number is cut first
    bool operator<(const Turn& other) const {
      return doubleArea != other.doubleArea ? doubleArea < other.doubleArea : corner > other.corner;
    }
  };

  Ring ring_;
  std::uint32_t left_;                   // corners of the ring
  IndexSet open_;                        // the corners of the ring that may be ears
  PointGrid hollows_;                    // the corners of the ring that are not convex; only these can lie in an ear
  std::vector<bool> isHollow_;           // by corner
  IndexLists blocked_;                   // by blocker: the corners that it keeps from being ears
  std::vector<std::uint32_t> blockers_;  // by corner; kNone: it is open, gone or not convex
  // the turns of all corners, from the first time that no corner is an ear. Also holds turns that have changed since
  std::optional<std::priority_queue<Turn>> turns_;
};

ManyCornersClipper::ManyCornersClipper(const std::vector<Point>& points)
    : ring_(points),
      left_(static_cast<std::uint32_t>(points.size())),
      open_(left_),
      hollows_(points),
      isHollow_(left_),
      blocked_(left_, left_),
      blockers_(left_, kNone) {
  for (std::uint32_t i = 0; i < left_; ++i) {
    open_.insert(i);
    setHollow(i, !(ring_.turnAt(i) > 0.0));
  }
}

Triangles ManyCornersClipper::clip() {
  Triangles triangles;
  triangles.reserve(left_);
  std::uint32_t at = 0;
  std::uint32_t looks = 0;
  while (left_ > 3) {
    if (++looks % kCornersBetweenPolls == 0) {
      pollWork();
    }
    std::uint32_t cut = nextOpen(at);
    if (cut == kNone) {
      // a polygon that crosses itself may have no ear
      cut = cornerThatTurnsMost(at);
    } else if (ring_.turnAt(cut) != 0.0 && !isEar(cut)) {
      open_.erase(cut);
      continue;
    }
    triangles.push_back(ring_.triangleAt(cut));
    cutOff(cut);
    at = ring_.next(ring_.next(cut));
  }
  triangles.push_back(ring_.triangleAt(at));
  return triangles;
}

// the first open corner from `at` on round the ring; kNone: there is none
std::uint32_t ManyCornersClipper::nextOpen(std::uint32_t at) const {
  const std::uint32_t corner = open_.from(at);
  return corner != kNone ? corner : open_.from(0);
}

// convex, and no other vertex inside or on the triangle. Notes the blocker
bool ManyCornersClipper::isEar(std::uint32_t i) {
  if (isHollow_[i]) {
    return false;
  }
  const std::uint32_t blocker =
      hollows_.findNear(ring_.point(ring_.before(i)), ring_.point(i), ring_.point(ring_.next(i)),
                        [&](std::uint32_t k) { return ring_.isInside(k, i); });
  if (blocker == kNone) {
    return true;
  }
  blocked_.insert(blocker, i);
  blockers_[i] = blocker;
  return false;
}

std::uint32_t ManyCornersClipper::cornerThatTurnsMost(std::uint32_t at) {
  if (!turns_) {
    turns_.emplace();
    for (std::uint32_t left = left_; left > 0; --left, at = ring_.next(at)) {
      turns_->push({ring_.turnAt(at), at});
    }
  }
  while (!turns_->empty()) {
    const Turn turn = turns_->top();
    turns_->pop();
    if (ring_.has(turn.corner) && ring_.turnAt(turn.corner) == turn.doubleArea) {
      return turn.corner;
    }
  }
  return at;  // the areas are no numbers
}

void ManyCornersClipper::cutOff(std::uint32_t i) {
  ring_.cutOff(i);
  --left_;
  open_.erase(i);
  removeBlocker(i);
  setHollow(i, false);
  triangleChanged(ring_.before(i));
  triangleChanged(ring_.next(i));
}

void ManyCornersClipper::triangleChanged(std::uint32_t i) {
  removeBlocker(i);
  open_.insert(i);
  const double turn = ring_.turnAt(i);
  setHollow(i, !(turn > 0.0));
  if (turns_) {
    turns_->push({turn, i});
  }
}

void ManyCornersClipper::setHollow(std::uint32_t i, bool isHollow) {
  if (isHollow == isHollow_[i]) {
    return;
  }
  isHollow_[i] = isHollow;
  if (isHollow) {
    hollows_.insert(i);
    return;
  }
  hollows_.remove(i);
  // it blocks no corner any longer
  for (std::uint32_t k = blocked_.first(i); k != kNone; k = blocked_.first(i)) {
    removeBlocker(k);
    open_.insert(k);
  }
}

void ManyCornersClipper::removeBlocker(std::uint32_t i) {
  if (blockers_[i] != kNone) {
    blocked_.remove(blockers_[i], i);
    blockers_[i] = kNone;
  }
}

}  // namespace

Vec3 newellNormal(std::span<const Vec3> vertices) {
  Vec3 normal;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    normal = normal + cross(vertices[i] - vertices[0], vertices[(i + 1) % vertices.size()] - vertices[0]);
  }
  return normal;
}

std::vector<std::array<double, 2>> projectedCorners(std::span<const Vec3> vertices, const Vec3& normal) {
  const auto [u, v] = planeAxes(normal);
  std::vector<Point> points;
  points.reserve(vertices.size());
  // relative to the first vertex, so that areas far from the origin keep their digits
  for (const Vec3& vertex : vertices) {
    points.push_back({dot(vertex - vertices[0], u), dot(vertex - vertices[0], v)});
  }
  return points;
}

std::vector<std::array<std::uint32_t, 3>> triangulate(std::span<const Vec3> vertices, const Vec3& normal) {
  if (vertices.size() < 3) {
    return {};
  }
  const std::vector<Point> points = projectedCorners(vertices, normalised(normal));
  return points.size() < kManyCorners ? clipFew(points) : ManyCornersClipper(points).clip();
}

}  // namespace espalier::core
