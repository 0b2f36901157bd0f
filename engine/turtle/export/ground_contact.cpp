#include "engine/turtle/export/ground_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace espalier::turtle {

using core::Vec3;

namespace {

constexpr std::size_t kMostContacts = 200;  // more stems than that are a stand, whose ground is seen anyway
constexpr double kDeepestPart = 0.08;       // below the foot, of the height: hanging leaves
constexpr double kFlattest = 0.15;          // height over width of what stands
constexpr double kUpright = 0.4;            // cosine between the first line and the vertical
constexpr double kOfCrown = 0.55;           // radius over half the width
constexpr double kOfHeight = 0.1;           // least radius over the height

/// A stem with all that grows on it. A plant may have several: a stand is often one string.
struct Stem {
  explicit Stem(const Segment& first) : foot(first.start), plant(first.plant), low(first.start), high(first.start) {
    const Vec3 along = first.end - first.start;
    isUpright = along.y > kUpright * core::length(along);
  }
  void add(const Vec3& point) {
    low = {std::min(low.x, point.x), std::min(low.y, point.y), std::min(low.z, point.z)};
    high = {std::max(high.x, point.x), std::max(high.y, point.y), std::max(high.z, point.z)};
  }
  [[nodiscard]] double height() const { return high.y - low.y; }
  [[nodiscard]] double halfWidth() const { return 0.5 * std::max(high.x - low.x, high.z - low.z); }

  Vec3 foot;
  std::uint32_t plant;
  Vec3 low, high;  // corners of its box
  bool isUpright = false;
  bool hasParts = false;  // branches or organs
};

/// Lowest and highest point of a plant.
struct PlantHeights {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
};

class Stems {
 public:
  explicit Stems(const Scene& scene) {
    stemOf_.reserve(scene.segments.size());
    for (const Segment& segment : scene.segments) {
      if (segment.parent >= stemOf_.size()) {
        stemOf_.push_back(static_cast<std::uint32_t>(stems_.size()));
        stems_.emplace_back(segment);
      } else {
        stemOf_.push_back(stemOf_[segment.parent]);
      }
      Stem& stem = stems_[stemOf_.back()];
      stem.hasParts = stem.hasParts || segment.branchOrder > 0;
      stem.add(segment.start);
      stem.add(segment.end);
    }
    addOrgans(scene);
  }
  [[nodiscard]] const std::vector<Stem>& all() const { return stems_; }

 private:
  void addOrgan(std::uint32_t parent, const Vec3& place) {
    if (parent < stemOf_.size()) {
      Stem& stem = stems_[stemOf_[parent]];
      stem.hasParts = true;
      stem.add(place);
    }
  }
  void addOrgans(const Scene& scene) {
    for (const Polygon& polygon : scene.polygons) {
      std::ranges::for_each(polygon.vertices, [&](const Vec3& vertex) { addOrgan(polygon.parent, vertex); });
    }
    for (const SurfaceInstance& surface : scene.surfaces) {
      addOrgan(surface.parent, surface.position);
    }
    for (const Patch& patch : scene.patches) {
      addOrgan(patch.parent, patch.points.front());
    }
    for (const Ball& ball : scene.balls) {
      addOrgan(ball.parent, ball.centre);
    }
    for (const GeneralizedCylinder& cylinder : scene.cylinders) {
      for (const CylinderPoint& point : cylinder.points) {
        addOrgan(cylinder.parent, point.position);
      }
    }
  }

  std::vector<Stem> stems_;
  std::vector<std::uint32_t> stemOf_;  // by segment
};

}  // namespace

std::vector<GroundContact> groundContactsOf(const Scene& scene) {
  const Stems stems(scene);
  std::map<std::uint32_t, PlantHeights> plants;
  for (const Stem& stem : stems.all()) {
    PlantHeights& plant = plants[stem.plant];
    plant.low = std::min(plant.low, stem.low.y);
    plant.high = std::max(plant.high, stem.high.y);
  }
  std::vector<GroundContact> contacts;
  for (const Stem& stem : stems.all()) {
    // a stem that begins higher hangs on another one
    const PlantHeights& plant = plants[stem.plant];
    const bool stands = stem.isUpright && stem.hasParts && stem.height() > kFlattest * stem.halfWidth() &&
                        stem.foot.y - plant.low <= kDeepestPart * (plant.high - plant.low);
    if (stands && std::isfinite(stem.height())) {
      contacts.push_back({stem.foot, std::max(kOfCrown * stem.halfWidth(), kOfHeight * stem.height())});
    }
  }
  if (contacts.size() > kMostContacts) {
    contacts.clear();
  }
  return contacts;
}

}  // namespace espalier::turtle
